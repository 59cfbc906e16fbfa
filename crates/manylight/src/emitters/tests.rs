//! Samplers against their densities, and values of Mitsuba 3.9.1.

use super::distant::{BoundingSphere, Distant, EmissionPoint};
use super::environment::EnvironmentSampler;
use super::light_tree::LightTree;
use super::parts::PartBounds;
use super::point::point_power;
use super::*;
use crate::geometry::{Mesh, Primitive, Segment, Shape};
use crate::ids::{MaterialId, ShapeId, TextureId};
use crate::image::Image;
use crate::math::Aabb;
use crate::math::{Affine3A, Cone, Mat3, octahedral};
use crate::sampling::{Sampler, Stream};
use crate::texture::{Bitmap, Filtering, Wrap};

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

/// Compares frequencies over cells of the sphere with the integral of the density: Pearson's statistic over cells with at
/// least ten expected samples must stay within six deviations of its mean.
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

#[test]
fn environment_lookups_match_mitsuba() {
    let mut environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: Mat3::IDENTITY,
    };
    let upright = [
        (
            [0.618984, -0.7751, 0.126804],
            [0.954825, 0.511041, 0.769253],
        ),
        (
            [-0.749577, -0.597593, -0.284634],
            [0.945529, 0.422132, 1.121876],
        ),
        (
            [-0.914149, -0.104961, -0.391554],
            [0.727529, 0.694093, 0.961904],
        ),
        (
            [-0.587884, 0.724993, -0.358857],
            [0.551554, 1.007036, 0.589688],
        ),
        ([0.0, 1.0, 0.0], [0.503906, 0.621094, 0.738281]),
        ([0.0001, 0.0, -1.0], [0.668016, 0.785203, 0.902391]),
    ];
    let rotated = [
        (
            [-0.090628, 0.267923, 0.959168],
            [0.951603, 0.438022, 0.840337],
        ),
        (
            [-0.252895, -0.22845, 0.940136],
            [0.71637, 0.560864, 0.950745],
        ),
        ([0.651207, 0.10269, 0.75192], [0.747354, 0.894906, 0.445967]),
        ([0.0, 1.0, 0.0], [0.476208, 0.923307, 0.710583]),
    ];
    let check = |environment: &Environment, cases: &[([f32; 3], [f32; 3])]| {
        for &(w, value) in cases {
            let sampler = EnvironmentSampler::new(environment).unwrap();
            let difference = sampler.look_up(Vec3::from(w)).radiance - Rgb::from(value);
            assert!(
                difference.map(f32::abs).max_channel() < 1e-4,
                "at {w:?}: off by {difference:?}"
            );
        }
    };
    check(&environment, &upright);
    environment.world_from_emitter = rotation();
    check(&environment, &rotated);
}

#[test]
fn environment_samples_follow_their_density() {
    let environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    check_directions(
        200_000,
        |u| Some(sampler.sample(u).wi),
        |w| sampler.look_up(w).pdf,
    );
}

