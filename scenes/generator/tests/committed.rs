//! The scenes in the repository equal the output of the generators, and the output is valid.

use manylight_scenes::files::{self, Format};
use manylight_scenes::scene::Scene;
use manylight_scenes::scenes::{Detail, GENERATORS};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Size in bytes and CRC-32 of the files of each scene as glTF.
const GLTF_CHECKSUMS: [(&str, (usize, u32)); 4] = [
    ("u-shape", (923_770, 0x1e7a_9b27)),
    ("kitchen", (1_283_035, 0xa618_ae0a)),
    ("garage", (2_046_100, 0x0862_9fb8)),
    ("disco", (1_183_853, 0xddb6_ae6c)),
];

fn folder_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// All scenes at the level of detail of the repository.
fn scenes() -> impl Iterator<Item = (&'static str, Scene)> {
    GENERATORS
        .iter()
        .map(|generator| (generator.name, (generator.generate)(Detail::default())))
}

#[test]
fn committed_files_equal_generated_files() {
    for (name, scene) in scenes() {
        let folder = folder_of(name);
        let mut expected = BTreeSet::new();
        for (path, bytes) in files::of(&scene, &Format::COMMITTED).unwrap() {
            let path = folder.join(path);
            let committed = fs::read(&path).unwrap_or_default();
            assert!(
                committed == bytes,
                "{} differs from the generated file; to write it again: cargo run --release -p manylight-scenes -- {name} -o scenes/{name}",
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

/// Size and checksum of all files of a scene as glTF.
fn gltf_checksum(scene: &Scene) -> (usize, u32) {
    let mut size = 0;
    let mut crc = flate2::Crc::new();
    for (path, bytes) in files::of(scene, &[Format::Gltf]).expect("textures compress") {
        crc.update(path.to_string_lossy().as_bytes());
        crc.update(&bytes);
        size += bytes.len();
    }
    (size, crc.sum())
}

#[test]
fn gltf_files_are_the_same_on_every_platform() {
    // The files are not in the repository, because glTF cannot share the meshes of the other
    // formats.
    let expected = GLTF_CHECKSUMS;
    let found: Vec<_> = scenes()
        .map(|(name, scene)| (name, gltf_checksum(&scene)))
        .collect();
    assert_eq!(found, expected, "left: generated, right: expected");
}

/// Names in quotes that follow `key` in a PBRT file.
fn names_after<'a>(text: &'a str, key: &str) -> BTreeSet<&'a str> {
    let rests = text.split(key).skip(1);
    rests
        .map(|rest| rest.split('"').nth(1).unwrap_or_default())
        .collect()
}

#[test]
fn names_in_pbrt_files_resolve() {
    for (name, scene) in scenes() {
        let text = manylight_scenes::pbrt::encode(&scene);
        let materials = names_after(&text, "MakeNamedMaterial ");
        let used = names_after(&text, "\tNamedMaterial ");
        let undefined: Vec<_> = used.difference(&materials).collect();
        assert!(undefined.is_empty(), "{name}: {undefined:?}");
        let textures = names_after(&text, "\nTexture ");
        for key in ["texture reflectance\" ", "texture amount\" "] {
            let used = names_after(&text, key);
            let undefined: Vec<_> = used.difference(&textures).collect();
            assert!(undefined.is_empty(), "{name}: {undefined:?}");
        }
        let begins = text.matches("AttributeBegin").count();
        assert_eq!(begins, text.matches("AttributeEnd").count());
        assert_eq!(begins, scene.shapes.len());
    }
}

#[test]
fn scene_files_parse_and_their_ids_resolve() {
    for (name, scene) in scenes() {
        let text = manylight_scenes::mitsuba::encode(&scene);
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut ids = BTreeSet::new();
        for node in document
            .descendants()
            .filter(|node| !node.has_tag_name("ref"))
        {
            if let Some(id) = node.attribute("id") {
                assert!(ids.insert(id), "{name} defines '{id}' twice");
            }
        }
        for node in document
            .descendants()
            .filter(|node| node.has_tag_name("ref"))
        {
            let id = node.attribute("id").unwrap();
            assert!(ids.contains(id), "{name} refers to the undefined '{id}'");
        }
    }
}

#[test]
fn meshes_are_finite_with_unit_normals() {
    for (name, scene) in scenes() {
        for (mesh_name, mesh) in &scene.meshes {
            let finite = mesh
                .positions
                .iter()
                .chain(&mesh.normals)
                .all(|v| v.is_finite());
            assert!(finite, "{name}: {mesh_name} has a value that is not finite");
            let unit = mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6);
            assert!(
                unit,
                "{name}: {mesh_name} has a normal that is not a unit vector"
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
