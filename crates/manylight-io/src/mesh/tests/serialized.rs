//! Tests of the parser of serialized meshes.

use super::super::{Mesh, MeshFormat, parse};
use super::{TRIANGLE, assert_near, message};
use manylight::math::Vec2;
use std::io::Write;

fn parse_serialized(bytes: &[u8], shape_index: usize) -> Result<Mesh, String> {
    message(parse(bytes, MeshFormat::Serialized { shape_index }, true).map(|(mesh, _)| mesh))
}

/// One stream of a serialized file.
fn stream(version: u16, flags: u32, floats: &[f32], triangles: &[u32]) -> Vec<u8> {
    let mut content = flags.to_le_bytes().to_vec();
    if version == 4 {
        content.extend(b"name\0");
    }
    content.extend(3_u64.to_le_bytes());
    content.extend((triangles.len() as u64 / 3).to_le_bytes());
    for &v in floats {
        if flags & 0x2000 != 0 {
            content.extend(f64::from(v).to_le_bytes())
        } else {
            content.extend(v.to_le_bytes())
        }
    }
    content.extend(triangles.iter().flat_map(|i| i.to_le_bytes()));
    let mut bytes = [0x041C_u16.to_le_bytes(), version.to_le_bytes()].concat();
    let mut encoder = flate2::write::ZlibEncoder::new(&mut bytes, flate2::Compression::default());
    encoder.write_all(&content).unwrap();
    encoder.finish().unwrap();
    bytes
}

fn serialized_file(version: u16, streams: &[Vec<u8>]) -> Vec<u8> {
    let mut offset = 0_u64;
    let mut table = Vec::new();
    for stream in streams {
        if version == 4 {
            table.extend(offset.to_le_bytes())
        } else {
            table.extend((offset as u32).to_le_bytes())
        }
        offset += stream.len() as u64;
    }
    [
        streams.concat(),
        table,
        (streams.len() as u32).to_le_bytes().to_vec(),
    ]
    .concat()
}

/// Two meshes: one in double precision with positions only, one in single precision with normals
/// and uv coordinates.
pub(super) fn two_shapes(version: u16) -> Vec<u8> {
    let normals_and_uvs = [
        0.0, 0.0, 2.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 1.0, 0.0, 1.0, 1.0,
    ];
    let rich = [&TRIANGLE[..], &normals_and_uvs].concat();
    serialized_file(
        version,
        &[
            stream(version, 0x2000, &TRIANGLE, &[0, 1, 2]),
            stream(version, 0x1003, &rich, &[0, 1, 2, 2, 1, 0]),
        ],
    )
}

#[test]
fn serialized_shapes_of_both_versions_and_precisions() {
    for version in [3, 4] {
        let file = two_shapes(version);
        let plain = parse_serialized(&file, 0).unwrap();
        assert_eq!(plain.triangles, [[0, 1, 2]]);
        assert_near(
            &plain.positions,
            &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5]],
        );
        assert!(plain.normals.is_empty() && plain.uvs.is_empty());
        let rich = parse_serialized(&file, 1).unwrap();
        assert_eq!(rich.triangles, [[0, 1, 2], [2, 1, 0]]);
        assert_near(&rich.normals, &[[0., 0., 1.], [0., 1., 0.], [1., 0., 0.]]);
        assert_eq!(
            rich.uvs,
            [
                Vec2::new(0.0, 0.25),
                Vec2::new(1.0, 0.0),
                Vec2::new(1.0, 1.0)
            ]
        );
    }
}

#[test]
fn damage_in_serialized_files_is_reported() {
    let file = two_shapes(4);
    assert_eq!(
        parse_serialized(&file, 2).unwrap_err(),
        "f: there is no shape 2: the file has 2, counted from 0"
    );
    assert_eq!(
        parse_serialized(b"", 0).unwrap_err(),
        "f: the file ends before the end of a serialized mesh"
    );
    assert_eq!(
        parse_serialized(b"PK\x03\x04", 0).unwrap_err(),
        "f: expected 0x041C, the start of a serialized mesh, at byte 0, found 0x4B50"
    );
    assert_eq!(
        parse_serialized(&[0x1C, 4, 9, 0], 0).unwrap_err(),
        "f: found version 9 of the serialized format, expected 3 or 4"
    );
    let cut = file.len() - 30;
    assert!(parse_serialized(&file[..cut], 0).is_err());
    let mut far = file.clone();
    let table = far.len() - 4 - 16;
    far[table + 4] = 1;
    assert_eq!(
        parse_serialized(&far, 0).unwrap_err(),
        "f: the offset of shape 0 is beyond the end of the file"
    );
    let wrong_index = serialized_file(4, &[stream(4, 0x1000, &TRIANGLE, &[0, 1, 3])]);
    assert_eq!(
        parse_serialized(&wrong_index, 0).unwrap_err(),
        "f: triangle 0 refers to the vertices [0, 1, 3], but the mesh has 3, counted from 0"
    );
    let not_finite = serialized_file(4, &[stream(4, 0x1000, &[f32::NAN; 9], &[0, 1, 2])]);
    assert_eq!(
        parse_serialized(&not_finite, 0).unwrap_err(),
        "f: the position of vertex 0 is not finite"
    );
}
