//! Invalid files: one message with the JSON path, and no panic.

use super::invalid::invalid;
use super::*;
use manylight_io::LoadErrorKind;
use std::time::{Duration, Instant};

#[test]
fn each_mistake_gives_one_error_with_its_path() {
    let mut wrong = Vec::new();
    for (path, value, expected) in invalid() {
        let started = Instant::now();
        let found = Folder::new(&changed(&[(path, value.clone())])).problems();
        let errors: Vec<&String> = found.iter().filter(|p| p.starts_with("error")).collect();
        let is_expected = matches!(errors.as_slice(), [only] if only.contains(expected));
        if !is_expected || started.elapsed() > Duration::from_secs(2) {
            wrong.push(format!(
                "{path} = {value}\n  found    {found:#?}\n  expected {expected}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn values_that_are_not_finite_or_not_vertices_are_errors() {
    let mut document = triangle();
    let nan = bytes_of(&[0.0, 0.0, 0.0, 1.0, f32::NAN, 0.0, 0.0, 1.0, 0.0]);
    let accessor = add_accessor(&mut document, &nan, 5126, 3, "VEC3");
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/POSITION",
        json!(accessor),
    );
    let found = Folder::new(&document).problems();
    assert!(
        found[0]
            .starts_with("error /accessors/4: element 1 is not finite: [1.0, NaN, 0.0] (used by"),
        "{found:?}"
    );

    let mut document = triangle();
    let accessor = add_accessor(&mut document, &[0, 1, 3], 5121, 3, "SCALAR");
    set(
        &mut document,
        "/meshes/0/primitives/0/indices",
        json!(accessor),
    );
    let found = Folder::new(&document).problems();
    assert!(
        found[0].contains("/meshes/0/primitives/0/indices: index 2 is 3, expected less than 3"),
        "{found:?}"
    );
}

#[test]
fn syntax_errors_have_line_and_column() {
    let folder = Folder::with_bytes(
        "scene.gltf",
        b"{\n  \"asset\": {\n    \"version\" \"2.0\"\n",
    );
    let found = folder.problems();
    assert_eq!(found.len(), 1);
    assert!(
        found[0].contains("FOLDER/scene.gltf:3:15: malformed JSON: expected `:`"),
        "{found:?}"
    );
    let empty = Folder::with_bytes("scene.gltf", b"").problems();
    assert!(empty[0].contains("malformed JSON: EOF"), "{empty:?}");
    let text = Folder::with_bytes("scene.gltf", b"{ \"a\": \"\xff\" }").problems();
    assert!(
        text[0].contains("not UTF-8: invalid byte at offset 8"),
        "{text:?}"
    );
}

#[test]
fn damaged_binary_files_are_errors() {
    let whole = binary_triangle();
    assert!(
        Folder::with_bytes("scene.glb", &whole)
            .problems()
            .is_empty()
    );
    let with = |at: usize, bytes: &[u8]| {
        let mut file = whole.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let cases = [
        (
            whole[..9].to_vec(),
            "the file ends in its header: found 9 bytes",
        ),
        (
            with(4, &[1]),
            "found version 1 of the binary container, expected 2",
        ),
        (
            whole[..whole.len() - 4].to_vec(),
            "the file is cut: its header says",
        ),
        (
            with(12, &[0xFF, 0xFF, 0xFF, 0x7F]),
            "the chunk at offset 12 says 2147483647 bytes",
        ),
        (
            with(16, b"BIN\0"),
            "the first chunk of the file is not JSON",
        ),
        (with(21, b"}"), "malformed JSON"),
    ];
    for (file, expected) in cases {
        let found = Folder::with_bytes("scene.glb", &file).problems();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains(expected), "{found:?}\n{expected}");
    }
}

/// A document with a texture of this image.
fn textured(image: Value) -> Value {
    changed(&[
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture",
            json!({ "index": 0 }),
        ),
        ("/textures", json!([{ "source": 0 }])),
        ("/images", json!([image])),
    ])
}

#[test]
fn images_that_cannot_be_used_are_errors() {
    let cases = [
        (
            json!({ "uri": "wood.png" }),
            "/images/0/uri: the image `wood.png` does not exist",
        ),
        (
            json!({}),
            "/images/0: the image has neither a `uri` nor a `bufferView`",
        ),
        (
            json!({ "bufferView": 9 }),
            "/images/0/bufferView: found 9, expected an index of bufferViews",
        ),
        (
            json!({ "bufferView": 0, "mimeType": "image/png" }),
            "/images/0: embedded image: unknown image format",
        ),
        (
            json!({ "uri": data_uri("image/png", b"\x89PNG\r\n\x1a\n") }),
            "/images/0: embedded image: the image cannot be decoded",
        ),
    ];
    for (image, expected) in cases {
        let found = Folder::new(&textured(image)).problems();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains(expected), "{found:?}\n{expected}");
    }
}

#[test]
fn textures_of_basis_universal_are_one_error_with_a_way_out() {
    let mut document = textured(json!({}));
    let texture = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let material = json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 },
            "metallicRoughnessTexture": { "index": 1 }
        }
    });
    for (path, value) in [
        ("/textures", json!([texture, texture])),
        ("/materials/0", material),
    ] {
        set(&mut document, path, value);
    }
    for required in [json!([]), json!(["KHR_texture_basisu"])] {
        set(&mut document, "/extensionsRequired", required);
        let found = Folder::new(&document).problems();
        assert_eq!(found.len(), 1, "{found:?}");
        for words in [
            "/textures/0",
            "`KHR_texture_basisu`",
            "gltf-transform ktxdecompress",
        ] {
            assert!(found[0].contains(words), "{words}: {found:?}");
        }
    }
    // The image beside them is read.
    let image = image::RgbImage::from_raw(1, 1, vec![255, 255, 255]).unwrap();
    let mut file = std::io::Cursor::new(Vec::new());
    image.write_to(&mut file, image::ImageFormat::Png).unwrap();
    let mut document = textured(json!({ "uri": data_uri("image/png", file.get_ref()) }));
    let extensions = json!({ "KHR_texture_basisu": { "source": 7 } });
    let texture = json!([{ "source": 0, "extensions": extensions }]);
    set(&mut document, "/textures", texture);
    assert!(Folder::new(&document).problems().is_empty());
}

