//! Invalid changes of the triangle.

use super::changed;
use serde_json::{Value, json};

/// The triangle with a camera of this aspect ratio.
fn seen(aspect: f64) -> Value {
    let lens = json!({ "yfov": 1, "aspectRatio": aspect });
    let cameras = json!([{ "type": "perspective", "perspective": lens }]);
    changed(&[("/cameras", cameras), ("/nodes/0/camera", json!(0))])
}

/// A change of the triangle, and the only error that it causes. The empty path is the whole file.
pub(super) fn invalid() -> Vec<(&'static str, Value, &'static str)> {
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
            "/extensionsRequired/0: the file requires the extension `KHR_materials_iorr`, which is not supported supported extensions: EXT_mesh_gpu_instancing",
        ),
        (
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression",
            json!({}),
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: the property `bufferView` is missing",
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
            "/nodes/0/translation/0: found `1e+300`, expected a number",
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
            "",
            seen(0.0),
            "/cameras/0/perspective/aspectRatio: found 0, expected more than 0",
        ),
        (
            "",
            seen(-1.5),
            "/cameras/0/perspective/aspectRatio: found -1.5, expected more than 0",
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
            json!(8_000_000_000_000_000_u64),
            "/accessors/0: 3 elements of 12 bytes at offset 8000000000000000 do not fit",
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
            json!({ "count": 1, "indices": { "bufferView": 1, "byteOffset": 8, "componentType": 5125 }, "values": { "bufferView": 1 } }),
            "/accessors/0/sparse: index 0 is 1065353216, expected less than 3",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(4),
            "/accessors/0: elements of 12 bytes do not fit the stride of 4 bytes of the buffer view",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(0),
            "/bufferViews/0/byteStride: found 0, expected a number from 1 to 256",
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
