//! Names of objects and materials, as mattes identify them.

use super::{InstanceDesc, PrimitiveDesc, SceneDesc};
use crate::bsdf::Material;
use crate::film::IdLayer;
use crate::geometry::SurfaceRef;
use crate::ids::{MaterialId, PrimitiveId};
use std::collections::{HashMap, HashSet};

/// Names of the objects and materials of a scene. An index of a name is an id of an [`IdLayer`];
/// parts with the same name have the same id.
///
/// The object of a primitive has the primitive's name, or inside of an instance that has a name,
/// the instance's. Surfaces without a name are numbered: `object_3`.
#[derive(Clone, Debug, Default)]
pub struct SurfaceNames {
    objects: NameTable,
    materials: NameTable,
    of_primitives: Vec<u32>,
    /// `None`: the primitive's name.
    of_instances: Vec<Option<u32>>,
    of_materials: Vec<u32>,
}

impl SurfaceNames {
    pub(super) fn new(desc: &SceneDesc) -> Self {
        let mut objects = NameTable::with_reserved(
            primitives(desc).map(|p| p.name.as_str()),
            desc.instances.iter().map(|i| i.name.as_str()),
        );
        let of_primitives = primitives(desc)
            .enumerate()
            .map(|(i, p)| objects.index("object", i, &p.name))
            .collect();
        let of_instance = |i: &InstanceDesc| (!i.name.is_empty()).then(|| objects.add(&i.name));
        let of_instances = desc.instances.iter().map(of_instance).collect();
        let named = |i| material_name(desc, i);
        let all = 0..desc.materials.len();
        let mut materials = NameTable::with_reserved(all.clone().map(named), std::iter::empty());
        let of_materials = all
            .map(|i| materials.index("material", i, named(i)))
            .collect();
        SurfaceNames {
            objects,
            materials,
            of_primitives,
            of_instances,
            of_materials,
        }
    }

    /// All names of an id layer, by id. Some may belong to no visible surface.
    pub fn names(&self, layer: IdLayer) -> &[String] {
        match layer {
            IdLayer::Object => &self.objects.names,
            IdLayer::Material => &self.materials.names,
        }
    }

    /// Id of the object at a surface point.
    pub fn object(&self, at: SurfaceRef) -> u32 {
        let of_instance = self.of_instances.get(at.instance as usize).copied();
        of_instance
            .flatten()
            .unwrap_or(self.of_primitives[at.primitive.index()])
    }

    /// Name of the object of a primitive outside of instances.
    pub fn of_primitive(&self, primitive: PrimitiveId) -> &str {
        &self.objects.names[self.of_primitives[primitive.index()] as usize]
    }

    /// Id of a material.
    pub fn material(&self, material: MaterialId) -> u32 {
        self.of_materials[material.index()]
    }
}

/// All primitives, in the order of their ids.
fn primitives(desc: &SceneDesc) -> impl Iterator<Item = &PrimitiveDesc> {
    desc.primitives.iter().chain(desc.groups.iter().flatten())
}

/// The name of a material, or else that of the material it modifies; empty if there is none.
fn material_name(desc: &SceneDesc, mut index: usize) -> &str {
    loop {
        let name = desc.material_names.get(index).map_or("", String::as_str);
        let inner = match desc.materials.get(index) {
            Some(material) if name.is_empty() => modified(material),
            _ => None,
        };
        match inner {
            Some(inner) => index = inner.index(),
            None => return name,
        }
    }
}

/// Distinct names in the order of addition.
#[derive(Clone, Debug, Default)]
struct NameTable {
    names: Vec<String>,
    indices: HashMap<String, u32>,
    /// Names of the file, which numbered names must avoid.
    reserved: HashSet<String>,
}

impl NameTable {
    fn with_reserved<'a>(
        first: impl Iterator<Item = &'a str>,
        second: impl Iterator<Item = &'a str>,
    ) -> Self {
        NameTable {
            reserved: first.chain(second).map(str::to_owned).collect(),
            ..NameTable::default()
        }
    }

    /// Index of `name`, or of a numbered name if it is empty.
    fn index(&mut self, kind: &str, number: usize, name: &str) -> u32 {
        if !name.is_empty() {
            return self.add(name);
        }
        let mut numbered = format!("{kind}_{number}");
        while self.reserved.contains(&numbered) {
            numbered.push('_');
        }
        self.add(&numbered)
    }

    fn add(&mut self, name: &str) -> u32 {
        if let Some(&index) = self.indices.get(name) {
            return index;
        }
        let index = self.names.len() as u32;
        self.names.push(name.to_owned());
        self.indices.insert(name.to_owned(), index);
        index
    }
}

/// The only material that a wrapper modifies.
fn modified(material: &Material) -> Option<MaterialId> {
    match *material {
        Material::Mask { inner, .. }
        | Material::BumpMap { inner, .. }
        | Material::NormalMap { inner, .. } => Some(inner),
        Material::TwoSided { front, back } if front == back => Some(front),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::{PrimitiveId, ShapeId};
    use crate::math::{Affine3A, Vec2};

    fn primitive(name: &str) -> PrimitiveDesc {
        PrimitiveDesc {
            name: name.to_owned(),
            shape: ShapeId(0),
            world_from_object: Affine3A::IDENTITY,
            flip_normals: false,
            material: MaterialId(0),
            emitter: None,
        }
    }

    fn instance(name: &str) -> InstanceDesc {
        InstanceDesc {
            name: name.to_owned(),
            group: 0,
            world_from_group: Affine3A::IDENTITY,
        }
    }

    fn at(primitive: u32, instance: u32) -> SurfaceRef {
        SurfaceRef {
            primitive: PrimitiveId(primitive),
            element: 0,
            instance,
            coordinates: Vec2::ZERO,
        }
    }

    #[test]
    fn objects_have_distinct_names() {
        let names = SurfaceNames::new(&SceneDesc {
            primitives: ["chair", "", "chair", "object_1"].map(primitive).into(),
            groups: vec![vec![primitive("leaf")]],
            instances: vec![instance(""), instance("tree")],
            ..SceneDesc::default()
        });
        let name = |primitive, instance| {
            let id = names.object(at(primitive, instance)) as usize;
            names.names(IdLayer::Object)[id].as_str()
        };
        let world = SurfaceRef::NO_INSTANCE;
        let found = [0, 1, 2, 3].map(|i| name(i, world));
        assert_eq!(found, ["chair", "object_1_", "chair", "object_1"]);
        assert_eq!([name(4, 0), name(4, 1)], ["leaf", "tree"]);
        assert_eq!(names.object(at(0, world)), names.object(at(2, world)));
    }

    #[test]
    fn wrappers_have_the_name_of_what_they_modify() {
        let [inner, bump] = [MaterialId(0), MaterialId(2)];
        let mask = |inner| Material::Mask {
            opacity: crate::texture::FloatInput::Constant(0.5),
            inner,
        };
        let two_sided = Material::TwoSided {
            front: inner,
            back: bump,
        };
        let names = SurfaceNames::new(&SceneDesc {
            materials: vec![
                Material::Null,
                mask(inner),
                mask(bump),
                two_sided,
                mask(inner),
            ],
            material_names: vec!["bark".into(), String::new(), "moss".into()],
            ..SceneDesc::default()
        });
        let found = [0, 1, 2, 3, 4].map(|i| {
            let id = names.material(MaterialId(i)) as usize;
            names.names(IdLayer::Material)[id].as_str()
        });
        assert_eq!(found, ["bark", "bark", "moss", "material_3", "bark"]);
    }
}
