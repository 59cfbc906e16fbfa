//! From a checked description to a scene.

use super::check::check;
use super::{InstanceDesc, PrimitiveDesc, Scene, SceneDesc, SceneError, SurfaceNames};
use crate::bsdf::Materials;
use crate::emitters::Emitters;
use crate::geometry::{Geometry, Instance, Primitive};
use crate::sensors::Sensor;

/// See [`Scene::build`].
pub(super) fn build(mut desc: SceneDesc, sensor: usize) -> Result<Scene, SceneError> {
    check(&desc, sensor)?;
    let names = SurfaceNames::new(&desc);
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
        names,
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

/// The ranges of the groups' primitives, in a list that starts with `first` other primitives.
fn group_ranges(first: usize, groups: &[Vec<PrimitiveDesc>]) -> Vec<std::ops::Range<usize>> {
    let ranges = groups.iter().scan(first, |start, group| {
        let range = *start..*start + group.len();
        *start = range.end;
        Some(range)
    });
    ranges.collect()
}
