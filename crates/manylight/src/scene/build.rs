//! The checks that turn a description into a scene: after them nothing in the core can fail.

use super::{InstanceDesc, PrimitiveDesc, Scene, SceneDesc, SceneError};
use crate::bsdf::{Material, Materials};
use crate::emitters::{Emitter, Emitters};
use crate::geometry::{Geometry, Instance, Mesh, Primitive, Shape};
use crate::ids::{MaterialId, TextureId};
use crate::math::{Affine3A, UVec2, Vec3};
use crate::sensors::{Sensor, SensorDesc};
use crate::texture::{ColorInput, FloatInput};

type Checked = Result<(), SceneError>;

pub(super) fn build(mut desc: SceneDesc, sensor: usize) -> Result<Scene, SceneError> {
    check(&desc, sensor)?;
    let materials = Materials::new(desc.materials);
    let groups = group_ranges(desc.primitives.len(), &desc.groups);
    let placed = desc
        .primitives
        .into_iter()
        .chain(desc.groups.into_iter().flatten());
    let primitives = placed.map(|p| primitive(p, &materials)).collect();
    let instances = desc.instances.iter().map(instance).collect();
    let geometry = Geometry::build(desc.shapes, primitives, groups, instances);
    let emitters = Emitters::new(desc.emitters, &geometry, &desc.textures);
    let sensor = Sensor::new(desc.sensors.swap_remove(sensor));
    Ok(Scene {
        geometry,
        materials,
        textures: desc.textures,
        emitters,
        sensor,
        limits: desc.limits,
    })
}

fn primitive(desc: PrimitiveDesc, materials: &Materials) -> Primitive {
    Primitive {
        shape: desc.shape,
        world_from_object: desc.world_from_object,
        flip_normals: desc.flip_normals,
        material: desc.material,
        emitter: desc.emitter,
        transparent: materials.is_transparent(desc.material),
    }
}

fn instance(desc: &InstanceDesc) -> Instance {
    Instance {
        group: desc.group as u32,
        world_from_group: desc.world_from_group,
    }
}

fn group_ranges(first: usize, groups: &[Vec<PrimitiveDesc>]) -> Vec<std::ops::Range<usize>> {
    let ranges = groups.iter().scan(first, |start, group| {
        let range = *start..*start + group.len();
        *start = range.end;
        Some(range)
    });
    ranges.collect()
}

fn check(desc: &SceneDesc, sensor: usize) -> Checked {
    let Some(camera) = desc.sensors.get(sensor) else {
        return fail(format!(
            "sensor {sensor} was asked for, but the scene has {}",
            desc.sensors.len()
        ));
    };
    check_sensor(camera)?;
    for (i, shape) in desc.shapes.iter().enumerate() {
        check_shape(shape).map_err(|e| in_place(&format!("shape {i}"), &e))?;
    }
    check_textures(desc)?;
    check_materials(desc)?;
    for (i, emitter) in desc.emitters.iter().enumerate() {
        let check = match emitter {
            Emitter::Area { radiance } => check_color(desc, *radiance),
            Emitter::Spot {
                projector: Some(projector),
                ..
            } => check_texture(desc, projector.texture),
            _ => Ok(()),
        };
        check.map_err(|e| in_place(&format!("emitter {i}"), &e))?;
    }
    for (i, primitive) in desc.primitives.iter().enumerate() {
        check_primitive(desc, primitive).map_err(|e| in_place(&title(primitive, i), &e))?;
    }
    check_groups(desc)
}

fn check_groups(desc: &SceneDesc) -> Checked {
    for (i, primitive) in desc.groups.iter().flatten().enumerate() {
        let check = check_primitive(desc, primitive).and_then(|()| {
            ensure(primitive.emitter.is_none(), || {
                "has an emitter, which is not possible inside a group".to_owned()
            })
        });
        check.map_err(|e| in_place(&format!("in a group, {}", title(primitive, i)), &e))?;
    }
    for (i, instance) in desc.instances.iter().enumerate() {
        let check = check_index("group", instance.group, desc.groups.len())
            .and_then(|()| check_transform(&instance.world_from_group));
        check.map_err(|e| in_place(&format!("instance {i}"), &e))?;
    }
    Ok(())
}

fn check_primitive(desc: &SceneDesc, primitive: &PrimitiveDesc) -> Checked {
    check_index("shape", primitive.shape.index(), desc.shapes.len())?;
    check_index("material", primitive.material.index(), desc.materials.len())?;
    check_transform(&primitive.world_from_object)?;
    let Some(emitter) = primitive.emitter else {
        return Ok(());
    };
    check_index("emitter", emitter.index(), desc.emitters.len())?;
    ensure(
        matches!(desc.emitters[emitter.index()], Emitter::Area { .. }),
        || {
            format!(
                "emitter {} is not an area emitter and cannot sit on a surface",
                emitter.0
            )
        },
    )
}

