//! Scenes.

use super::numbers::Numbers;
use super::{emitters, materials, shapes, textures};
use manylight::film::{FilmDesc, Filter};
use manylight::ids::{EmitterId, MaterialId, ShapeId};
use manylight::math::{Affine3A, UVec2, Vec2, Vec3};
use manylight::scene::{InstanceDesc, MediumDesc, PathLimits, PrimitiveDesc, SceneDesc};
use manylight::sensors::{FovAxis, SensorDesc, SensorKind};

/// A scene of a few shapes around the origin, seen from z = 4. Indices are valid, except for few.
pub(super) fn scene(numbers: &mut Numbers) -> SceneDesc {
    let textures = textures::textures(numbers);
    let materials = materials::materials(numbers, textures.len());
    let shapes = shapes::shapes(numbers);
    let emitters = emitters::emitters(numbers, textures.len());
    let mut desc = SceneDesc {
        shapes,
        textures,
        materials,
        emitters,
        sensors: vec![sensor(numbers)],
        limits: limits(numbers),
        ..SceneDesc::default()
    };
    if numbers.flag() {
        desc.media.push(MediumDesc {
            material: MaterialId::from(numbers.index(desc.materials.len())),
            absorption: numbers.color(3.0),
        });
    }
    desc.primitives = (0..1 + numbers.below(5))
        .map(|_| primitive(numbers, &desc, true))
        .collect();
    if numbers.rarely(4) {
        desc.groups = (0..1 + numbers.below(2))
            .map(|_| {
                (0..numbers.below(4))
                    .map(|_| primitive(numbers, &desc, false))
                    .collect()
            })
            .collect();
        desc.instances = (0..1 + numbers.below(4))
            .map(|_| InstanceDesc {
                name: String::new(),
                group: numbers.index(desc.groups.len()),
                world_from_group: numbers.affine(),
            })
            .collect();
    }
    desc
}

fn primitive(numbers: &mut Numbers, desc: &SceneDesc, may_emit: bool) -> PrimitiveDesc {
    let emits = may_emit && !desc.emitters.is_empty() && numbers.rarely(3);
    PrimitiveDesc {
        name: String::new(),
        shape: ShapeId::from(numbers.index(desc.shapes.len())),
        world_from_object: if numbers.flag() {
            Affine3A::IDENTITY
        } else {
            numbers.affine()
        },
        flip_normals: numbers.flag(),
        material: MaterialId::from(numbers.index(desc.materials.len())),
        emitter: emits.then(|| {
            let area = emitters::area(&desc.emitters);
            EmitterId::from(area.unwrap_or(desc.emitters.len()))
        }),
    }
}

fn limits(numbers: &mut Numbers) -> PathLimits {
    PathLimits {
        max_depth: (!numbers.rarely(8)).then(|| numbers.below(12) as u32),
        rr_depth: numbers.below(10) as u32,
        hide_emitters: numbers.rarely(8),
    }
}

fn sensor(numbers: &mut Numbers) -> SensorDesc {
    let axes = [
        FovAxis::X,
        FovAxis::Y,
        FovAxis::Diagonal,
        FovAxis::Smaller,
        FovAxis::Larger,
    ];
    let kind = match numbers.below(4) {
        0 | 1 => SensorKind::Perspective {
            fov: numbers.float(10.0, 120.0),
            fov_axis: numbers.choose(&axes),
        },
        2 => SensorKind::ThinLens {
            fov: numbers.float(10.0, 120.0),
            fov_axis: numbers.choose(&axes),
            aperture_radius: numbers.float(0.0, 0.5),
            focus_distance: numbers.float(0.5, 5.0),
        },
        _ => SensorKind::Orthographic,
    };
    // The camera looks along +z of its frame: to the origin from z = 4.
    let usual =
        Affine3A::from_translation(4.0 * Vec3::Z) * Affine3A::from_rotation_y(std::f32::consts::PI);
    SensorDesc {
        name: String::new(),
        motion: Vec::new(),
        world_from_camera: if numbers.rarely(6) {
            numbers.affine()
        } else {
            usual
        },
        kind,
        principal_point_offset: if numbers.rarely(8) {
            numbers.vec2(-0.5, 0.5)
        } else {
            Vec2::ZERO
        },
        near_clip: if numbers.flag() {
            0.0
        } else {
            numbers.float(0.0, 1.0)
        },
        far_clip: if numbers.flag() {
            1e4
        } else {
            numbers.float(1.0, 10.0)
        },
        film: film(numbers),
    }
}

fn film(numbers: &mut Numbers) -> FilmDesc {
    let filter = match numbers.below(8) {
        0..=2 => Filter::Box,
        3 => Filter::Tent {
            radius: numbers.float(0.5, 3.0),
        },
        4 => Filter::Gaussian {
            stddev: numbers.float(0.2, 1.0),
        },
        5 => Filter::Mitchell {
            b: numbers.unit(),
            c: numbers.unit(),
        },
        6 => Filter::CatmullRom,
        _ => Filter::Lanczos {
            lobes: numbers.float(1.0, 4.0),
        },
    };
    let mut film = FilmDesc {
        size: UVec2::splat(4),
        crop_offset: UVec2::ZERO,
        crop_size: UVec2::splat(4),
        filter,
    };
    if numbers.rarely(8) {
        film.crop_offset = UVec2::new(numbers.below(4) as u32, numbers.below(4) as u32);
        film.crop_size = UVec2::new(numbers.below(4) as u32, numbers.below(4) as u32);
    }
    film
}
