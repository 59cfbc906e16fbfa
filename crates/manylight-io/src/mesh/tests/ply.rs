//! Tests of the PLY parser.

use super::super::{Mesh, MeshFormat, parse};
use super::{TRIANGLE, assert_near, message};
use manylight::math::Vec2;

/// A square, a triangle and an element to skip.
pub(super) const TRIANGLE_PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty uchar red\nproperty float s\nproperty float t\nelement edge 1\nproperty int vertex1\n\
    element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 255 0 0.25\n1 0 0 255 1 0\n1 1 0.5 255 1 1\n0 1 0 255 0 1\n7\n3 4 0 1 2 3\n3 3 0 1 2\n";

fn parse_ply(bytes: &[u8]) -> Result<Mesh, String> {
    message(parse(bytes, MeshFormat::Ply, true).map(|(mesh, _)| mesh))
}

#[test]
fn unknown_properties_and_elements_are_skipped() {
    let mesh = parse_ply(TRIANGLE_PLY.as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_near(
        &mesh.positions,
        &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5], [0., 1., 0.]],
    );
    assert_eq!(
        mesh.uvs,
        [
            Vec2::new(0.0, 0.25),
            Vec2::new(1.0, 0.0),
            Vec2::new(1.0, 1.0),
            Vec2::new(0.0, 1.0)
        ]
    );
    assert!(mesh.normals.is_empty());
}

fn binary_ply(
    format: &str,
    bytes_of: impl Fn(f32) -> [u8; 4],
    word: impl Fn(u32) -> [u8; 4],
    double: impl Fn(f64) -> [u8; 8],
) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\nelement face 1\nproperty list uint uint vertex_index\nelement vertex 3\nproperty float x\n\
         property float y\nproperty double z\nproperty list uchar char junk\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    for i in [3, 2, 1, 0] {
        bytes.extend(word(i));
    }
    for v in TRIANGLE.chunks_exact(3) {
        bytes.extend([bytes_of(v[0]), bytes_of(v[1])].concat());
        bytes.extend(double(f64::from(v[2])));
        bytes.extend([2, 0xFF, 10]);
        bytes.extend([0.0, 4.0, 0.0].map(&bytes_of).concat());
    }
    bytes
}

pub(super) fn binary_little_endian() -> Vec<u8> {
    binary_ply(
        "binary_little_endian",
        f32::to_le_bytes,
        u32::to_le_bytes,
        f64::to_le_bytes,
    )
}

#[test]
fn binary_ply_of_both_byte_orders() {
    let little = binary_little_endian();
    let big = binary_ply(
        "binary_big_endian",
        f32::to_be_bytes,
        u32::to_be_bytes,
        f64::to_be_bytes,
    );
    let mesh = parse_ply(&little).unwrap();
    assert_eq!(mesh, parse_ply(&big).unwrap());
    assert_eq!(mesh.triangles, [[2, 1, 0]]);
    assert_near(
        &mesh.positions,
        &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5]],
    );
    assert_near(&mesh.normals, &[[0., 1., 0.]; 3]);
    for cut in [little.len() - 1, little.len() - 30] {
        let text = parse_ply(&little[..cut]).unwrap_err();
        assert!(
            text.starts_with(&format!("f: the file ends at byte {cut}")),
            "{text}"
        );
    }
}

#[test]
fn damage_in_ply_is_reported() {
    let ascii = |from: &str, to: &str| {
        parse_ply(TRIANGLE_PLY.replacen(from, to, 1).as_bytes()).unwrap_err()
    };
    assert_eq!(
        parse_ply(b"solid x").unwrap_err(),
        "f:1:1: expected a PLY file, which starts with the line 'ply', found 'solid'"
    );
    assert_eq!(
        ascii("ascii", "text"),
        "f:2:1: unknown format 'text'; expected ascii, binary_little_endian or binary_big_endian"
    );
    assert_eq!(
        ascii("vertex 4", "vertex -4"),
        "f:4:1: expected a number of items, found '-4'"
    );
    assert_eq!(
        ascii("float x", "half x"),
        "f:5:1: unknown property type 'half'; expected char, uchar, short, ushort, int, uint, float or double"
    );
    assert_eq!(
        ascii("float x", "float w"),
        "f: expected the properties x, y and z of the element 'vertex'"
    );
    assert_eq!(
        ascii("vertex_indices", "corners"),
        "f: expected a list 'vertex_indices' of the element 'face'"
    );
    assert_eq!(
        ascii("1 1 0.5", "1 1 oops"),
        "f:19:5: expected a number, found 'oops'"
    );
    assert_eq!(
        ascii("1 1 0.5", "1 1 nan"),
        "f:19:16: the position of vertex 2 is not finite"
    );
    assert_eq!(
        ascii("3 3 0 1 2", "3 3 0 1 4"),
        "f: a face refers to the vertices [0, 1, 4], but the file has 4, counted from 0"
    );
    assert_eq!(
        ascii("3 3 0 1 2", "3 -3 0 1 2"),
        "f:23:5: found -3 as the length of a list; expected a whole number that fits into the file"
    );
    assert_eq!(
        ascii("3 3 0 1 2", "3 3 0 1"),
        "f:24:1: expected a number, found the end of the file"
    );
    assert_eq!(
        ascii("vertex 4", "vertex 4000000000000"),
        "f:24:1: expected a number, found the end of the file"
    );
    assert_eq!(
        ascii("end_header", "end"),
        "f:16:1: expected a line of a PLY header (format, comment, element, property, end_header), found 'end'"
    );
}

#[test]
fn repeated_elements_and_damaged_keywords_are_errors() {
    let header = |lines: &str| format!("ply\nformat ascii 1.0\n{lines}\nend_header\n");
    let twice = header("element vertex 1\nproperty float x\nelement vertex 2");
    assert_eq!(
        parse_ply(twice.as_bytes()).unwrap_err(),
        "f:5:1: the element 'vertex' is declared twice"
    );
    let damaged =
        [&b"ply\nformat ascii 1.0\nelement vert\xFFx 1\nelem\xFFent face 1\n"[..]].concat();
    assert!(
        parse_ply(&damaged)
            .unwrap_err()
            .starts_with("f:4:1: expected a line of a PLY header")
    );
}
