//! Files of other projects, in the folder that `MANYLIGHT_SCENES` names. Without it, the tests are
//! skipped.

use super::*;
use manylight::scene::Scene;
use std::path::Path;

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
}

#[test]
fn all_files_load_and_build() {
    let Some(folder) = crate::shared_scenes::scenes() else {
        return;
    };
    let mut found = Vec::new();
    files(&folder.join("gltf"), &mut found);
    assert!(!found.is_empty());
    for file in found {
        let loaded = load_scene(&file, &LoadOptions::default());
        let desc = loaded
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
            .desc;
        assert!(!desc.primitives.is_empty(), "{}", file.display());
        Scene::build(desc, 0).unwrap();
    }
}
