//! Invalid files: one message with the JSON path, and no panic.

use super::*;
use manylight_io::LoadErrorKind;
use std::time::{Duration, Instant};

/// A change of the triangle, and the only error that it causes.
fn invalid() -> Vec<(&'static str, Value, &'static str)> {
    vec![
        (
            "/asset",
            json!(null),
            "/asset: found `null`, expected an object",
        ),
        (
            "/asset/version",
            json!("1.0"),
            "/asset/version: found glTF 1.0, expected 2.0; export the scene again as glTF 2.0",
        ),
        (
            "/asset/minVersion",
            json!("2.1"),
            "/asset/minVersion: found glTF 2.1, expected 2.0",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_materials_iorr"]),
            "/extensionsRequired/0: the file requires the extension `KHR_materials_iorr`, which is not supported did you mean `KHR_materials_ior`?",
        ),
        (
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression",
            json!({}),
            "/meshes/0/primitives/0: geometry compressed by the extension `KHR_draco_mesh_compression` is not supported",
        ),
        (
            "/bufferViews/0/extensions/EXT_meshopt_compression",
            json!({}),
            "/bufferViews/0: geometry compressed by the extension `EXT_meshopt_compression` is not supported",
        ),
        (
            "/scene",
            json!(3),
            "/scene: found 3, expected an index of scenes from 0 to 0",
        ),
        (
            "/scenes/0/nodes",
            json!([0, 7]),
            "/scenes/0/nodes/1: found 7, expected an index of nodes from 0 to 1",
        ),
        (
            "/scenes/0/nodes",
            json!(0),
            "/scenes/0/nodes: found `0`, expected an array",
        ),
        (
            "/nodes/0/children",
            json!([0]),
            "/nodes/0/children/0: node 0 is reached twice",
        ),
        (
            "/nodes/0/mesh",
            json!(-1),
            "/nodes/0/mesh: found `-1`, expected an integer of at least 0",
        ),
        (
            "/nodes/0/mesh",
            json!(1),
            "/nodes/0/mesh: found 1, expected an index of meshes from 0 to 0",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0]),
            "/nodes/0/matrix: found 2 numbers, expected 16",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]),
            "/nodes/0/matrix: found the last row [0.0, 0.0, 0.0, 2.0], expected 0, 0, 0, 1",
        ),
        (
            "/nodes/0/rotation",
            json!([0, 0, 0, 0]),
            "/nodes/0/rotation: the quaternion is zero",
        ),
        (
            "/nodes/0/scale",
            json!([1, "a", 1]),
            "/nodes/0/scale/1: found `\"a\"`, expected a number",
        ),
        (
            "/nodes/0/translation",
            json!([1e300, 0, 0]),
            "/nodes/0/translation/0: found `1e300`, expected a number",
        ),
        (
            "/nodes/0/skin",
            json!(0),
            "/nodes/0/skin: found 0, but the file has no skins",
        ),
        (
            "/nodes/0/camera",
            json!(0),
            "/nodes/0/camera: found 0, but the file has no cameras",
        ),
        (
            "/meshes/0/primitives/0/mode",
            json!(9),
            "/meshes/0/primitives/0/mode: found 9, expected a number from 0 to 6",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!(null),
            "/meshes/0/primitives/0/attributes: found `null`, expected an object",
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(9),
            "/meshes/0/primitives/0/attributes/NORMAL: found 9, expected an index of accessors from 0 to 3",
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(2),
            "/accessors/2/type: found `VEC2`, expected VEC3 for /meshes/0/primitives/0/attributes/NORMAL",
        ),
        (
            "/meshes/0/primitives/0/indices",
            json!(0),
            "/accessors/0/type: found `VEC3`, expected SCALAR for /meshes/0/primitives/0/indices",
        ),
        (
            "/meshes/0/primitives/0/material",
            json!(4),
            "/meshes/0/primitives/0/material: found 4, expected an index of materials from 0 to 0",
        ),
        (
            "/accessors/0/componentType",
            json!(5121),
            "/accessors/0/componentType: found UNSIGNED_BYTE, expected FLOAT for",
        ),
        (
            "/accessors/0/componentType",
            json!(5),
            "/accessors/0/componentType: found 5, expected the number of FLOAT for",
        ),
        (
            "/accessors/3/componentType",
            json!(5126),
            "/accessors/3/componentType: found FLOAT, expected UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT for",
        ),
        (
            "/accessors/0/count",
            json!(0),
            "/accessors/0/count: found 0, expected at least 1",
        ),
        (
            "/accessors/0/count",
            json!(4),
            "/accessors/0: 4 elements of 12 bytes at offset 0 do not fit the 36 bytes of the buffer view",
        ),
        (
            "/accessors/0/count",
            json!(4_000_000_000_u64),
            "/accessors/0: 4000000000 elements of 12 bytes",
        ),
        (
            "/accessors/1/count",
            json!(2),
            "/meshes/0/primitives/0/attributes/NORMAL: the accessor has 2 elements, but POSITION has 3",
        ),
        (
            "/accessors/0/byteOffset",
            json!(9_007_199_254_740_000_u64),
            "/accessors/0: 3 elements of 12 bytes at offset 9007199254740000 do not fit",
        ),
        (
            "/accessors/0/bufferView",
            json!(8),
            "/accessors/0/bufferView: found 8, expected an index of bufferViews from 0 to 3",
        ),
        (
            "/accessors/0",
            json!({ "componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3" }),
            "/accessors/0/count: found 4000000000 elements without a `bufferView`, more than the buffers of the file have bytes",
        ),
        (
            "/accessors/0/sparse",
            json!({ "count": 1, "indices": { "bufferView": 2, "componentType": 5125 }, "values": { "bufferView": 1 } }),
            "/accessors/0/sparse: index 0 is 0, expected less than",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(4),
            "/accessors/0: elements of 12 bytes do not fit the stride of 4 bytes of the buffer view",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(0),
            "/bufferViews/0/byteStride: found 0, expected a number from 4 to 252",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(999),
            "/bufferViews/0: the view needs 999 bytes at offset 0, but buffer 0 has 104",
        ),
        (
            "/bufferViews/0/buffer",
            json!(2),
            "/bufferViews/0/buffer: found 2, expected an index of buffers from 0 to 0",
        ),
        (
            "/buffers/0/byteLength",
            json!(0),
            "/buffers/0/byteLength: found 0, expected at least 1",
        ),
        (
            "/buffers/0/byteLength",
            json!(999),
            "/buffers/0: `byteLength` is 999, but the data has 104 bytes",
        ),
        (
            "/buffers/0/uri",
            json!("data:;base64,=*="),
            "/buffers/0/uri: the base64 data cannot be decoded",
        ),
        (
            "/buffers/0/uri",
            json!("https://example.com/a.bin"),
            "/buffers/0/uri: found a `https:` address, expected a file name relative to the scene",
        ),
        (
            "/buffers/0/uri",
            json!("seen.bin"),
            "/buffers/0/uri: the buffer `seen.bin` does not exist looked for `FOLDER/seen.bin`",
        ),
        (
            "/buffers/0",
            json!({ "byteLength": 104 }),
            "/buffers/0: the buffer has neither a `uri` nor the data chunk of a binary file",
        ),
        (
            "/materials/0/alphaMode",
            json!("BLENT"),
            "/materials/0/alphaMode: found `BLENT`, expected `OPAQUE`, `MASK` or `BLEND`",
        ),
        (
            "/materials/0/emissiveFactor",
            json!([1, -1, 0]),
            "/materials/0/emissiveFactor: found -1, expected at least 0",
        ),
        (
            "/materials/0/pbrMetallicRoughness/roughnessFactor",
            json!(1.5),
            "/materials/0/pbrMetallicRoughness/roughnessFactor: found 1.5, expected a number from 0 to 1",
        ),
        (
            "/materials/0/normalTexture",
            json!({ "index": 0 }),
            "/materials/0/normalTexture/index: found 0, but the file has no textures",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0/type",
            json!("area"),
            "/extensions/KHR_lights_punctual/lights/0/type: found `area`, expected `directional`, `point` or `spot`",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0/intensity",
            json!(-2),
            "/extensions/KHR_lights_punctual/lights/0/intensity: found -2, expected at least 0",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0",
            json!({ "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.4 } }),
            "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle: found 0.5, expected an angle from 0 to 0.4",
        ),
        (
            "/nodes/1/extensions/KHR_lights_punctual/light",
            json!(1),
            "/nodes/1/extensions/KHR_lights_punctual/light: found 1, expected an index of lights from 0 to 0",
        ),
    ]
}

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

#[test]
fn images_that_cannot_be_used_are_errors() {
    let textured = |image: Value| {
        changed(&[
            (
                "/materials/0/pbrMetallicRoughness/baseColorTexture",
                json!({ "index": 0 }),
            ),
            ("/textures", json!([{ "source": 0 }])),
            ("/images", json!([image])),
        ])
    };
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
    let mut document = textured(json!({}));
    set(
        &mut document,
        "/textures",
        json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]),
    );
    let found = Folder::new(&document).problems();
    assert!(
        found[0].contains("Basis Universal image alone (extension `KHR_texture_basisu`)"),
        "{found:?}"
    );
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
}
