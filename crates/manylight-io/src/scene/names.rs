//! Names of shapes and materials, by which mattes identify them, and of light groups.

use manylight::ids::MaterialId;
use manylight::scene::SceneDesc;
use std::collections::HashMap;
use std::path::Path;

/// Distinct names for shapes that the file does not name.
#[derive(Default)]
pub(super) struct ShapeNames {
    /// Number of uses of each name.
    used: HashMap<String, u32>,
}

impl ShapeNames {
    /// `base`, followed by a number if another shape has this name: `rectangle`, `rectangle_2`.
    pub(super) fn distinct(&mut self, base: &str) -> String {
        let uses = self.used.entry(base.to_owned()).or_default();
        *uses += 1;
        match *uses {
            1 => base.to_owned(),
            n => self.distinct(&format!("{base}_{n}")),
        }
    }

    /// Keeps generated names distinct from one of the file.
    pub(super) fn reserve(&mut self, name: &str) {
        *self.used.entry(name.to_owned()).or_default() += 1;
    }

    /// A distinct name from the name of a mesh file, or else from the kind of the shape.
    pub(super) fn of_shape(&mut self, file: Option<&str>, kind: &str) -> String {
        let file = file.map(|file| file.replace('\\', "/"));
        let stem = file.as_deref().map(Path::new).and_then(Path::file_stem);
        let base = stem.map(|stem| stem.to_string_lossy().into_owned());
        self.distinct(base.as_deref().unwrap_or(kind))
    }
}

/// Names the light group of the emitters of `desc` from index `first` on, if there is a name.
pub(super) fn name_light_group(desc: &mut SceneDesc, first: usize, name: Option<&str>) {
    for emitter in first..desc.emitters.len() {
        set_name(&mut desc.emitter_groups, emitter, name.unwrap_or_default());
    }
}

/// Names a material that has no name yet.
pub(super) fn name_material(names: &mut Vec<String>, material: MaterialId, name: &str) {
    set_name(names, material.index(), name);
}

/// Sets the name of index `index`, if there is one and it has no name yet.
pub(super) fn set_name(names: &mut Vec<String>, index: usize, name: &str) {
    if name.is_empty() {
        return;
    }
    if names.len() <= index {
        names.resize(index + 1, String::new());
    }
    if names[index].is_empty() {
        name.clone_into(&mut names[index]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_distinct_names() {
        let mut names = ShapeNames::default();
        let mut of = |file, kind| names.of_shape(file, kind);
        let found = [
            of(None, "sphere"),
            of(Some("models\\sphere_2.ply"), "ply"),
            of(None, "sphere"),
            of(Some("a/Mesh.001.obj"), "obj"),
        ];
        assert_eq!(found, ["sphere", "sphere_2", "sphere_2_2", "Mesh.001"]);
    }
}
