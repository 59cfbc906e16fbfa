//! Test scenes and the parts of tests that several files share.

mod direct;
mod emission;
mod environment;
mod infinite;
mod lanes;
mod points;
mod tree;

use super::*;
use crate::geometry::{Mesh, Primitive, Shape};
use crate::ids::{MaterialId, ShapeId, TextureId};
use crate::math::{Affine3A, Mat3, Vec2, octahedral};
use crate::sampling::{Sampler, Stream};
use crate::texture::{Bitmap, ColorInput, Filtering, Wrap};
use std::f32::consts::PI;

fn picture() -> Image {
    let data = (0..72).map(|i| ((i * 37) % 64) as f32 / 64.0).collect();
    Image {
        width: 6,
        height: 4,
        channels: 3,
        data,
    }
}

/// 50 degrees around (1, 2, 3).
fn rotation() -> Mat3 {
    Mat3::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 50f32.to_radians())
}

/// Compares frequencies over cells of the sphere with the integral of the density: Pearson's
/// statistic over cells with at least ten expected samples must stay within six deviations of its
/// mean.
fn check_directions(
    n: usize,
    mut sample: impl FnMut(Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) {
    const SIDE: usize = 12;
    const SUB: usize = 24;
    let cell = |w: Vec3| {
        let q = octahedral::square_from_direction(w) * SIDE as f32;
        (q.y as usize).min(SIDE - 1) * SIDE + (q.x as usize).min(SIDE - 1)
    };
    let mut observed = vec![0.0f64; SIDE * SIDE];
    let mut sampler = Sampler::new(3, 0, Stream::Test, 0);
    for _ in 0..n {
        if let Some(w) = sample(sampler.next_2d()) {
            assert!((w.length() - 1.0).abs() < 1e-4);
            observed[cell(w)] += 1.0;
        }
    }
    let mut expected = vec![0.0f64; SIDE * SIDE];
    let side = SIDE * SUB;
    for i in 0..side * side {
        let uv = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let w = octahedral::direction_from_square(uv);
        let share = f64::from(octahedral::solid_angle_density(uv)) / (side * side) as f64;
        expected[cell(w)] += f64::from(pdf(w)) * share * n as f64;
    }
    let (mut chi2, mut cells) = (0.0, 0.0f64);
    for (o, e) in observed.iter().zip(&expected) {
        if *e >= 10.0 {
            chi2 += (o - e).powi(2) / e;
            cells += 1.0;
        } else {
            assert!(
                *o <= e + 6.0 * e.sqrt() + 6.0,
                "{o} samples where {e} are expected"
            );
        }
    }
    assert!(cells > 3.0, "the density is spread over cells");
    let deviation = (chi2 - cells) / (2.0 * cells).sqrt();
    assert!(deviation < 6.0, "chi² {chi2} over {cells} cells");
}

fn infinite_emitters() -> Vec<Emitter> {
    vec![
        Emitter::Constant {
            radiance: Rgb::new(0.2, 0.3, 0.1),
        },
        Emitter::Directional {
            direction: Vec3::new(0.3, -0.8, 0.1).normalize(),
            irradiance: Rgb::splat(2.0),
        },
        Emitter::Environment(Environment {
            image: picture(),
            scale: 1.5,
            world_from_emitter: rotation(),
        }),
    ]
}

/// The first texture of the test worlds, projected along z.
fn projector() -> ProjectorTexture {
    ProjectorTexture {
        texture: TextureId(0),
        axes: [Vec3::X, Vec3::Y],
        window: None,
    }
}

/// A scene of shapes, each with at most one area emitter, and other emitters.
struct World {
    geometry: Geometry,
    textures: Vec<Texture>,
    emitters: Emitters,
    guide: EmissionGuide,
}

impl World {
    fn sample_guided(
        &self,
        receiver: (Vec3, Option<Vec3>),
        lobes: &EnvironmentLobes,
        numbers: (f32, Vec2),
    ) -> Option<DirectSample> {
        let (geometry, textures) = (&self.geometry, &self.textures);
        (self.emitters).sample(geometry, textures, receiver, numbers, Some(lobes))
    }

    fn sample(&self, p: Vec3, n: Option<Vec3>, u_choice: f32, u: Vec2) -> Option<DirectSample> {
        let (geometry, textures) = (&self.geometry, &self.textures);
        (self.emitters).sample(geometry, textures, (p, n), (u_choice, u), None)
    }
}

struct Placed {
    shape: Shape,
    world_from_object: Affine3A,
    flip_normals: bool,
    radiance: Option<ColorInput>,
}

impl Placed {
    fn new(shape: Shape, world_from_object: Affine3A) -> Self {
        let radiance = Some(ColorInput::Constant(Rgb::new(1.0, 2.0, 0.5)));
        Placed {
            shape,
            world_from_object,
            flip_normals: false,
            radiance,
        }
    }

    fn flipped(self) -> Self {
        Placed {
            flip_normals: !self.flip_normals,
            ..self
        }
    }

    fn textured(self) -> Self {
        Placed {
            radiance: Some(ColorInput::Texture(TextureId(0))),
            ..self
        }
    }

    fn dark(self) -> Self {
        Placed {
            radiance: None,
            ..self
        }
    }
}

fn world(placed: Vec<Placed>, others: Vec<Emitter>) -> World {
    let bitmap = Bitmap {
        image: picture(),
        filtering: Filtering::Bilinear,
        wrap: [Wrap::Repeat; 2],
        uv_transform: Mat3::IDENTITY,
    };
    let textures = vec![Texture::Bitmap(bitmap)];
    let (mut shapes, mut primitives, mut emitters) = (Vec::new(), Vec::new(), Vec::new());
    for Placed {
        shape,
        world_from_object,
        flip_normals,
        radiance,
    } in placed
    {
        let emitter = radiance.map(|radiance| {
            emitters.push(Emitter::Area { radiance });
            EmitterId::from(emitters.len() - 1)
        });
        primitives.push(Primitive {
            shape: ShapeId::from(shapes.len()),
            world_from_object,
            flip_normals,
            material: MaterialId(0),
            emitter,
            transparent: false,
            invisible: false,
        });
        shapes.push(shape);
    }
    emitters.extend(others);
    let geometry = Geometry::build(shapes, primitives, Vec::new(), Vec::new());
    let emitters = Emitters::new(emitters, &geometry, &textures);
    World {
        geometry,
        textures,
        emitters,
        guide: EmissionGuide::default(),
    }
}

/// A transform to a place in front of the receivers below.
fn placement(scale: Vec3) -> Affine3A {
    Affine3A::from_translation(Vec3::new(0.2, -0.1, 1.5))
        * Affine3A::from_axis_angle(Vec3::new(0.3, 1.0, 0.2).normalize(), 2.6)
        * Affine3A::from_scale(scale)
}

/// A coarse ball with interpolated normals.
fn smooth_ball() -> Mesh {
    let (rings, segments) = (4u32, 6u32);
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..=segments {
            let (theta, phi) = (
                i as f32 / rings as f32 * PI,
                j as f32 / segments as f32 * 2.0 * PI,
            );
            let p = Vec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            mesh.positions.push(p);
            mesh.normals.push(p);
            mesh.uvs.push(Vec2::new(
                j as f32 / segments as f32,
                i as f32 / rings as f32,
            ));
        }
    }
    for i in 0..rings {
        for j in 0..segments {
            let a = i * (segments + 1) + j;
            let b = a + segments + 1;
            mesh.triangles.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
        }
    }
    mesh
}

