//! Loading of glTF files. The files are written by the tests: a document that is changed at some
//! places.

mod animations;
mod compression;
mod errors;
mod extensions;
mod features;
mod geometry;
mod invalid;
mod layers;
mod materials;
mod opacity;
mod shared;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use manylight::geometry::{Mesh, Shape};
use manylight::scene::SceneDesc;
use manylight_io::{GltfOptions, LoadOptions, Severity, check_scene, load_scene};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A folder with `scene.gltf`, or `scene.glb`.
struct Folder {
    folder: tempfile::TempDir,
    file: PathBuf,
}

impl Folder {
    fn with_bytes(name: &str, bytes: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        Folder { folder, file }
    }

    fn new(document: &Value) -> Self {
        let text = serde_json::to_string_pretty(document).unwrap();
        Self::with_bytes("scene.gltf", text.as_bytes())
    }

    /// All problems, as `severity message`, without the name of the folder.
    fn problems_with(&self, gltf: GltfOptions) -> Vec<String> {
        let options = LoadOptions {
            gltf,
            ..LoadOptions::default()
        };
        let folder = self.folder.path().display().to_string();
        let found = check_scene(&self.file, &options);
        let describe = |d: &manylight_io::Diagnostic| {
            let severity = match d.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            };
            let help = d.help.as_deref().unwrap_or_default();
            format!("{severity} {} {help}", d.message).replace(&folder, "FOLDER")
        };
        found.iter().map(describe).collect()
    }

    fn problems(&self) -> Vec<String> {
        self.problems_with(GltfOptions::default())
    }
}

fn bytes_of(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A buffer with `bytes`.
fn buffer(bytes: &[u8]) -> Value {
    json!({ "byteLength": bytes.len(), "uri": data_uri("application/octet-stream", bytes) })
}

/// A triangle in the plane z = 0 with normals and texture coordinates, and a point light.
///
/// Accessors: 0 positions, 1 normals, 2 texture coordinates, 3 indices of 16 bits.
fn triangle() -> Value {
    let mut bytes = bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend(bytes_of(&[0.0, 0.0, 1.0].repeat(3)));
    bytes.extend(bytes_of(&[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]));
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "mesh": 0 },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } } }
        ],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } },
        "meshes": [{
            "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 },
                "indices": 3,
                "material": 0
            }]
        }],
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0 } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 6 }
        ],
        "buffers": [buffer(&bytes)]
    })
}

/// Sets the value at `path`; its parents are made if they do not exist.
fn set(document: &mut Value, path: &str, value: Value) {
    let mut at = document;
    for name in path.split('/').skip(1) {
        at = match at {
            Value::Array(items) => {
                let index: usize = name.parse().unwrap();
                items.resize(items.len().max(index + 1), Value::Null);
                &mut items[index]
            }
            other => {
                if !other.is_object() {
                    *other = json!({});
                }
                &mut other[name]
            }
        };
    }
    *at = value;
}

/// The triangle with these changes.
fn changed(changes: &[(&str, Value)]) -> Value {
    let mut document = triangle();
    for (path, value) in changes {
        set(&mut document, path, value.clone());
    }
    document
}

/// Adds an accessor with its own buffer, and returns its index.
fn add_accessor(
    document: &mut Value,
    bytes: &[u8],
    component: u32,
    count: usize,
    kind: &str,
) -> usize {
    let push = |document: &mut Value, name: &str, value: Value| {
        let list = document[name].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    };
    let buffer_index = push(document, "buffers", buffer(bytes));
    let view = json!({ "buffer": buffer_index, "byteLength": bytes.len() });
    let view = push(document, "bufferViews", view);
    let accessor =
        json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
    push(document, "accessors", accessor)
}

/// The description of a document that loads without a warning.
fn load(document: &Value) -> SceneDesc {
    load_with(document, GltfOptions::default())
}

fn load_with(document: &Value, gltf: GltfOptions) -> SceneDesc {
    load_by(
        document,
        &LoadOptions {
            gltf,
            ..LoadOptions::default()
        },
    )
}

fn load_by(document: &Value, options: &LoadOptions) -> SceneDesc {
    let folder = Folder::new(document);
    let loaded = load_scene(&folder.file, options).unwrap_or_else(|error| panic!("{error}"));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    manylight::scene::Scene::build(loaded.desc.clone(), 0).unwrap();
    loaded.desc
}

/// The mesh of a primitive.
fn mesh(desc: &SceneDesc, primitive: usize) -> &Mesh {
    let shape = desc.primitives[primitive].shape;
    match &desc.shapes[shape.index()] {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

/// A binary file.
fn binary(json: &[u8], data: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], fill: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        bytes
    };
    let (json, data) = (padded(json, b' '), padded(data, 0));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// The triangle as a binary file.
fn binary_triangle() -> Vec<u8> {
    let mut document = triangle();
    let uri = document["buffers"][0]["uri"].take();
    let data = STANDARD
        .decode(uri.as_str().unwrap().split_once(',').unwrap().1)
        .unwrap();
    document["buffers"][0]
        .as_object_mut()
        .unwrap()
        .remove("uri");
    binary(document.to_string().as_bytes(), &data)
}