fn check_shape(shape: &Shape) -> Checked {
    let positive = |radius: f32| {
        ensure(radius.is_finite() && radius > 0.0, || {
            format!("the radius {radius} is not positive and finite")
        })
    };
    let finite = |p: Vec3| ensure(p.is_finite(), || format!("the point {p} is not finite"));
    match shape {
        Shape::Mesh(mesh) => check_mesh(mesh),
        Shape::Sphere { center, radius } => finite(*center).and_then(|()| positive(*radius)),
        Shape::Disk => Ok(()),
        Shape::Cylinder { p0, p1, radius } => {
            finite(*p0)?;
            finite(*p1)?;
            ensure((*p1 - *p0).try_normalize().is_some(), || {
                "the axis has no length".to_owned()
            })?;
            positive(*radius)
        }
    }
}

fn check_mesh(mesh: &Mesh) -> Checked {
    let count = mesh.positions.len();
    for (name, len) in [("normals", mesh.normals.len()), ("uvs", mesh.uvs.len())] {
        ensure(len == 0 || len == count, || {
            format!("{len} {name} for {count} positions; none or one each expected")
        })?;
    }
    if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return fail(format!("position {i} is not finite"));
    }
    let outside = |triangle: &[u32; 3]| triangle.iter().any(|&i| i as usize >= count);
    match mesh.triangles.iter().position(outside) {
        Some(i) => fail(format!(
            "triangle {i} names the vertices {:?} of {count}",
            mesh.triangles[i]
        )),
        None => Ok(()),
    }
}

fn check_transform(transform: &Affine3A) -> Checked {
    ensure(transform.is_finite(), || {
        "the transform is not finite".to_owned()
    })?;
    let inverse = glam::Mat3::from(transform.matrix3).as_dmat3().inverse();
    ensure(inverse.is_finite(), || {
        "the transform is singular".to_owned()
    })
}

fn check_sensor(sensor: &SensorDesc) -> Checked {
    let film = &sensor.film;
    let check = check_transform(&sensor.world_from_camera).and_then(|()| {
        ensure(film.size.min_element() > 0, || {
            format!("the film of {} pixels is empty", pixels(film.size))
        })?;
        ensure(film.crop_size.min_element() > 0, || {
            format!("the crop of {} pixels is empty", pixels(film.crop_size))
        })?;
        let fits = |size: u32, offset: u32, whole: u32| {
            offset.checked_add(size).is_some_and(|end| end <= whole)
        };
        let (size, offset, whole) = (film.crop_size, film.crop_offset, film.size);
        ensure(
            fits(size.x, offset.x, whole.x) && fits(size.y, offset.y, whole.y),
            || {
                format!(
                    "the crop of {} at {} leaves the film of {} pixels",
                    pixels(size),
                    pixels(offset),
                    pixels(whole)
                )
            },
        )
    });
    check.map_err(|e| {
        in_place(
            if sensor.name.is_empty() {
                "the sensor"
            } else {
                &sensor.name
            },
            &e,
        )
    })
}

fn pixels(size: UVec2) -> String {
    format!("{} x {}", size.x, size.y)
}

fn check_materials(desc: &SceneDesc) -> Checked {
    for (i, material) in desc.materials.iter().enumerate() {
        check_material(desc, material).map_err(|e| in_place(&format!("material {i}"), &e))?;
    }
    // Depth-first with three states: a material that is met again while it is being followed wraps itself.
    let mut states = vec![Visit::New; desc.materials.len()];
    (0..desc.materials.len()).try_for_each(|i| check_cycles(desc, &mut states, i))
}

/// Nested textures stand before those that they are part of, so that none can contain itself.
fn check_textures(desc: &SceneDesc) -> Checked {
    for (i, texture) in desc.textures.iter().enumerate() {
        for nested in texture.nested() {
            ensure(nested.index() < i, || {
                format!(
                    "texture {i} contains texture {}, which is not before it",
                    nested.0
                )
            })?;
        }
    }
    Ok(())
}

#[derive(Clone, Copy, PartialEq)]
enum Visit {
    New,
    Followed,
    Done,
}

fn check_cycles(desc: &SceneDesc, states: &mut [Visit], start: usize) -> Checked {
    // With an explicit stack: a long chain of wrappers must not exhaust the thread's.
    let mut stack = vec![start];
    while let Some(&id) = stack.last() {
        if states[id] != Visit::New {
            states[id] = Visit::Done;
            stack.pop();
            continue;
        }
        states[id] = Visit::Followed;
        for inner in wrapped(&desc.materials[id]).map(MaterialId::index) {
            ensure(states[inner] != Visit::Followed, || {
                format!("material {inner} wraps itself")
            })?;
            if states[inner] == Visit::New {
                stack.push(inner);
            }
        }
    }
    Ok(())
}

