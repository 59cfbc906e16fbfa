//! Compressed geometry. The files in `data` are a bent square of 5x5 vertices, `z = sin(2x) / 4`,
//! compressed by gltf-transform 4: by `draco`, `draco --method sequential`, and
//! `meshopt --level high`.

use super::*;
use manylight::math::{Vec2, Vec3};

/// Checks the vertices against the formula of the surface, up to the quantization of the files.
#[cfg(any(feature = "draco", feature = "meshopt"))]
fn assert_is_bent_square(file: &[u8]) {
    let folder = Folder::with_bytes("scene.glb", file);
    let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
    let mesh = mesh(&loaded.desc, 0);
    let place = loaded.desc.primitives[0].world_from_object;
    let positions = mesh.positions.iter().map(|p| place.transform_point3(*p));
    let positions: Vec<Vec3> = positions.collect();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (25, 32));
    for (i, p) in positions.iter().enumerate() {
        assert!((p.z - 0.25 * (2.0 * p.x).sin()).abs() < 1e-3, "{p}");
        let n = Vec3::new(-0.5 * (2.0 * p.x).cos(), 0.0, 1.0).normalize();
        assert!(
            mesh.normals[i].distance(n) < 0.02,
            "{} for {n}",
            mesh.normals[i]
        );
        let uv = Vec2::new(p.x, 1.0 - p.y);
        assert!(mesh.uvs[i].distance(uv) < 2e-3, "{} for {uv}", mesh.uvs[i]);
    }
    let corners = |t: &[u32; 3]| t.map(|i| positions[i as usize].truncate());
    let areas = mesh
        .triangles
        .iter()
        .map(corners)
        .map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a));
    for area in areas {
        assert!((area - 1.0 / 32.0).abs() < 1e-3, "{area}");
    }
}

/// The bytes of `file` in which each occurrence of `from` is replaced by `to`, of the same length.
fn replaced(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = file.to_vec();
    let starts = 0..bytes.len() - from.len();
    let found: Vec<usize> = starts
        .filter(|i| bytes[*i..].starts_with(from.as_bytes()))
        .collect();
    assert!(!found.is_empty(), "{from}");
    for start in found {
        bytes[start..start + to.len()].copy_from_slice(to.as_bytes());
    }
    bytes
}

/// The errors of a file.
fn errors(file: &[u8]) -> Vec<String> {
    let mut problems = Folder::with_bytes("scene.glb", file).problems();
    problems.retain(|problem| problem.starts_with("error"));
    problems
}

const DRACO: &[u8] = include_bytes!("data/draco.glb");
const DRACO_SEQUENTIAL: &[u8] = include_bytes!("data/draco-sequential.glb");
const MESHOPT: &[u8] = include_bytes!("data/meshopt.glb");

#[cfg(feature = "draco")]
#[test]
fn draco_gives_the_original_vertices() {
    assert_is_bent_square(DRACO);
    assert_is_bent_square(DRACO_SEQUENTIAL);
}

#[cfg(feature = "draco")]
#[test]
fn damaged_draco_data_is_one_error_of_its_place() {
    let at = "/meshes/0/primitives/0";
    let cases = [
        (
            replaced(DRACO, "\"bufferView\":1,", "\"bufferView\":9,"),
            format!("{at}/extensions/KHR_draco_mesh_compression/bufferView: found 9"),
        ),
        (
            replaced(DRACO, "\"NORMAL\":1,", "\"NORMAL\":7,"),
            format!(
                "{at}/extensions/KHR_draco_mesh_compression/attributes/NORMAL: the compressed data has no attribute 7"
            ),
        ),
        (
            replaced(DRACO, "\"count\":96", "\"count\":93"),
            "/accessors/0: found 93 elements of 2 bytes, but the compressed data has 96".into(),
        ),
        (
            replaced(DRACO, "\"mode\":4", "\"mode\":5"),
            format!("{at}/mode: found 5, expected 4 (triangles) in compressed geometry"),
        ),
        (
            replaced(DRACO, "DRACO\u{2}", "DRAKO\u{2}"),
            format!("{at}/extensions/KHR_draco_mesh_compression: the Draco data cannot be decoded"),
        ),
    ];
    for (file, expected) in cases {
        let errors = errors(&file);
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(errors[0].contains(&expected), "{errors:?} for {expected}");
    }
}

