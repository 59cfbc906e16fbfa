//! Scene files.

use crate::folder::{with_file, with_files};
use crate::messages::check_diagnostic;
use manylight::math::UVec2;
use manylight::scene::{Scene, SceneDesc};
use manylight_io::{LoadOptions, Severity, check_scene, load_scene};
use std::path::Path;

/// Loads the scene of an input of several files; the scene file is called `name`.
pub(crate) fn check(input: &[u8], name: &str) {
    with_files(input, name, check_file);
}

/// Loads a scene of one file, `scene.glb`. Its JSON may name other files of the folder.
pub(crate) fn check_glb(input: &[u8]) {
    with_file(input, "scene.glb", check_file);
}

fn check_file(path: &Path) {
    let options = LoadOptions::default();
    let problems = check_scene(path, &options);
    problems
        .iter()
        .for_each(|problem| check_diagnostic(problem));
    if problems
        .iter()
        .any(|problem| problem.severity == Severity::Error)
    {
        return;
    }
    match load_scene(path, &options) {
        Ok(loaded) => build(loaded.desc),
        Err(error) => panic!("an error that `check_scene` does not report: {error}"),
    }
}

/// Builds the scene with a small film: the size of the film is that of an option, not of a reader.
fn build(mut desc: SceneDesc) {
    for sensor in &mut desc.sensors {
        sensor.film = sensor.film.with_size(UVec2::splat(4));
    }
    for sensor in 0..desc.sensors.len().min(2) {
        if let Err(error) = Scene::build(desc.clone(), sensor) {
            assert!(!error.message.trim().is_empty());
        }
    }
}
