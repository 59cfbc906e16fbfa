//! The binary buffer of a glTF file.

use crate::mesh::Mesh;
use crate::rounding::rounded;
use glam::DVec3;
use serde_json::{Value, json};

/// Steps in a meter to which positions are rounded, and in 1 to which normals and texture
/// coordinates are, as in the PLY files.
const STEPS: f64 = 1e4;
/// Component types of accessors.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
/// Targets of buffer views: vertices and indices.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Bytes with their views and accessors.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
    /// Primitives without a material, by key.
    known: Vec<(usize, Value)>,
}

impl Buffer {
    /// A primitive of a mesh without a material. The same `key` gives the same accessors.
    pub(super) fn geometry(&mut self, key: usize, mesh: &Mesh) -> Value {
        if let Some((_, primitive)) = self.known.iter().find(|(known, _)| *known == key) {
            return primitive.clone();
        }
        let positions: Vec<[f64; 3]> = mesh.positions.iter().map(DVec3::to_array).collect();
        let mut attributes = json!({ "POSITION": self.floats("VEC3", &positions, true) });
        // Without normals, faces are flat.
        if !mesh.is_flat() {
            let normals: Vec<[f64; 3]> = mesh.normals.iter().map(DVec3::to_array).collect();
            attributes["NORMAL"] = json!(self.floats("VEC3", &normals, false));
        }
        if !mesh.uvs.is_empty() {
            let uvs: Vec<[f64; 2]> = mesh.uvs.iter().map(|uv| uv.to_array()).collect();
            attributes["TEXCOORD_0"] = json!(self.floats("VEC2", &uvs, false));
        }
        let indices = self.indices(mesh);
        let primitive = json!({ "attributes": attributes, "indices": indices });
        self.known.push((key, primitive.clone()));
        primitive
    }

    /// Index of a new accessor of vectors, with its bounds if these are wanted.
    fn floats<const N: usize>(&mut self, kind: &str, values: &[[f64; N]], bounds: bool) -> usize {
        let start = self.bytes.len();
        let (mut low, mut high) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
        for value in values {
            for (c, x) in value.iter().enumerate() {
                let x = rounded(*x, STEPS) as f32;
                self.bytes.extend(x.to_le_bytes());
                low[c] = low[c].min(f64::from(x));
                high[c] = high[c].max(f64::from(x));
            }
        }
        let mut accessor = json!({
            "bufferView": self.view(start, ARRAY_BUFFER),
            "componentType": FLOAT,
            "count": values.len(),
            "type": kind,
        });
        if bounds {
            accessor["min"] = low.to_vec().into();
            accessor["max"] = high.to_vec().into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Index of a new accessor of vertex indices. They have 16 bits if the number of vertices
    /// allows it.
    fn indices(&mut self, mesh: &Mesh) -> usize {
        let start = self.bytes.len();
        // The largest index is reserved.
        let is_short = mesh.positions.len() < 1 << 16;
        for &i in mesh.triangles.iter().flatten() {
            match u16::try_from(i) {
                Ok(short) if is_short => self.bytes.extend(short.to_le_bytes()),
                _ => self.bytes.extend(i.to_le_bytes()),
            }
        }
        let view = self.view(start, ELEMENT_ARRAY_BUFFER);
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT },
            "count": 3 * mesh.triangles.len(),
            "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }

    /// Index of a new view of the bytes from `start`. The next one starts at a multiple of 4.
    fn view(&mut self, start: usize, target: u32) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": start,
            "byteLength": self.bytes.len() - start,
            "target": target,
        }));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{ball, boxed};

    #[test]
    fn views_are_aligned_and_accessors_fit() {
        let mut buffer = Buffer::default();
        let sphere = ball(1.0, 8);
        let first = buffer.geometry(0, &sphere);
        buffer.geometry(1, &boxed([0.0; 3], [1.0; 3]));
        assert_eq!(buffer.geometry(0, &sphere), first);
        // Position, normal and indices of the sphere; the box is flat.
        assert_eq!(buffer.accessors.len(), 5);
        assert_eq!(buffer.accessors[0]["count"], json!(sphere.positions.len()));
        assert_eq!(buffer.accessors[0]["max"], json!([1.0, 1.0, 1.0]));
        for view in &buffer.views {
            assert_eq!(view["byteOffset"].as_u64().unwrap() % 4, 0);
        }
        assert_eq!(buffer.bytes.len() % 4, 0);
    }
}