#[test]
fn the_kind_of_an_error_tells_missing_files_from_invalid_ones() {
    let kind = |path: &str, value: Value| {
        let folder = Folder::new(&changed(&[(path, value)]));
        let options = LoadOptions::default();
        load_scene(&folder.file, &options).unwrap_err().kind()
    };
    assert_eq!(
        kind("/buffers/0/uri", json!("a.bin")),
        LoadErrorKind::FileSystem
    );
    assert_eq!(
        kind("/buffers/0/byteLength", json!(0)),
        LoadErrorKind::Scene
    );
}

#[test]
fn options_of_other_formats_are_errors() {
    let folder = Folder::with_bytes("scene.xml", b"<scene version='3.0.0'/>");
    let options = LoadOptions {
        gltf: GltfOptions {
            variant: Some("red".into()),
            ..GltfOptions::default()
        },
        ..LoadOptions::default()
    };
    let error = load_scene(&folder.file, &options).unwrap_err();
    assert_eq!(error.kind(), LoadErrorKind::Option);
    let options = LoadOptions {
        defines: vec![("spp".into(), "3".into())],
        ..LoadOptions::default()
    };
    for scene in ["scene.gltf", "scene.pbrt"] {
        let folder = Folder::with_bytes(scene, b"{}");
        let error = load_scene(&folder.file, &options).unwrap_err();
        assert_eq!(error.kind(), LoadErrorKind::Option, "{scene}");
    }
}
