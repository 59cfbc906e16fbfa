//! PBRT scenes: descriptions, and exact messages.

mod errors;
mod materials;
mod power;
mod scenes;
mod textures;
mod values;
mod version3;

use crate::describe;
use manylight::scene::SceneDesc;
use manylight_io::{LoadOptions, LoadedScene, check_scene, load_scene};
use std::path::PathBuf;

/// A temporary folder with `scene.pbrt` and other files.
struct PbrtFiles {
    folder: tempfile::TempDir,
}

impl PbrtFiles {
    fn new(scene: &[u8], others: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in others.iter().chain(&[("scene.pbrt", scene)]) {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, content).unwrap();
        }
        PbrtFiles { folder }
    }

    fn scene(&self) -> PathBuf {
        self.folder.path().join("scene.pbrt")
    }

    fn load(&self) -> LoadedScene {
        load_scene(&self.scene(), &LoadOptions::default()).unwrap_or_else(|error| {
            panic!("{error} at {:?}", error.diagnostic().location);
        })
    }

    /// All problems, as `severity line:column message (help)`.
    fn problems(&self) -> Vec<String> {
        let folder = self.folder.path().display().to_string();
        check_scene(&self.scene(), &LoadOptions::default())
            .iter()
            .map(|diagnostic| describe(diagnostic).replace(&folder, "FOLDER"))
            .collect()
    }
}

/// A scene with a camera, a light and `world`. Line 1 of `world` is line 2 of the file.
fn document(world: &str) -> String {
    format!("Camera \"perspective\" WorldBegin LightSource \"infinite\"\n{world}\n")
}

/// The scene with `world`, which must load.
fn loaded(world: &str) -> LoadedScene {
    PbrtFiles::new(document(world).as_bytes(), &[]).load()
}

/// The description of the scene with `world`, which must load without a warning.
fn load(world: &str) -> SceneDesc {
    let loaded = loaded(world);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

/// The description of a whole file, which must load without a warning.
fn load_file(text: &str) -> SceneDesc {
    let loaded = PbrtFiles::new(text.as_bytes(), &[]).load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

/// All problems of a scene with `world`.
fn problems(world: &str) -> Vec<String> {
    PbrtFiles::new(document(world).as_bytes(), &[]).problems()
}

/// The messages of all warnings of a scene with `world`.
fn warnings(world: &str) -> Vec<String> {
    let warnings = loaded(world).warnings;
    warnings
        .iter()
        .map(|warning| warning.message().to_owned())
        .collect()
}
