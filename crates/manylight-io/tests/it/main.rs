//! Loading of scene files: descriptions, and exact messages.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "test helpers may panic and print"
)]

mod attributes;
mod emitters;
mod errors;
mod exhausting;
mod gltf;
mod materials;
mod names;
mod pbrt;
mod projectors;
mod shared_scenes;
mod skies;
mod upgrade;
mod values;

use manylight::scene::SceneDesc;
use manylight_io::{Diagnostic, LoadOptions, LoadedScene, Severity, check_scene, load_scene};
use std::path::PathBuf;

/// A temporary folder with the files of a scene.
struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    /// Writes `scene` to `scene.xml`, and `others` as pairs of name and content.
    fn new(scene: &str, others: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in others.iter().chain(&[("scene.xml", scene)]) {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        Files { folder }
    }

    fn scene(&self) -> PathBuf {
        self.folder.path().join("scene.xml")
    }

    fn load(&self) -> LoadedScene {
        load_scene(&self.scene(), &LoadOptions::default()).unwrap_or_else(|error| {
            panic!("{error} at {:?}", error.diagnostic().location);
        })
    }
}

/// A scene with a sensor, an emitter and `content`.
fn document(version: &str, content: &str) -> String {
    format!(
        "<scene version=\"{version}\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>\n{content}\n</scene>"
    )
}

/// The description of a scene of version 3 with `content`, which must load without a warning.
fn load(content: &str) -> SceneDesc {
    load_version("3.0.0", content)
}

fn load_version(version: &str, content: &str) -> SceneDesc {
    let loaded = Files::new(&document(version, content), &[]).load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

/// All problems of a scene with `content`, as `severity line:column message (help)`. Line 1 of
/// `content` is line 2 of the file.
fn problems(version: &str, content: &str) -> Vec<String> {
    let files = Files::new(&document(version, content), &[]);
    let folder = files.folder.path().display().to_string();
    let found = check_scene(&files.scene(), &LoadOptions::default());
    found
        .iter()
        .map(|diagnostic| describe(diagnostic).replace(&folder, "FOLDER"))
        .collect()
}

fn describe(diagnostic: &Diagnostic) -> String {
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let place = diagnostic
        .location
        .as_ref()
        .map_or(String::new(), |at| format!("{}:{}", at.line(), at.column()));
    let help = diagnostic
        .help
        .as_ref()
        .map_or(String::new(), |help| format!(" ({help})"));
    format!("{severity} {place} {}{help}", diagnostic.message)
}
