//! Accessors, topologies, deformation, transforms.

use super::*;
use manylight::math::{Vec2, Vec3};

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn text_and_binary_files_have_the_same_mesh() {
    let desc = load(&triangle());
    assert_eq!(mesh(&desc, 0).positions, CORNERS);
    assert_eq!(mesh(&desc, 0).triangles, [[0, 1, 2]]);
    let folder = Folder::with_bytes("scene.glb", &binary_triangle());
    let other = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    assert_eq!(mesh(&other, 0), mesh(&desc, 0));
}

#[test]
fn strided_views_and_byte_offsets() {
    // Position and texture coordinates of each vertex, interleaved after four bytes.
    let mut bytes = vec![9; 4];
    for corner in CORNERS {
        bytes.extend(bytes_of(&corner.to_array()));
        bytes.extend(bytes_of(&[corner.x, 1.0 - corner.y]));
    }
    let mut document = triangle();
    let position = add_accessor(&mut document, &bytes, 5126, 3, "VEC3");
    set(&mut document, "/bufferViews/4/byteStride", json!(20));
    set(&mut document, "/accessors/4/byteOffset", json!(4));
    let uv = json!({ "bufferView": 4, "byteOffset": 16, "componentType": 5126, "count": 3, "type": "VEC2" });
    set(&mut document, "/accessors/5", uv);
    let attributes = json!({ "POSITION": position, "TEXCOORD_0": 5 });
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes",
        attributes,
    );
    textured(&mut document);
    let desc = load(&document);
    assert_eq!(mesh(&desc, 0).positions, CORNERS);
    assert_eq!(mesh(&desc, 0).uvs, [Vec2::Y, Vec2::ONE, Vec2::ZERO]);
    // Without normals, triangles are flat.
    assert!(mesh(&desc, 0).normals.is_empty());
}

/// Makes the material use texture coordinates.
fn textured(document: &mut Value) {
    let texture = json!({ "index": 0 });
    set(
        document,
        "/materials/0/pbrMetallicRoughness/baseColorTexture",
        texture,
    );
    set(document, "/textures", json!([{ "source": 0 }]));
    set(
        document,
        "/images",
        json!([{ "uri": super::materials::png(&[[255, 0, 0, 255]], 1) }]),
    );
}

#[test]
fn quantized_and_normalized_attributes() {
    let mut document = triangle();
    let positions = add_accessor(
        &mut document,
        &[0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0],
        5120,
        3,
        "VEC3",
    );
    set(&mut document, "/accessors/4/normalized", json!(true));
    set(&mut document, "/bufferViews/4/byteStride", json!(4));
    let uvs: Vec<u8> = [0u16, 65535, 65535, 65535, 0, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let uv = add_accessor(&mut document, &uvs, 5123, 3, "VEC2");
    set(&mut document, "/accessors/5/normalized", json!(true));
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uv });
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes",
        attributes,
    );
    textured(&mut document);
    set(
        &mut document,
        "/extensionsUsed",
        json!(["KHR_lights_punctual", "KHR_mesh_quantization"]),
    );
    set(
        &mut document,
        "/extensionsRequired",
        json!(["KHR_mesh_quantization"]),
    );
    let desc = load(&document);
    assert_eq!(mesh(&desc, 0).positions, CORNERS);
    assert_eq!(mesh(&desc, 0).uvs, [Vec2::Y, Vec2::ONE, Vec2::ZERO]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut document = triangle();
    add_accessor(&mut document, &[2, 0], 5121, 2, "SCALAR");
    let values = bytes_of(&[0.0, 3.0, 0.0, 5.0, 5.0, 5.0]);
    add_accessor(&mut document, &values, 5126, 2, "VEC3");
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 4, "componentType": 5121 },
        "values": { "bufferView": 5 }
    });
    set(&mut document, "/accessors/0/sparse", sparse);
    let desc = load(&document);
    assert_eq!(
        mesh(&desc, 0).positions,
        [CORNERS[0], CORNERS[1], 3.0 * Vec3::Y]
    );
}

