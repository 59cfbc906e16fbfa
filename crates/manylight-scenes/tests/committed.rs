//! The scenes that the repository holds are what the generators write.

use manylight_scenes::files;
use manylight_scenes::scene::Scene;
use manylight_scenes::scenes::{Detail, GENERATORS};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn folder_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenes")
        .join(name)
}

/// All scenes at the detail of the repository.
fn scenes() -> impl Iterator<Item = (&'static str, Scene)> {
    GENERATORS
        .iter()
        .map(|generator| (generator.name, (generator.generate)(Detail::default())))
}

#[test]
fn files_are_the_same_bytes() {
    for (name, scene) in scenes() {
        let folder = folder_of(name);
        let mut expected = BTreeSet::new();
        for (path, bytes) in files::of(&scene).unwrap() {
            let path = folder.join(path);
            let held = fs::read(&path).unwrap_or_default();
            assert!(
                held == bytes,
                "{} is not what is generated: cargo run --release -p manylight-scenes -- {name} -o scenes/{name}",
                path.display()
            );
            expected.insert(path);
        }
        for part in ["meshes", "textures"] {
            for entry in fs::read_dir(folder.join(part)).into_iter().flatten() {
                let path = entry.unwrap().path();
                assert!(
                    expected.contains(&path),
                    "{} is not generated",
                    path.display()
                );
            }
        }
    }
}

#[test]
fn documents_parse_and_names_are_unique() {
    for (name, scene) in scenes() {
        let text = manylight_scenes::mitsuba::encode(&scene);
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut ids = BTreeSet::new();
        for node in document
            .descendants()
            .filter(|node| !node.has_tag_name("ref"))
        {
            if let Some(id) = node.attribute("id") {
                assert!(ids.insert(id), "{name} has two of '{id}'");
            }
        }
        for node in document
            .descendants()
            .filter(|node| node.has_tag_name("ref"))
        {
            let id = node.attribute("id").unwrap();
            assert!(ids.contains(id), "{name} refers to '{id}'");
        }
    }
}

#[test]
fn meshes_are_sound() {
    for (name, scene) in scenes() {
        for (mesh_name, mesh) in &scene.meshes {
            let finite = mesh
                .positions
                .iter()
                .chain(&mesh.normals)
                .all(|v| v.is_finite());
            assert!(finite, "{name}: {mesh_name} has a number that is none");
            let unit = mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6);
            assert!(
                unit,
                "{name}: {mesh_name} has a normal that is not of length one"
            );
        }
    }
}

#[test]
fn detail_adds_triangles() {
    for generator in GENERATORS {
        let triangles = |level: u32| {
            let detail = Detail::new(level).unwrap();
            (generator.generate)(detail).triangle_count()
        };
        assert!(2 * triangles(3) > 3 * triangles(1), "{}", generator.name);
    }
}
