//! Small scenes for tests, and a builder for them.

use crate::bsdf::Material;
use crate::bsdf::material::{ColorShift, ConstantRoughness, Distribution, Roughness};
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::film::{FilmDesc, Filter};
use crate::geometry::{Mesh, Shape};
use crate::ids::{EmitterId, MaterialId, ShapeId};
use crate::math::{Affine3A, Mat3, UVec2, Vec2, Vec3};
use crate::scene::{PathLimits, PrimitiveDesc, Scene, SceneDesc};
use crate::sensors::{FovAxis, SensorDesc, SensorKind};
use crate::texture::{ColorInput, FloatInput};

/// A Lambertian material with this albedo.
pub fn diffuse(r: f32, g: f32, b: f32) -> Material {
    Material::Diffuse {
        reflectance: ColorInput::Constant(Rgb::new(r, g, b)),
    }
}

/// A GGX metal of roughness `alpha` with an albedo of about 0.7.
pub fn rough_metal(alpha: f32) -> Material {
    Material::Conductor {
        eta: ColorInput::Constant(Rgb::new(1.66, 0.88, 0.52)),
        k: ColorInput::Constant(Rgb::new(9.22, 6.27, 4.84)),
        specular_reflectance: ColorInput::Constant(Rgb::splat(0.8)),
        roughness: Some(ggx(alpha)),
    }
}

fn ggx(alpha: f32) -> Roughness {
    let alpha = FloatInput::Constant(alpha);
    Roughness {
        distribution: Distribution::Ggx,
        alpha_u: alpha,
        alpha_v: alpha,
    }
}

/// A rough dielectric coat of roughness `alpha` over a diffuse base.
pub fn rough_plastic(alpha: f32, base: Rgb) -> Material {
    Material::Plastic {
        eta: 1.5,
        diffuse_reflectance: ColorInput::Constant(base),
        specular_reflectance: ColorInput::Constant(Rgb::WHITE),
        color_shift: ColorShift::Linear,
        roughness: Some(ConstantRoughness {
            distribution: Distribution::Ggx,
            alpha,
        }),
    }
}

/// Clear glass.
pub fn glass() -> Material {
    dielectric(None)
}

/// Rough glass of roughness `alpha`.
pub fn rough_glass(alpha: f32) -> Material {
    dielectric(Some(ggx(alpha)))
}

fn dielectric(roughness: Option<Roughness>) -> Material {
    Material::Dielectric {
        eta: 1.5,
        specular_reflectance: ColorInput::Constant(Rgb::WHITE),
        specular_transmittance: ColorInput::Constant(Rgb::WHITE),
        roughness,
    }
}

/// Builds a scene description step by step.
#[derive(Clone, Debug)]
pub struct Builder {
    /// The description built so far.
    pub desc: SceneDesc,
}

impl Builder {
    /// An empty scene with a pinhole camera at `eye` that looks at `target`: horizontal field of
    /// view `fov` in degrees, square film of `size`² pixels.
    pub fn new(eye: Vec3, target: Vec3, fov: f32, size: u32) -> Self {
        let z = (target - eye).normalize();
        let x = Vec3::Y.cross(z).normalize();
        let size = UVec2::splat(size);
        let sensor = SensorDesc {
            name: String::new(),
            motion: Vec::new(),
            world_from_camera: Affine3A::from_mat3_translation(
                Mat3::from_cols(x, z.cross(x), z),
                eye,
            ),
            kind: SensorKind::Perspective {
                fov,
                fov_axis: FovAxis::X,
            },
            principal_point_offset: Vec2::ZERO,
            near_clip: 1e-3,
            far_clip: 1e4,
            film: FilmDesc {
                size,
                crop_offset: UVec2::ZERO,
                crop_size: size,
                filter: Filter::Box,
            },
        };
        Builder {
            desc: SceneDesc {
                sensors: vec![sensor],
                ..SceneDesc::default()
            },
        }
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.desc.materials.push(material);
        MaterialId::from(self.desc.materials.len() - 1)
    }

    /// Adds an area emitter, to be referenced by primitives.
    pub fn area_light(&mut self, radiance: Rgb) -> EmitterId {
        self.emitter(Emitter::Area {
            radiance: ColorInput::Constant(radiance),
        })
    }

    /// Adds an emitter.
    pub fn emitter(&mut self, emitter: Emitter) -> EmitterId {
        self.desc.emitters.push(emitter);
        EmitterId::from(self.desc.emitters.len() - 1)
    }

    /// Adds a shape and a primitive of it.
    pub fn place(
        &mut self,
        shape: Shape,
        to_world: Affine3A,
        material: MaterialId,
        emitter: Option<EmitterId>,
    ) {
        self.desc.shapes.push(shape);
        self.desc.primitives.push(PrimitiveDesc {
            name: String::new(),
            shape: ShapeId::from(self.desc.shapes.len() - 1),
            world_from_object: to_world,
            flip_normals: false,
            material,
            emitter,
        });
    }

    /// Adds a rectangle around `center` with the half edges `a` and `b`; the normal is along
    /// `a x b`.
    pub fn rectangle(
        &mut self,
        center: Vec3,
        a: Vec3,
        b: Vec3,
        material: MaterialId,
        emitter: Option<EmitterId>,
    ) {
        let to_world =
            Affine3A::from_mat3_translation(Mat3::from_cols(a, b, a.cross(b).normalize()), center);
        self.place(Shape::Mesh(Mesh::rectangle()), to_world, material, emitter);
    }