#[test]
fn strips_fans_and_lists_without_indices() {
    let mut document = triangle();
    let square = bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    let square = add_accessor(&mut document, &square, 5126, 4, "VEC3");
    let primitive = |mode: u32| json!({ "attributes": { "POSITION": square }, "mode": mode });
    let triangles = |mode: u32| {
        let mut document = document.clone();
        set(&mut document, "/meshes/0/primitives/0", primitive(mode));
        mesh(&load(&document), 0).triangles.clone()
    };
    assert_eq!(triangles(5), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(6), [[1, 2, 0], [2, 3, 0]]);
    set(&mut document, "/meshes/0/primitives/0", primitive(1));
    let found = Folder::new(&document).problems();
    assert!(
        found[0].contains("warning /meshes/0/primitives/0: points and lines are ignored"),
        "{found:?}"
    );
}

#[test]
fn mirroring_nodes_keep_their_front() {
    let desc = load(&changed(&[("/nodes/0/scale", json!([-2, 1, 1]))]));
    let mesh = mesh(&desc, 0);
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    let transform = desc.primitives[0].world_from_object;
    let [a, b, c] =
        mesh.triangles[0].map(|i| transform.transform_point3(mesh.positions[i as usize]));
    assert!((b - a).cross(c - a).z > 0.0);
    assert_eq!(a + b + c, Vec3::new(-2.0, 1.0, 0.0));
}

#[test]
fn parents_and_matrices_place_their_children() {
    let desc = load(&changed(&[
        ("/scenes/0/nodes", json!([2, 1])),
        (
            "/nodes/2",
            json!({ "children": [0], "rotation": [0, 0, 1, 1], "translation": [1, 2, 3] }),
        ),
        (
            "/nodes/0/matrix",
            json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1]),
        ),
    ]));
    let placed = desc.primitives[0]
        .world_from_object
        .transform_point3(Vec3::X);
    assert!(
        placed.abs_diff_eq(Vec3::new(1.0, 9.0, 3.0), 1e-5),
        "{placed}"
    );
}

#[test]
fn morph_targets_and_skins_deform() {
    let mut document = triangle();
    let target = add_accessor(
        &mut document,
        &bytes_of(&[0.0, 0.0, 4.0].repeat(3)),
        5126,
        3,
        "VEC3",
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/targets",
        json!([{ "POSITION": target }]),
    );
    set(&mut document, "/meshes/0/weights", json!([0.25]));
    assert_eq!(
        mesh(&load(&document), 0).positions[1],
        Vec3::new(1.0, 0.0, 1.0)
    );

    let mut document = triangle();
    let joints = add_accessor(&mut document, &[0, 1, 0, 0].repeat(3), 5121, 3, "VEC4");
    let weights = add_accessor(
        &mut document,
        &bytes_of(&[0.5, 0.5, 0.0, 0.0].repeat(3)),
        5126,
        3,
        "VEC4",
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/JOINTS_0",
        json!(joints),
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/WEIGHTS_0",
        json!(weights),
    );
    set(&mut document, "/skins", json!([{ "joints": [2, 3] }]));
    set(&mut document, "/scenes/0/nodes", json!([0, 1, 2]));
    set(
        &mut document,
        "/nodes/2",
        json!({ "translation": [0, 0, 2], "children": [3] }),
    );
    set(
        &mut document,
        "/nodes/3",
        json!({ "translation": [0, 0, 2] }),
    );
    // The transform of a skinned mesh has no effect.
    set(&mut document, "/nodes/0/translation", json!([9, 9, 9]));
    set(&mut document, "/nodes/0/skin", json!(0));
    let desc = load(&document);
    assert_eq!(mesh(&desc, 0).positions, CORNERS.map(|c| c + 3.0 * Vec3::Z));
    assert_eq!(
        desc.primitives[0].world_from_object,
        manylight::math::Affine3A::IDENTITY
    );
}