#[test]
fn a_small_sun_is_sampled_well() {
    let mut image = Image::new(64, 32, 3);
    image.data.fill(0.1);
    image.data[(9 * 64 + 20) * 3..][..3].fill(2e4);
    let environment = Environment {
        image,
        scale: 1.0,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    let mut numbers = Sampler::new(5, 0, Stream::Test, 0);
    let total = sampler.total().g;
    for _ in 0..5000 {
        let wi = sampler.sample(numbers.next_2d()).wi;
        let seen = sampler.look_up(wi);
        let weight = seen.radiance.g / seen.pdf;
        assert!(
            (0.6..1.5).contains(&(weight / total)),
            "weight {weight} for {total}"
        );
    }
}

#[test]
fn pictures_without_extent_or_light_are_harmless() {
    for (width, height) in [(1, 1), (1, 5), (5, 1), (4, 2)] {
        let mut image = Image::new(width, height, 3);
        let black = Environment {
            image: image.clone(),
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        assert!(EnvironmentSampler::new(&black).is_none());
        image.data.fill(2.0);
        let bright = Environment {
            image,
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        let sampler = EnvironmentSampler::new(&bright).unwrap();
        assert!((sampler.total().r - 8.0 * PI).abs() < 1e-3);
        check_directions(
            20_000,
            |u| Some(sampler.sample(u).wi),
            |w| sampler.look_up(w).pdf,
        );
    }
}

fn sphere() -> BoundingSphere {
    BoundingSphere::new(Aabb {
        min: Vec3::new(-1.0, 0.0, 2.0),
        max: Vec3::new(2.0, 1.0, 4.0),
    })
}

fn distant_emitters() -> Vec<Emitter> {
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

#[test]
fn distant_directions_follow_their_density() {
    let emitters = distant_emitters();
    let distant = Distant::new(&emitters, sphere());
    for n in [None, Some(Vec3::new(0.2, 0.9, -0.3).normalize())] {
        let mut choice = Sampler::new(4, 0, Stream::Test, 1);
        check_directions(
            200_000,
            |u| {
                let sample = distant.sample(n, &distant.plan(choice.next_1d(), u));
                sample.parallel.is_none().then_some(sample.wi)
            },
            |w| distant.look_up(n, w).1,
        );
    }
}

#[test]
fn distant_emission_crosses_the_sphere_evenly() {
    let emitters = distant_emitters();
    let distant = Distant::new(&emitters, sphere());
    let BoundingSphere { center, radius } = sphere();
    let mut numbers = Sampler::new(6, 0, Stream::Test, 0);
    for (emitter, power) in distant.powers() {
        let n = 40_000;
        let (mut flux, mut inner) = (0.0f64, 0.0f64);
        for _ in 0..n {
            let u = EmissionPoint {
                position: numbers.next_2d(),
                direction: numbers.next_2d(),
                guide: 0.5,
            };
            let (ray, sample_flux) = distant.emit(emitter, None, u).unwrap();
            let to_center = center - ray.o;
            let along = to_center.dot(ray.d);
            let miss = (to_center - ray.d * along).length();
            assert!(along > 0.0 && to_center.length() > 0.999 * radius && miss < 1.001 * radius);
            flux += f64::from(sample_flux.g) / f64::from(n);
            inner += f64::from(u8::from(miss < 0.5 * radius)) / f64::from(n);
        }
        assert!(
            (flux / f64::from(power.g) - 1.0).abs() < 0.02,
            "{emitter:?}: {flux} for {power:?}"
        );
        assert!((inner - 0.25).abs() < 0.015, "{emitter:?}: {inner}");
    }
}

#[test]
fn bounding_spheres_never_vanish() {
    for bounds in [
        Aabb::EMPTY,
        Aabb::from_points([Vec3::ZERO]),
        Aabb::from_points([Vec3::splat(1e4)]),
    ] {
        assert!(BoundingSphere::new(bounds).radius > 0.0);
    }
}

#[test]
fn spots_match_mitsuba() {
    let degrees = [0.0f32, 5.0, 12.0, 16.0, 19.9, 25.0, 29.0, 31.0];
    let cases = [
        (20.0f32, 15.0f32, [2.0, 2.0, 2.0, 1.6, 0.04, 0.0, 0.0, 0.0]),
        (30.0, 10.0, [2.0, 2.0, 1.8, 1.4, 1.01, 0.5, 0.1, 0.0]),
        (30.0, 30.0, [2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0]),
    ];
    for (cutoff, beam_width, values) in cases {
        let spot = Emitter::Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Rgb::splat(2.0),
            cutoff: cutoff.to_radians(),
            beam_width: beam_width.to_radians(),
            slide: None,
        };
        let intensity = |angle: f32| {
            spot.point_intensity(&[], Vec3::new(angle.sin(), 0.0, angle.cos()))
                .r
        };
        for (angle, value) in degrees.into_iter().zip(values) {
            assert!(
                (intensity(angle.to_radians()) - value).abs() < 1e-3,
                "{cutoff} {beam_width} at {angle}"
            );
        }
        let n = 20_000;
        let step = PI / n as f32;
        let power: f64 = (0..n)
            .map(|i| (i as f32 + 0.5) * step)
            .map(|angle| f64::from(intensity(angle) * angle.sin() * 2.0 * PI * step))
            .sum();
        assert!((f64::from(point_power(&spot, &[]).g) / power - 1.0).abs() < 1e-3);
    }
}

/// The first texture of the test worlds, thrown along z.
fn slide() -> ProjectorTexture {
    ProjectorTexture {
        texture: TextureId(0),
        axes: [Vec3::X, Vec3::Y],
    }
}

#[test]
fn slides_match_mitsuba() {
    let image = Image {
        width: 4,
        height: 4,
        channels: 3,
        data: (0..16)
            .map(|i| {
                (
                    i as f32 / 16.0 + 0.05,
                    (i / 4 + i % 4 * 4) as f32 / 16.0 + 0.05,
                )
            })
            .flat_map(|(r, b)| [r, 1.0, b])
            .collect(),
    };
    let picture = Texture::Bitmap(Bitmap {
        image,
        filtering: Filtering::Nearest,
        wrap: Wrap::Repeat,
        uv_transform: Mat3::IDENTITY,
    });
    let spot = Emitter::Spot {
        position: Vec3::new(1.0, 2.0, 3.0),
        direction: Vec3::Z,
        intensity: Rgb::new(1.0, 2.0, 3.0),
        cutoff: 30f32.to_radians(),
        beam_width: 20f32.to_radians(),
        slide: Some(slide()),
    };
    for (w, expected) in [
        ([0.1, 0.05], [0.675, 2.0, 2.025]),
        ([-0.2, 0.3], [0.8625, 2.0, 1.4625]),
        ([0.3, -0.3], [0.166_493, 1.402_048, 1.682_457]),
        ([-0.5, 0.0], [0.188_923, 0.686_993, 0.180_336]),
    ] {
        let w = Vec2::from(w).extend(1.0).normalize();
        let found = spot
            .point_intensity(std::slice::from_ref(&picture), w)
            .to_array();
        assert!(
            (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-4),
            "{w}: {found:?}"
        );
    }
}

/// Small facets of unit strength scattered over a plate, some emission_view up, some down, and a few points.
fn facets(count: usize) -> Vec<PartBounds> {
    let mut sampler = Sampler::new(7, 0, Stream::Test, 0);
    (0..count)
        .map(|i| {
            let at = sampler.next_2d() * 20.0 - Vec2::splat(10.0);
            let p = at.extend(sampler.next_1d());
            let normals = match i % 7 {
                0 => Cone::FULL,
                1 => Cone {
                    axis: -Vec3::Z,
                    half_angle: 0.4,
                },
                _ => Cone::from_axis((Vec3::Z + warp::sphere(sampler.next_2d()) * 0.5).normalize()),
            };
            PartBounds {
                bounds: Aabb {
                    min: p - Vec3::splat(0.02),
                    max: p + Vec3::splat(0.02),
                },
                normals,
                emission: if i % 7 == 0 { 0.0 } else { PI * 0.5 },
                power: Rgb::splat(0.1 + sampler.next_1d()),
            }
        })
        .collect()
}

/// What the center of a facet sends to `p`, up to a constant.
fn arriving(part: &PartBounds, p: Vec3, n: Vec3) -> f32 {
    let d = p - part.bounds.center();
    let cos = (part.normals.angle_to_axis(d.normalize()) - part.normals.half_angle)
        .max(0.0)
        .cos()
        .max(0.0);
    part.power.r * cos * (-n.dot(d.normalize())).max(0.0) / d.length_squared()
}

#[test]
fn tree_probabilities_match_frequencies() {
    for count in [1, 2, 3, 5, 40] {
        let parts = facets(count);
        let tree = LightTree::new(&parts);
        for (p, n) in [
            (Vec3::new(1.0, 2.0, 3.0), Some(-Vec3::Z)),
            (Vec3::new(0.0, 0.0, 0.5), None),
        ] {
            let n_samples = 40_000;
            let mut counts = vec![0.0f32; count];
            for i in 0..n_samples {
                let Some((part, pmf)) = tree.sample(p, n, (i as f32 + 0.5) / n_samples as f32)
                else {
                    continue;
                };
                assert!((pmf / tree.pmf(p, n, part) - 1.0).abs() < 1e-4);
                counts[part] += 1.0 / n_samples as f32;
            }
            let pmfs: Vec<f32> = (0..count).map(|i| tree.pmf(p, n, i)).collect();
            // Less than 1 where a cluster that might shine here turns out to hold nothing that does.
            assert!(pmfs.iter().sum::<f32>() < 1.001, "{count} parts: {pmfs:?}");
            for (frequency, pmf) in counts.iter().zip(&pmfs) {
                assert!((frequency - pmf).abs() < 1e-3, "{frequency} for {pmf}");
            }
        }
    }
}

#[test]
fn the_tree_never_forgets_what_arrives() {
    let parts = facets(300);
    let tree = LightTree::new(&parts);
    let mut sampler = Sampler::new(8, 0, Stream::Test, 0);
    for _ in 0..200 {
        let p = Vec3::new(
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 6.0 - 3.0,
        );
        let n = warp::sphere(sampler.next_2d());
        for (i, part) in parts.iter().enumerate() {
            if arriving(part, p, n) > 0.0 || arriving(part, p, -n) > 0.0 {
                assert!(
                    tree.pmf(p, Some(n), i) > 0.0 && tree.pmf(p, None, i) > 0.0,
                    "part {i} from {p}"
                );
            }
        }
    }
}

#[test]
fn the_tree_beats_choice_by_power() {
    let parts = facets(10_000);
    let tree = LightTree::new(&parts);
    let total: f64 = parts.iter().map(|p| f64::from(p.power.r)).sum();
    let mut ratio = 0.0;
    let receivers = [
        Vec3::new(1.0, 2.0, 1.5),
        Vec3::new(-7.0, 3.0, 4.0),
        Vec3::new(0.0, 9.0, 1.2),
    ];
    for p in receivers {
        let n = -Vec3::Z;
        // Exact second moments of value over probability.
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sum = 0.0f64;
        for (i, part) in parts.iter().enumerate() {
            let value = f64::from(arriving(part, p, n));
            if value > 0.0 {
                sum += value;
                by_tree += value * value / f64::from(tree.pmf(p, Some(n), i));
                by_power += value * value / (f64::from(part.power.r) / total);
            }
        }
        ratio += (by_power - sum * sum) / (by_tree - sum * sum) / receivers.len() as f64;
    }
    assert!(ratio > 10.0, "variance reduced by {ratio}");
}

#[test]
fn few_parts_are_chosen_at_least_as_well_as_by_power() {
    for count in 2..=4 {
        let parts = facets(count);
        let tree = LightTree::new(&parts);
        let total: f64 = parts.iter().map(|p| f64::from(p.power.r)).sum();
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sampler = Sampler::new(9, 0, Stream::Test, 0);
        for _ in 0..200 {
            let p = Vec3::new(
                sampler.next_1d() * 20.0 - 10.0,
                sampler.next_1d() * 20.0 - 10.0,
                2.0 + sampler.next_1d(),
            );
            let n = -Vec3::Z;
            let values: Vec<f64> = parts
                .iter()
                .map(|part| f64::from(arriving(part, p, n)))
                .collect();
            let sum2 = values.iter().sum::<f64>().powi(2);
            if sum2 == 0.0 {
                continue;
            }
            for (i, (value, part)) in values
                .iter()
                .zip(&parts)
                .enumerate()
                .filter(|(_, (v, _))| **v > 0.0)
            {
                by_tree += value * value / sum2 / f64::from(tree.pmf(p, Some(n), i));
                by_power += value * value / sum2 / (f64::from(part.power.r) / total);
            }
        }
        assert!(
            by_tree <= by_power,
            "{count} parts: {by_tree} for {by_power}"
        );
    }
}

/// Shapes with area emitters of their own, and other emitters beside them.
struct World {
    geometry: Geometry,
    textures: Vec<Texture>,
    emitters: Emitters,
    guide: EmissionGuide,
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
        wrap: Wrap::Repeat,
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

/// Turns, moves and scales; in front of the receivers below.
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

/// Every form of emitter that has an extent.
fn shining_worlds() -> Vec<(&'static str, World)> {
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
        (
            "several",
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
            ),
        ),
    ]
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

/// What a ray from `p` along `wi` finds: radiance and the density with which direct sampling finds the same.
fn found(world: &World, p: Vec3, n: Option<Vec3>, wi: Vec3) -> (Rgb, f32) {
    match world.geometry.intersect(&Ray::new(p, wi)) {
        Some(hit) => {
            let y = world.geometry.surface_point(hit.at);
            let radiance = world
                .emitters
                .radiance(&world.geometry, &world.textures, &y, -wi);
            (radiance, world.emitters.pdf_direct(p, n, &y))
        }
        None => world.emitters.environment(n, wi),
    }
}

#[test]
fn direct_samples_integrate_to_what_rays_find() {
    for (name, world) in shining_worlds() {
        for (p, n) in receivers() {
            let mut numbers = Sampler::new(11, 0, Stream::Test, 0);
            let test = |wi: Vec3| f64::from((1.0 + wi.x).powi(2) * (1.0 + 0.5 * wi.y));
            let (mut direct, mut direct2, mut uniform, mut uniform2) =
                (0.0f64, 0.0f64, 0.0f64, 0.0f64);
            let count = 30_000;
            for _ in 0..count {
                let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
                let sample = world.emitters.sample_direct(
                    &world.geometry,
                    &world.textures,
                    p,
                    n,
                    u_choice,
                    u,
                );
                if let Some(s) = sample.filter(|s| {
                    !world.geometry.occluded(&Segment {
                        from: p,
                        to: s.target,
                    })
                }) {
                    let value = f64::from(s.weight.g) * test(s.wi);
                    direct += value;
                    direct2 += value * value;
                    let (radiance, pdf) = found(&world, p, n, s.wi);
                    // The ray may miss the rim that the sample met.
                    if !radiance.is_black() && s.pdf < 50.0 {
                        assert!(
                            (pdf / s.pdf - 1.0).abs() < 0.02,
                            "{name}: density {pdf} found, {} sampled",
                            s.pdf
                        );
                    }
                }
                let wi = warp::sphere(numbers.next_2d());
                let value = f64::from(found(&world, p, n, wi).0.g / warp::SPHERE_PDF) * test(wi);
                uniform += value;
                uniform2 += value * value;
            }
            let n_samples = f64::from(count);
            let (a, b) = (direct / n_samples, uniform / n_samples);
            let variance = (direct2 / n_samples - a * a + uniform2 / n_samples - b * b) / n_samples;
            assert!(
                (a - b).abs() < 5.0 * variance.sqrt() + 1e-6,
                "{name} at {p}: {a} direct, {b} by rays"
            );
        }
    }
}

#[test]
fn direct_densities_integrate_to_the_share_of_samples() {
    for (name, world) in shining_worlds() {
        let (p, n) = receivers()[0];
        let side = 700;
        let mut integral = 0.0f64;
        for i in 0..side * side {
            let uv = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
            let (radiance, pdf) = found(&world, p, n, octahedral::direction_from_square(uv));
            if !radiance.is_black() {
                integral +=
                    f64::from(pdf * octahedral::solid_angle_density(uv)) / (side * side) as f64;
            }
        }
        let mut numbers = Sampler::new(12, 0, Stream::Test, 0);
        let count = 20_000;
        let seen = (0..count).filter(|_| {
            let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
            let sample =
                world
                    .emitters
                    .sample_direct(&world.geometry, &world.textures, p, n, u_choice, u);
            sample.is_some_and(|s| {
                !world.geometry.occluded(&Segment {
                    from: p,
                    to: s.target,
                })
            })
        });
        let share = seen.count() as f64 / f64::from(count);
        assert!(
            (integral - share).abs() < 0.02,
            "{name}: {integral} for {share}"
        );
    }
}

#[test]
fn emitted_flux_is_the_power() {
    for (name, world) in shining_worlds() {
        let mut numbers = Sampler::new(13, 0, Stream::Test, 0);
        let count = 20_000;
        let flux: f64 = (0..count)
            .filter_map(|_| emit(&world, &mut numbers))
            .map(|s| f64::from(s.flux.g))
            .sum();
        let power: f32 = (0..world.emitters.descriptions().len())
            .map(|i| world.emitters.power(EmitterId::from(i)).g)
            .sum();
        // Textured power is a mean over a grid.
        assert!(
            (flux / f64::from(count) / f64::from(power) - 1.0).abs() < 0.03,
            "{name}"
        );
    }
}

fn emit(world: &World, numbers: &mut Sampler) -> Option<EmissionSample> {
    let u = EmissionNumbers {
        emitter: numbers.next_1d(),
        position: numbers.next_2d(),
        direction: numbers.next_2d(),
        part: numbers.next_1d(),
    };
    world
        .emitters
        .sample_emission(&world.geometry, &world.textures, &world.guide, u)
}

/// Flux through the square of half-width `half` around `center` in a plane z = const from above or below, by photons and by
/// direct light: mean and variance of the mean of each.
fn flux_through(world: &World, center: Vec3, half: f32, count: u32) -> [(f64, f64); 2] {
    let mut numbers = Sampler::new(14, 0, Stream::Test, 0);
    let mut sums = [[0.0f64; 2]; 2];
    for _ in 0..count {
        let photon = emit(world, &mut numbers).map_or(0.0, |s| {
            let t = (center.z - s.ray.o.z) / s.ray.d.z;
            let q = (s.ray.at(t) - center).truncate().abs();
            let arrives = t > 0.0
                && q.max_element() < half
                && world
                    .geometry
                    .intersect(&Ray { t_max: t, ..s.ray })
                    .is_none();
            if arrives { f64::from(s.flux.g) } else { 0.0 }
        });
        let p = center + ((numbers.next_2d() * 2.0 - Vec2::ONE) * half).extend(0.0);
        let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
        let direct =
            world
                .emitters
                .sample_direct(&world.geometry, &world.textures, p, None, u_choice, u);
        let direct = direct.map_or(0.0, |s| {
            let blocked = world.geometry.occluded(&Segment {
                from: p,
                to: s.target,
            });
            if blocked {
                0.0
            } else {
                f64::from(s.weight.g * s.wi.z.abs() * 4.0 * half * half)
            }
        });
        for (sum, value) in sums.iter_mut().zip([photon, direct]) {
            sum[0] += value;
            sum[1] += value * value;
        }
    }
    let n = f64::from(count);
    sums.map(|[sum, squares]| (sum / n, (squares / n - (sum / n).powi(2)) / n))
}

fn check_flux(name: &str, [(a, variance_a), (b, variance_b)]: [(f64, f64); 2]) {
    let deviation = (variance_a + variance_b).sqrt();
    assert!(
        (a - b).abs() < 5.0 * deviation,
        "{name}: {a} by photons, {b} by direct light, deviation {deviation}"
    );
    assert!(deviation < 0.1 * b, "{name}: too noisy to tell");
}

#[test]
fn photons_carry_what_direct_light_brings() {
    let others = vec![
        Emitter::Point {
            position: Vec3::new(0.4, 0.3, 1.4),
            intensity: Rgb::splat(0.7),
        },
        Emitter::Spot {
            position: Vec3::new(-0.5, 0.2, 1.2),
            direction: Vec3::new(0.3, 0.0, -1.0).normalize(),
            intensity: Rgb::splat(2.0),
            cutoff: 0.8,
            beam_width: 0.3,
            slide: None,
        },
        Emitter::Spot {
            position: Vec3::new(0.2, 0.5, 1.3),
            direction: Vec3::new(-0.1, 0.0, -1.0).normalize(),
            intensity: Rgb::splat(1.5),
            cutoff: 0.7,
            beam_width: 0.4,
            slide: Some(slide()),
        },
        distant_emitters().swap_remove(1),
    ];
    let floor = || {
        Placed::new(
            Shape::Mesh(Mesh::rectangle()),
            Affine3A::from_translation(-Vec3::Z),
        )
        .dark()
    };
    let pointwise = world(vec![floor()], others);
    let surroundings = world(vec![floor()], distant_emitters());
    let worlds = shining_worlds()
        .into_iter()
        .chain([("points", pointwise), ("surroundings", surroundings)]);
    for (name, world) in worlds {
        check_flux(
            name,
            flux_through(&world, Vec3::new(0.1, 0.0, 0.2), 0.5, 60_000),
        );
    }
}

/// A closed box with a small window, lit from outside.
fn room() -> World {
    let cube = Shape::Mesh(Mesh::cube());
    let wall = |center: Vec3, half: Vec3| {
        let transform = Affine3A::from_translation(center) * Affine3A::from_scale(half);
        Placed::new(cube.clone(), transform).dark()
    };
    let slabs = vec![
        wall(Vec3::new(0.0, 0.0, -1.1), Vec3::new(1.2, 1.2, 0.1)),
        wall(Vec3::new(0.0, 0.0, 1.1), Vec3::new(1.2, 1.2, 0.1)),
        wall(Vec3::new(-1.1, 0.0, 0.0), Vec3::new(0.1, 1.2, 1.0)),
        wall(Vec3::new(1.1, -0.7, 0.0), Vec3::new(0.1, 0.5, 1.0)),
        wall(Vec3::new(1.1, 0.7, 0.0), Vec3::new(0.1, 0.5, 1.0)),
        wall(Vec3::new(0.0, -1.1, 0.0), Vec3::new(1.0, 0.1, 1.0)),
        wall(Vec3::new(0.0, 1.1, 0.0), Vec3::new(1.0, 0.1, 1.0)),
        // Ground outside makes the bounding sphere large.
        wall(Vec3::new(0.0, 0.0, -1.3), Vec3::new(8.0, 8.0, 0.1)),
    ];
    let mut others = distant_emitters();
    others[1] = Emitter::Directional {
        direction: Vec3::new(-0.8, 0.05, -0.5).normalize(),
        irradiance: Rgb::splat(2.0),
    };
    world(slabs, others)
}

/// Fraction of photons that get inside, and the flux through the middle of the room.
fn photons_inside(world: &World) -> f64 {
    let mut numbers = Sampler::new(15, 0, Stream::Test, 0);
    let count = 20_000;
    let inside = (0..count)
        .filter_map(|_| emit(world, &mut numbers))
        .filter(|s| {
            world
                .geometry
                .intersect(&s.ray)
                .is_some_and(|hit| s.ray.at(hit.t).abs().max_element() < 1.01)
        });
    inside.count() as f64 / f64::from(count)
}

#[test]
fn the_guide_brings_photons_through_windows_and_changes_no_flux() {
    let mut world = room();
    let before = photons_inside(&world);
    let mut numbers = Sampler::new(16, 0, Stream::Test, 0);
    let rays: Vec<Ray> = (0..4000)
        .map(|_| Ray::new(Vec3::ZERO, warp::sphere(numbers.next_2d())))
        .collect();
    world.guide = world
        .emitters
        .emission_guide(&world.geometry, || rays, |_| false);
    let after = photons_inside(&world);
    assert!(
        after > 100.0 * before && after > 0.1,
        "{before} of the photons before, {after} after"
    );
    let flux = flux_through(&world, Vec3::new(0.3, 0.0, -0.5), 0.5, 60_000);
    check_flux("room", flux);
}

#[test]
fn an_empty_scene_has_no_light() {
    let world = world(vec![], vec![]);
    let mut numbers = Sampler::new(17, 0, Stream::Test, 0);
    assert!(emit(&world, &mut numbers).is_none());
    assert!(!world.emitters.has_environment());
    let sample = world.emitters.sample_direct(
        &world.geometry,
        &[],
        Vec3::ZERO,
        None,
        0.3,
        Vec2::splat(0.4),
    );
    assert!(sample.is_none());
}