    /// Adds the six faces of the cube [-1, 1]³ with inward normals. Order of `materials`: -x, +x,
    /// -y, +y, -z, +z.
    pub fn room(&mut self, materials: [MaterialId; 6], emitter: Option<EmitterId>) {
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        let faces = [
            (-x, y, z),
            (x, z, y),
            (-y, z, x),
            (y, x, z),
            (-z, x, y),
            (z, y, x),
        ];
        for ((center, a, b), material) in faces.into_iter().zip(materials) {
            self.rectangle(center, a, b, material, emitter);
        }
    }

    /// The scene.
    ///
    /// # Panics
    /// If the description is not valid.
    pub fn build(self) -> Scene {
        Scene::build(self.desc, 0).expect("the scene description must be valid")
    }
}

/// A furnace: a closed room with albedo `rho` and emitted radiance 1 on all walls. The radiance is
/// 1 / (1 - rho) everywhere.
pub fn furnace(rho: f32, size: u32) -> Builder {
    let mut b = Builder::new(
        Vec3::new(0.1, 0.2, -0.7),
        Vec3::new(0.0, -0.1, 1.0),
        90.0,
        size,
    );
    let wall = b.material(diffuse(rho, rho, rho));
    let light = b.area_light(Rgb::WHITE);
    b.room([wall; 6], Some(light));
    b
}

/// A room with colored walls, an area light under the ceiling, a glossy floor, a metal block and a
/// plastic block.
pub fn glossy_box(size: u32) -> Builder {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.1, -0.98),
        Vec3::new(0.0, -0.15, 1.0),
        75.0,
        size,
    );
    let white = b.material(diffuse(0.7, 0.7, 0.7));
    let red = b.material(diffuse(0.6, 0.1, 0.08));
    let green = b.material(diffuse(0.12, 0.5, 0.1));
    let floor = b.material(rough_plastic(0.15, Rgb::new(0.3, 0.25, 0.2)));
    let metal = b.material(rough_metal(0.2));
    let plastic = b.material(rough_plastic(0.25, Rgb::new(0.1, 0.2, 0.5)));
    b.room([red, green, floor, white, white, white], None);
    let light = b.area_light(Rgb::new(14.0, 13.0, 11.0));
    b.rectangle(
        Vec3::new(0.0, 0.98, 0.2),
        Vec3::X * 0.3,
        Vec3::Z * 0.3,
        white,
        Some(light),
    );
    let block = |center: Vec3, half: f32, turn: f32| {
        Affine3A::from_translation(center)
            * Affine3A::from_rotation_y(turn)
            * Affine3A::from_scale(Vec3::splat(half))
    };
    b.place(
        Shape::Mesh(Mesh::cube()),
        block(Vec3::new(-0.4, -0.7, 0.4), 0.3, 0.4),
        metal,
        None,
    );
    b.place(
        Shape::Mesh(Mesh::cube()),
        block(Vec3::new(0.45, -0.75, 0.1), 0.25, -0.3),
        plastic,
        None,
    );
    b.desc.limits = PathLimits {
        max_depth: None,
        ..PathLimits::default()
    };
    b
}

/// Names of the light groups of [`grouped_box`].
pub const GROUPS: [&str; 3] = ["ceiling", "lamp", "rest"];

/// [`glossy_box`] with a lamp of another color in a glass bulb, and with point lights. The emitters
/// belong to the groups [`GROUPS`]; only those of `lit` emit, or all without it.
pub fn grouped_box(size: u32, lit: Option<&str>) -> Builder {
    let mut b = glossy_box(size);
    let white = MaterialId(0);
    let glass = b.material(dielectric(None));
    let sphere = |center: Vec3, radius: f32| (Shape::Sphere { center, radius }, Affine3A::IDENTITY);
    let lamp = b.area_light(Rgb::new(4.0, 8.0, 16.0));
    let (bulb, place) = sphere(Vec3::new(0.6, 0.3, 0.5), 0.1);
    b.place(bulb, place, white, Some(lamp));
    let (cover, place) = sphere(Vec3::new(0.6, 0.3, 0.5), 0.15);
    b.place(cover, place, glass, None);
    b.emitter(Emitter::Point {
        position: Vec3::new(-0.5, 0.4, 0.0),
        intensity: Rgb::new(0.6, 0.2, 0.1),
    });
    b.emitter(Emitter::Point {
        position: Vec3::new(0.2, -0.6, -0.2),
        intensity: Rgb::new(0.1, 0.1, 0.0),
    });
    b.desc.emitter_groups = ["ceiling", "lamp"].map(str::to_owned).to_vec();
    for (i, emitter) in b.desc.emitters.iter_mut().enumerate() {
        if lit.is_some_and(|lit| lit != GROUPS[i.min(2)]) {
            match emitter {
                Emitter::Area { radiance } => *radiance = ColorInput::Constant(Rgb::BLACK),
                Emitter::Point { intensity, .. } => *intensity = Rgb::BLACK,
                _ => {}
            }
        }
    }
    b
}
