//! The checks that a description must pass: after them nothing in the core can fail.

use super::check_emitters::check_emitter;
use super::check_materials::check_materials;
use super::check_sensors::check_sensor;
use super::error::{Checked, check_index, check_transform, ensure, fail, with_context};
use super::nesting::Nesting;
use super::{PrimitiveDesc, SceneDesc};
use crate::geometry::{Mesh, Shape};
use crate::math::Vec3;

/// Checks a scene description. `sensor` is the index of the sensor to render.
pub(super) fn check(desc: &SceneDesc, sensor: usize) -> Checked {
    let Some(camera) = desc.sensors.get(sensor) else {
        return fail(format!(
            "sensor {sensor} was asked for, but the scene has {}",
            desc.sensors.len()
        ));
    };
    check_sensor(camera)?;
    for (i, shape) in desc.shapes.iter().enumerate() {
        check_shape(shape).map_err(|e| with_context(&format!("shape {i}"), &e))?;
    }
    check_textures(desc)?;
    check_materials(desc)?;
    for (i, emitter) in desc.emitters.iter().enumerate() {
        check_emitter(desc, emitter).map_err(|e| with_context(&format!("emitter {i}"), &e))?;
    }
    for (i, primitive) in desc.primitives.iter().enumerate() {
        check_primitive(desc, primitive).map_err(|e| with_context(&title(primitive, i), &e))?;
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
        check.map_err(|e| with_context(&format!("in a group, {}", title(primitive, i)), &e))?;
    }
    for (i, instance) in desc.instances.iter().enumerate() {
        let check = check_index("group", instance.group, desc.groups.len())
            .and_then(|()| check_transform(&instance.world_from_group));
        check.map_err(|e| with_context(&format!("instance {i}"), &e))?;
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
        (desc.emitters[emitter.index()].surface_radiance()).is_some(),
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
    let attributes = [
        ("normals", mesh.normals.len()),
        ("tangents", mesh.tangents.len()),
        ("uvs", mesh.uvs.len()),
    ];
    for (name, len) in attributes {
        ensure(len == 0 || len == count, || {
            format!("{len} {name} for {count} positions; none or one each expected")
        })?;
    }
    ensure(mesh.tangents.is_empty() || !mesh.normals.is_empty(), || {
        "tangents without normals".to_owned()
    })?;
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

/// Checks that the textures of a description can be evaluated. A nested texture must precede the
/// texture that contains it, so that there are no cycles. [`Scene::build`](super::Scene::build)
/// checks this, too; a loader that evaluates textures needs it before.
///
/// # Errors
/// A texture contains one that is not before it, is nested too deep, or has too many parts.
pub fn check_textures(desc: &SceneDesc) -> Result<(), super::SceneError> {
    let mut nestings: Vec<Nesting> = Vec::with_capacity(desc.textures.len());
    for (i, texture) in desc.textures.iter().enumerate() {
        ensure(texture.has_valid_indices(), || {
            format!("texture {i} has an index of a vertex without a value")
        })?;
        for nested in texture.nested() {
            ensure(nested.index() < i, || {
                format!(
                    "texture {i} contains texture {}, which is not before it",
                    nested.0
                )
            })?;
        }
        let inner = texture.nested().map(|nested| nestings[nested.index()]);
        nestings.push(Nesting::of(&format!("texture {i}"), inner)?);
    }
    Ok(())
}

/// The name of a primitive in messages.
fn title(primitive: &PrimitiveDesc, index: usize) -> String {
    if primitive.name.is_empty() {
        format!("primitive {index}")
    } else {
        format!("primitive \"{}\"", primitive.name)
    }
}