fn sphere_shape() -> Shape {
    Shape::Sphere {
        center: Vec3::new(0.1, 0.0, 0.2),
        radius: 0.6,
    }
}

fn cylinder() -> Shape {
    Shape::Cylinder {
        p0: Vec3::new(0.0, 0.1, -0.4),
        p1: Vec3::new(0.1, 0.0, 0.5),
        radius: 0.3,
    }
}

/// Area emitters of every shape.
fn emissive_worlds() -> Vec<(&'static str, World)> {
    let half = Vec3::splat(0.5);
    let uneven = Vec3::new(0.4, 0.7, 0.5);
    let one = |placed: Placed| world(vec![placed], vec![]);
    vec![
        (
            "rectangle",
            one(Placed::new(Shape::Mesh(Mesh::rectangle()), placement(half))),
        ),
        (
            "textured rectangle",
            one(Placed::new(Shape::Mesh(Mesh::rectangle()), placement(uneven)).textured()),
        ),
        (
            "cube",
            one(Placed::new(Shape::Mesh(Mesh::cube()), placement(uneven))),
        ),
        (
            "smooth ball",
            one(Placed::new(Shape::Mesh(smooth_ball()), placement(half)).textured()),
        ),
        (
            "inside-out ball",
            one(Placed::new(Shape::Mesh(smooth_ball()), placement(Vec3::splat(4.0))).flipped()),
        ),
        ("sphere", one(Placed::new(sphere_shape(), placement(half)))),
        (
            "textured sphere",
            one(Placed::new(sphere_shape(), placement(half)).textured()),
        ),
        (
            "mirrored sphere",
            one(Placed::new(
                sphere_shape(),
                placement(Vec3::new(-4.0, 4.0, 4.0)),
            )),
        ),
        (
            "ellipsoid",
            one(Placed::new(sphere_shape(), placement(uneven))),
        ),
        ("disk", one(Placed::new(Shape::Disk, placement(uneven)))),
        ("cylinder", one(Placed::new(cylinder(), placement(half)))),
        (
            "elliptic cylinder",
            one(Placed::new(cylinder(), placement(uneven)).flipped()),
        ),
        ("several", several()),
    ]
}

fn several() -> World {
    let half = Vec3::splat(0.5);
    world(
        vec![
            Placed::new(Shape::Mesh(Mesh::rectangle()), placement(half)),
            Placed::new(
                sphere_shape(),
                Affine3A::from_translation(Vec3::new(-1.5, 0.0, 1.0)),
            ),
            Placed::new(
                Shape::Mesh(smooth_ball()),
                Affine3A::from_translation(Vec3::new(2.5, 1.0, 0.5)),
            ),
        ],
        vec![Emitter::Constant {
            radiance: Rgb::splat(0.05),
        }],
    )
}

fn receivers() -> [(Vec3, Option<Vec3>); 3] {
    [
        (
            Vec3::new(0.1, 0.2, 0.3),
            Some(Vec3::new(0.1, -0.1, 1.0).normalize()),
        ),
        (Vec3::new(-0.4, 0.5, 3.0), Some(-Vec3::Z)),
        (Vec3::new(0.6, -0.9, 0.7), None),
    ]
}

fn emit(world: &World, numbers: &mut Sampler) -> Option<EmissionSample> {
    let u = EmissionNumbers {
        emitter: numbers.next_1d(),
        position: numbers.next_2d(),
        direction: numbers.next_2d(),
        element: numbers.next_1d(),
    };
    (world.guide).sample(&world.emitters, &world.geometry, &world.textures, u)
}