/// Every byte of the compressed data is damaged in turn: an error or another mesh, never a panic.
#[cfg(any(feature = "draco", feature = "meshopt"))]
fn assert_survives_damage(file: &[u8], data: std::ops::Range<usize>) {
    for i in data {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = file.to_vec();
            bytes[i] ^= flip;
            errors(&bytes);
        }
    }
}

/// The data chunk of a binary file.
#[cfg(any(feature = "draco", feature = "meshopt"))]
fn data_of(file: &[u8]) -> std::ops::Range<usize> {
    let json = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    28 + json..file.len()
}

#[cfg(feature = "draco")]
#[test]
fn damaged_bytes_of_draco_data_do_not_panic() {
    assert_survives_damage(DRACO, data_of(DRACO));
    assert_survives_damage(DRACO_SEQUENTIAL, data_of(DRACO_SEQUENTIAL));
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_gives_the_original_vertices() {
    assert_is_bent_square(MESHOPT);
    assert_survives_damage(MESHOPT, data_of(MESHOPT));
}

#[cfg(feature = "meshopt")]
#[test]
fn damaged_meshopt_data_is_an_error_of_its_place() {
    let at = "/extensions/EXT_meshopt_compression";
    let cases = [
        (
            replaced(MESHOPT, "\"count\":96}", "\"count\":95}"),
            format!("/bufferViews/1{at}/count: found 95, expected a multiple of 3"),
        ),
        (
            replaced(MESHOPT, "OCTAHEDRAL", "OCTAHEDRON"),
            format!("/bufferViews/2{at}/filter: found `OCTAHEDRON` with a stride of 4 bytes"),
        ),
        (
            replaced(MESHOPT, "TRIANGLES", "TRIANGLEX"),
            format!("/bufferViews/1{at}/mode: found `TRIANGLEX`"),
        ),
    ];
    for (file, expected) in cases {
        let errors = errors(&file);
        assert!(errors[0].contains(&expected), "{errors:?} for {expected}");
    }
}

#[cfg(not(feature = "meshopt"))]
#[test]
fn without_its_decoder_meshopt_is_refused_by_name() {
    let errors = errors(MESHOPT);
    assert!(
        errors[0].contains("compressed by the extension `EXT_meshopt_compression` is not read by this build build with `--features meshopt`"),
        "{errors:?}"
    );
    // What is stored uncompressed as well is read.
    let mut document = triangle();
    let compressed = json!({ "EXT_meshopt_compression": { "buffer": 0, "byteLength": 4, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES" } });
    set(&mut document, "/bufferViews/0/extensions", compressed);
    set(
        &mut document,
        "/extensionsUsed/1",
        json!("EXT_meshopt_compression"),
    );
    assert_eq!(mesh(&load(&document), 0).positions[1], Vec3::X);
}

#[cfg(not(feature = "meshopt"))]
#[test]
fn each_name_of_the_extension_has_one_error_for_all_views() {
    for (name, expands) in [
        ("EXT_meshopt_compression", true),
        ("KHR_meshopt_compression", false),
    ] {
        let file = replaced(MESHOPT, "EXT_meshopt_compression", name);
        let errors = errors(&file);
        let named: Vec<&String> = errors.iter().filter(|e| e.contains(name)).collect();
        assert_eq!(named.len(), 1, "{errors:?}");
        assert_eq!(named[0].contains("gltf-transform copy"), expands);
    }
}