#[test]
fn instances_of_small_and_large_meshes() {
    let mut document = triangle();
    let places = bytes_of(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0]);
    let places = add_accessor(&mut document, &places, 5126, 3, "VEC3");
    let extension = json!({ "attributes": { "TRANSLATION": places } });
    set(
        &mut document,
        "/nodes/0/extensions/EXT_mesh_gpu_instancing",
        extension,
    );
    let desc = load(&document);
    let heights: Vec<f32> = desc
        .primitives
        .iter()
        .map(|p| p.world_from_object.translation.z)
        .collect();
    assert_eq!((heights, desc.shapes.len()), (vec![1.0, 2.0, 3.0], 1));

    // The same triangle again and again: built into no tree here.
    let count = 7_000;
    let indices = add_accessor(
        &mut document,
        &[0, 1, 2].repeat(count),
        5121,
        3 * count,
        "SCALAR",
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/indices",
        json!(indices),
    );
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    let found = (
        desc.primitives.len(),
        desc.groups.len(),
        desc.instances.len(),
    );
    assert_eq!(found, (0, 1, 3));
}

#[test]
fn primitives_keep_the_vertices_that_they_use() {
    // Four triangles in one array of vertices, each a primitive.
    let mut document = triangle();
    let positions: Vec<f32> = (0..36).map(|i| (i * i % 17) as f32).collect();
    let mut bytes = bytes_of(&positions);
    bytes.extend((0..12u16).flat_map(u16::to_le_bytes));
    set(&mut document, "/buffers/0", buffer(&bytes));
    let views = json!([
        { "buffer": 0, "byteLength": 144 }, { "buffer": 0, "byteOffset": 144, "byteLength": 24 }
    ]);
    set(&mut document, "/bufferViews", views);
    let indices = |i: usize| json!({ "bufferView": 1, "byteOffset": 6 * i, "componentType": 5123, "count": 3, "type": "SCALAR" });
    let all = json!({ "bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3" });
    set(
        &mut document,
        "/accessors",
        json!([all, indices(0), indices(1), indices(2), indices(3)]),
    );
    let primitive = |i: usize| json!({ "attributes": { "POSITION": 0 }, "indices": i + 1 });
    let primitives: Vec<Value> = (0..4).map(primitive).collect();
    set(&mut document, "/meshes/0/primitives", json!(primitives));
    let desc = load(&document);
    assert_eq!(desc.shapes.len(), 4);
    for (i, shape) in desc.shapes.iter().enumerate() {
        let Shape::Mesh(mesh) = shape else {
            panic!("{shape:?}");
        };
        let expected: Vec<Vec3> = positions[9 * i..9 * i + 9]
            .chunks(3)
            .map(Vec3::from_slice)
            .collect();
        assert_eq!(mesh.positions, expected);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn primitives_that_repeat_data_are_bounded() {
    let mut document = triangle();
    let positions = vec![0.0; 3 * 65_535];
    set(&mut document, "/buffers/0", buffer(&bytes_of(&positions)));
    let views = json!([{ "buffer": 0, "byteLength": 4 * positions.len() }]);
    set(&mut document, "/bufferViews", views);
    let accessors =
        json!([{ "bufferView": 0, "componentType": 5126, "count": 65_535, "type": "VEC3" }]);
    set(&mut document, "/accessors", accessors);
    let primitive = json!({ "attributes": { "POSITION": 0 } });
    set(
        &mut document,
        "/meshes/0/primitives",
        json!(vec![primitive; 200]),
    );
    let found = Folder::new(&document).problems();
    assert!(
        found.len() == 1
            && found[0].contains(
                "the primitives make more than 78642000 bytes of geometry from 786420 bytes"
            ),
        "{found:?}"
    );
}

#[test]
fn tangents_follow_texture_coordinates_that_no_texture_needs() {
    let material = json!({
        "pbrMetallicRoughness": { "roughnessFactor": 0.3 },
        "extensions": { "KHR_materials_anisotropy": { "anisotropyStrength": 0.8 } }
    });
    let desc = load(&changed(&[("/materials/0", material)]));
    let mesh = mesh(&desc, 0);
    assert_eq!((mesh.tangents.len(), mesh.uvs.len()), (3, 3));
    assert!(mesh.tangents.iter().all(|t| t.abs_diff_eq(Vec3::X, 1e-5)));
}
