//! Light groups: the film has one layer for the light of all emitters of a group.
//!
//! The light of surfaces is told apart by primitive: primitives of several groups may share an
//! emitter, as surfaces of one material do in some files.

use super::SceneDesc;
use crate::emitters::{EmissionSource, Emitters};
use crate::ids::{EmitterId, LightGroup, PrimitiveId};
use std::collections::HashMap;

/// Name of the group of sources without a name.
pub const REST: &str = "rest";

/// A name for each source of emission. Sources with the same name are a light group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroupNames(pub Vec<(EmissionSource, String)>);

impl LightGroupNames {
    /// The names in a description. The name of a surface is that of its primitive in
    /// [`SceneDesc::primitive_groups`], else that of its emitter in [`SceneDesc::emitter_groups`],
    /// else the primitive's own.
    pub fn of(desc: &SceneDesc) -> Self {
        let named = |names: &[String], index: usize| -> Option<String> {
            names.get(index).filter(|name| !name.is_empty()).cloned()
        };
        let of_emitter = |index: usize| named(&desc.emitter_groups, index);
        let rest = || REST.to_owned();
        let mut names = Vec::new();
        for (i, primitive) in desc.primitives.iter().enumerate() {
            if let Some(emitter) = primitive.emitter {
                let own = Some(primitive.name.clone()).filter(|name| !name.is_empty());
                let name = named(&desc.primitive_groups, i).or_else(|| of_emitter(emitter.index()));
                let source = EmissionSource::Surface(PrimitiveId::from(i));
                names.push((source, name.or(own).unwrap_or_else(rest)));
            }
        }
        for (i, emitter) in desc.emitters.iter().enumerate() {
            if emitter.surface_radiance().is_none() {
                let source = EmissionSource::Emitter(EmitterId::from(i));
                names.push((source, of_emitter(i).unwrap_or_else(rest)));
            }
        }
        LightGroupNames(names)
    }
}

/// The light groups of a scene. Every source of emission belongs to one of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightGroups {
    names: Vec<String>,
    /// By emitter; any group for emitters of surfaces.
    of_emitters: Vec<LightGroup>,
    /// By primitive up to the last that emits; any group for those that do not.
    of_primitives: Vec<LightGroup>,
    /// The group of all emitters that fill directions at infinity; `None` if they have several.
    of_environment: Option<LightGroup>,
}

impl LightGroups {
    /// The groups of sources with these names.
    pub(super) fn new(names: &LightGroupNames, emitters: &Emitters) -> Self {
        let mut groups = LightGroups {
            of_emitters: vec![LightGroup::default(); emitters.descriptions().len()],
            ..LightGroups::default()
        };
        let mut indices: HashMap<&str, usize> = HashMap::new();
        for (source, name) in &names.0 {
            let next = indices.len();
            let index = *indices.entry(name).or_insert(next);
            if index == groups.names.len() {
                groups.names.push(name.clone());
            }
            // Of a scene with too many groups, no picture has layers.
            let group = LightGroup(index.min(LightGroup::MAX) as u8);
            match source {
                EmissionSource::Surface(primitive) => {
                    let count = groups.of_primitives.len().max(primitive.index() + 1);
                    groups.of_primitives.resize(count, LightGroup::default());
                    groups.of_primitives[primitive.index()] = group;
                }
                EmissionSource::Emitter(emitter) => groups.of_emitters[emitter.index()] = group,
            }
        }
        let mut lights = emitters.environment_lights();
        let first = lights.next().map(|id| groups.of_emitters[id.index()]);
        let first = first.unwrap_or_default();
        let is_same = lights.all(|id| groups.of_emitters[id.index()] == first);
        groups.of_environment = is_same.then_some(first);
        groups
    }

    /// Names of the groups, in the order of their first sources.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of groups.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Whether a picture can have a layer for each group.
    pub fn are_recordable(&self) -> bool {
        (1..=LightGroup::MAX).contains(&self.count())
    }

    /// The group of a source.
    #[inline]
    pub fn of(&self, source: EmissionSource) -> LightGroup {
        match source {
            EmissionSource::Surface(primitive) => self.of_primitives[primitive.index()],
            EmissionSource::Emitter(emitter) => self.of_emitters[emitter.index()],
        }
    }

    /// The group of all emitters that fill directions at infinity; `None` if they have several.
    #[inline]
    pub fn of_environment(&self) -> Option<LightGroup> {
        self.of_environment
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::emitters::Emitter;
    use crate::ids::{MaterialId, ShapeId};
    use crate::math::Affine3A;
    use crate::scene::PrimitiveDesc;
    use crate::texture::ColorInput;

    fn surface(name: &str, emitter: u32) -> PrimitiveDesc {
        PrimitiveDesc {
            name: name.into(),
            shape: ShapeId(0),
            world_from_object: Affine3A::IDENTITY,
            flip_normals: false,
            material: MaterialId(0),
            emitter: Some(EmitterId(emitter)),
        }
    }

    #[test]
    fn names_come_from_the_primitive_the_emitter_or_the_shape() {
        let area = Emitter::Area {
            radiance: ColorInput::Constant(Rgb::WHITE),
        };
        let sky = Emitter::Constant {
            radiance: Rgb::WHITE,
        };
        let strings = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let names = LightGroupNames::of(&SceneDesc {
            primitives: vec![surface("lamp", 0), surface("bulb", 1), surface("", 1)],
            emitters: vec![area.clone(), area, sky.clone(), sky],
            primitive_groups: strings(&["key"]),
            emitter_groups: strings(&["warm", "", "sky"]),
            ..SceneDesc::default()
        });
        let found: Vec<&str> = names.0.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(found, ["key", "bulb", REST, "sky", REST]);
    }
}