/// The materials that a material names.
fn wrapped(material: &Material) -> impl Iterator<Item = MaterialId> {
    let ids = match *material {
        Material::Blend { first, second, .. } => [Some(first), Some(second)],
        Material::TwoSided { front, back } => [Some(front), Some(back)],
        Material::Mask { inner, .. }
        | Material::BumpMap { inner, .. }
        | Material::NormalMap { inner, .. } => [Some(inner), None],
        _ => [None, None],
    };
    ids.into_iter().flatten()
}

fn check_material(desc: &SceneDesc, material: &Material) -> Checked {
    for inner in wrapped(material) {
        check_index("material", inner.index(), desc.materials.len())?;
    }
    for texture in textures(material) {
        check_texture(desc, texture)?;
    }
    Ok(())
}

/// The textures that a material names.
fn textures(material: &Material) -> Vec<TextureId> {
    let color = |input: &ColorInput| match *input {
        ColorInput::Texture(id) => Some(id),
        ColorInput::Constant(_) => None,
    };
    let float = |input: &FloatInput| match *input {
        FloatInput::Texture(id) => Some(id),
        FloatInput::Constant(_) => None,
    };
    let rough = |r: &Option<crate::bsdf::material::Roughness>| {
        r.map_or([None; 2], |r| [float(&r.alpha_u), float(&r.alpha_v)])
    };
    let found: Vec<Option<TextureId>> = match material {
        Material::Diffuse { reflectance } => vec![color(reflectance)],
        Material::RoughDiffuse {
            reflectance, alpha, ..
        } => vec![color(reflectance), float(alpha)],
        Material::Conductor {
            eta,
            k,
            specular_reflectance,
            roughness,
        } => [
            [color(eta), color(k)],
            [color(specular_reflectance), None],
            rough(roughness),
        ]
        .concat(),
        Material::Dielectric {
            specular_reflectance,
            specular_transmittance,
            roughness,
            ..
        } => [
            [color(specular_reflectance), color(specular_transmittance)],
            rough(roughness),
        ]
        .concat(),
        Material::ThinDielectric {
            specular_reflectance,
            specular_transmittance,
            ..
        } => {
            vec![color(specular_reflectance), color(specular_transmittance)]
        }
        Material::Plastic {
            diffuse_reflectance,
            specular_reflectance,
            ..
        } => {
            vec![color(diffuse_reflectance), color(specular_reflectance)]
        }
        Material::Phong {
            diffuse_reflectance,
            specular_reflectance,
            exponent,
        } => {
            vec![
                color(diffuse_reflectance),
                color(specular_reflectance),
                float(exponent),
            ]
        }
        Material::Ward {
            diffuse_reflectance,
            specular_reflectance,
            alpha_u,
            alpha_v,
            ..
        } => {
            vec![
                color(diffuse_reflectance),
                color(specular_reflectance),
                float(alpha_u),
                float(alpha_v),
            ]
        }
        Material::Principled(p) => {
            let inputs = [
                &p.roughness,
                &p.anisotropic,
                &p.metallic,
                &p.spec_trans,
                &p.spec_tint,
                &p.sheen,
                &p.sheen_tint,
                &p.flatness,
                &p.clearcoat,
                &p.clearcoat_gloss,
            ];
            inputs
                .into_iter()
                .map(float)
                .chain([color(&p.base_color)])
                .collect()
        }
        Material::Blend { weight, .. } => vec![float(weight)],
        Material::Mask { opacity, .. } => vec![float(opacity)],
        Material::BumpMap { texture, .. } | Material::NormalMap { texture, .. } => {
            vec![Some(*texture)]
        }
        Material::Null | Material::TwoSided { .. } => Vec::new(),
    };
    found.into_iter().flatten().collect()
}

fn check_color(desc: &SceneDesc, input: ColorInput) -> Checked {
    match input {
        ColorInput::Texture(id) => check_texture(desc, id),
        ColorInput::Constant(_) => Ok(()),
    }
}

fn check_texture(desc: &SceneDesc, id: TextureId) -> Checked {
    check_index("texture", id.index(), desc.textures.len())
}

fn check_index(what: &str, index: usize, count: usize) -> Checked {
    ensure(index < count, || {
        format!("there is no {what} {index}, only {count}")
    })
}

fn title(primitive: &PrimitiveDesc, index: usize) -> String {
    if primitive.name.is_empty() {
        format!("primitive {index}")
    } else {
        format!("primitive \"{}\"", primitive.name)
    }
}

fn in_place(place: &str, error: &SceneError) -> SceneError {
    SceneError {
        message: format!("{place}: {}", error.message),
    }
}

fn ensure(holds: bool, message: impl FnOnce() -> String) -> Checked {
    if holds { Ok(()) } else { fail(message()) }
}

fn fail(message: String) -> Checked {
    Err(SceneError { message })
}
