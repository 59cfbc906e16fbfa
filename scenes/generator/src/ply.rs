//! Meshes as binary PLY files.

use crate::mesh::Mesh;
use crate::rounding::rounded;
use glam::DVec3;

/// Steps in a meter to which positions are rounded: a tenth of a millimeter.
const POSITION_STEPS: f64 = 1e4;
/// Steps in 1 to which the components of normals are rounded.
const NORMAL_STEPS: f64 = 1e4;
/// Steps in 1 to which texture coordinates are rounded.
const UV_STEPS: f64 = 1e4;

/// The bytes of a little-endian PLY file. Normals are omitted if the mesh is flat-shaded; indices
/// have 16 bits if the number of vertices allows it.
pub fn encode(mesh: &Mesh) -> Vec<u8> {
    let normals: &[DVec3] = if mesh.is_flat() { &[] } else { &mesh.normals };
    let mut names = vec!["x", "y", "z"];
    if !normals.is_empty() {
        names.extend(["nx", "ny", "nz"]);
    }
    if !mesh.uvs.is_empty() {
        names.extend(["u", "v"]);
    }
    let mut bytes = header(mesh, &names).into_bytes();
    for (i, p) in mesh.positions.iter().enumerate() {
        push_all(&mut bytes, &p.to_array(), POSITION_STEPS);
        if let Some(n) = normals.get(i) {
            push_all(&mut bytes, &n.to_array(), NORMAL_STEPS);
        }
        if let Some(uv) = mesh.uvs.get(i) {
            push_all(&mut bytes, &uv.to_array(), UV_STEPS);
        }
    }
    for t in &mesh.triangles {
        bytes.push(3);
        for &i in t {
            match u16::try_from(i) {
                Ok(short) if has_short_indices(mesh) => bytes.extend(short.to_le_bytes()),
                _ => bytes.extend(i.to_le_bytes()),
            }
        }
    }
    bytes
}

fn has_short_indices(mesh: &Mesh) -> bool {
    mesh.positions.len() <= 1 << 16
}

fn push_all(bytes: &mut Vec<u8>, values: &[f64], steps: f64) {
    for &x in values {
        bytes.extend((rounded(x, steps) as f32).to_le_bytes());
    }
}

fn header(mesh: &Mesh, names: &[&str]) -> String {
    let mut text = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        mesh.positions.len()
    );
    for name in names {
        text += &format!("property float {name}\n");
    }
    let index = if has_short_indices(mesh) {
        "ushort"
    } else {
        "uint"
    };
    text += &format!(
        "element face {}\nproperty list uchar {index} vertex_indices\nend_header\n",
        mesh.triangles.len()
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{ball, boxed};

    #[test]
    fn length_follows_from_the_header() {
        let sphere = ball(1.0, 8);
        let bytes = encode(&sphere);
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let expected = 24 * sphere.positions.len() + 7 * sphere.triangles.len();
        assert_eq!(bytes.len() - body, expected);
    }

    #[test]
    fn flat_meshes_have_no_normals() {
        let text = String::from_utf8_lossy(&encode(&boxed([0.0; 3], [1.0; 3]))).into_owned();
        assert!(text.contains("element vertex 24"));
        assert!(!text.contains("nx"));
    }
}
