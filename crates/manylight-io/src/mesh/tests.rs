//! Small files of every format, damaged files, and random damage.

use super::*;
use crate::fuzz::mutations;
use glam::Affine3A;
use manylight::math::{Vec2, Vec3};
use std::io::Write;

const QUAD_OBJ: &str = "# a square and a triangle\nmtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\n v 0 1 0 1.0\nv\t5e-1 2 0\r\n\
    vt 0 0.25\nvt 1 0\nvt 1 1\nvt 0 1 0\no a\ng x\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 4/4 3/3 5/1 # end\nl 1 2";

const TRIANGLE_PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty uchar red\nproperty float s\nproperty float t\nelement edge 1\nproperty int vertex1\n\
    element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 255 0 0.25\n1 0 0 255 1 0\n1 1 0.5 255 1 1\n0 1 0 255 0 1\n7\n3 4 0 1 2 3\n3 3 0 1 2\n";

fn obj(text: &str) -> Result<Mesh, String> {
    message(parse(text.as_bytes(), MeshFormat::Obj))
}

fn ply(bytes: &[u8]) -> Result<Mesh, String> {
    message(parse(bytes, MeshFormat::Ply))
}

fn serialized(bytes: &[u8], shape_index: usize) -> Result<Mesh, String> {
    message(parse(bytes, MeshFormat::Serialized { shape_index }))
}

fn message(result: Result<Mesh, Fault>) -> Result<Mesh, String> {
    result.map_err(|fault| fault.in_file(Path::new("f")).to_string())
}

fn assert_near(actual: &[Vec3], expected: &[[f32; 3]]) {
    assert_eq!(actual.len(), expected.len());
    for (a, e) in actual.iter().zip(expected) {
        assert!(
            (*a - Vec3::from(*e)).abs().max_element() < 2e-6,
            "{a} is not {e:?}"
        );
    }
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

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.5];

fn two_shapes(version: u16) -> Vec<u8> {
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
fn obj_polygons_become_fans_and_vertices_keep_their_order() {
    let mesh = obj(QUAD_OBJ).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
    assert_near(
        &mesh.positions,
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.5],
            [0., 1., 0.],
            [0.5, 2., 0.],
        ],
    );
    assert_eq!(mesh.uvs[0], Vec2::new(0.0, 0.25));
    assert_eq!(mesh.uvs[4], Vec2::new(0.0, 0.25));
    assert!(mesh.normals.is_empty());
}

#[test]
fn obj_vertices_split_where_normals_differ() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nvn 0 0 2\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//1 4//1\n";
    let mesh = obj(text).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 2, 4]]);
    assert_near(
        &mesh.normals,
        &[
            [0., 0., 1.],
            [0., 0., 1.],
            [0., 0., 1.],
            [0., 1., 0.],
            [0., 0., 1.],
        ],
    );
}

#[test]
fn obj_indices_count_from_either_end_and_may_point_forwards() {
    let expected = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nf 1/1 2/1 3/1").unwrap();
    assert_eq!(
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nf -3/-1 -2/-1 -1/-1").unwrap(),
        expected
    );
    assert_eq!(
        obj("f 1/1 2/1 3/1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1").unwrap(),
        expected
    );
}

#[test]
fn vertices_without_a_normal_get_a_smooth_one_beside_others_that_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.obj");
    std::fs::write(
        &path,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nvn 0 0 0\nf 1//1 2 3//2",
    )
    .unwrap();
    assert_near(
        &read_obj(&path).unwrap().normals,
        &[[1., 0., 0.], [0., 0., 1.], [0., 0., 1.]],
    );
}

#[test]
fn damage_in_obj_is_reported_with_its_place() {
    let cases = [
        ("v 0 0 0\nv 1 x 0", "f:2:5: expected a number, found 'x'"),
        (
            "v 0 0",
            "f:1:6: expected a number, found the end of the file",
        ),
        (
            "v 0 0\nv 0 0 0",
            "f:1:6: expected a number, found the end of the line",
        ),
        ("v 0 0 1.0.0", "f:1:7: expected a number, found '1.0.0'"),
        ("v 0 0 nan", "f:1:1: this vertex position is not finite"),
        ("v 0 0 1e99", "f:1:1: this vertex position is not finite"),
        ("v 0 0 0\nvn 0 inf 0", "f:2:1: this normal is not finite"),
        ("vt 0 nan", "f:1:1: this texture coordinate is not finite"),
        (
            "v 0 0 0\nf 1 2 1",
            "f:2:5: there is no vertex 2: the file has 1, counted from 1",
        ),
        (
            "v 0 0 0\nf 1 0 1",
            "f:2:5: there is no vertex 0: the file has 1, counted from 1",
        ),
        (
            "v 0 0 0\nf 1 -2 1",
            "f:2:5: there is no vertex -2: the file has 1, counted from 1",
        ),
        (
            "v 0 0 0\nf 1/1 1 1",
            "f:2:5: there is no texture coordinate 1: the file has 0, counted from 1",
        ),
        (
            "v 0 0 0\nf 1//9999999999 1 1",
            "f:2:6: there is no normal 9999999999: the file has 0, counted from 1",
        ),
        (
            "v 0 0 0\nf 1 99999999999999999999 1",
            "f:2:5: expected the index of a vertex, found '99999999999999999999'",
        ),
        (
            "v 0 0 0\nf 1 a 1",
            "f:2:5: expected the index of a vertex, found 'a'",
        ),
        (
            "v 0 0 0\nf 1 1.5 1",
            "f:2:6: expected a face corner such as 1/2/3, found '.5'",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(obj(text).unwrap_err(), expected, "{text:?}");
    }
}

#[test]
fn odd_but_harmless_obj_files_are_read() {
    assert_eq!(obj("").unwrap(), Mesh::default());
    assert_eq!(
        obj("v 0 0 0\nv 1 0 0\nf 1 2\n").unwrap().triangles,
        [[0_u32; 3]; 0]
    );
    assert_eq!(
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nf 1/1 2/1 3/1")
            .unwrap()
            .uvs,
        [Vec2::new(0.5, 0.0); 3]
    );
}

#[test]
fn numbers_agree_with_the_standard_library() {
    for text in [
        "0",
        "-0.0",
        "+1.5",
        ".5",
        "5.",
        "549.59998",
        "123456789.123456789",
        "1e-3",
        "-2.5E+3",
        "0.000000000000000000001",
        "1e400",
    ] {
        let (value, length) = text::parse_number(format!("{text} 1").as_bytes()).unwrap();
        assert_eq!(
            value.to_bits(),
            text.parse::<f64>().unwrap().to_bits(),
            "{text}"
        );
        assert_eq!(length, text.len());
    }
    for text in ["", "-", ".", "e5", "x", "--1", "1e", "1-2"] {
        assert!(
            text::parse_number(text.as_bytes()).is_none_or(|(_, length)| length < text.len()),
            "{text}"
        );
    }
}

#[test]
fn smooth_normals_weigh_by_angle() {
    let mut mesh = obj(QUAD_OBJ).unwrap();
    smooth_normals(&mut mesh);
    let expected = [
        [-0.235_702_28, -0.235_702_28, 0.942_809_1],
        [0.0, -0.447_213_6, 0.894_427_2],
        [-0.329_676_7, -0.047_808_59, 0.942_882_6],
        [-0.445_266_54, 0.093_212_93, 0.890_533_1],
        [-0.436_435_8, 0.218_217_9, 0.872_871_6],
    ];
    assert_near(&mesh.normals, &expected);
}

#[test]
fn placed_smooth_normals_follow_the_placed_triangles() {
    let placement = Affine3A::from_scale(Vec3::new(1.0, 3.0, -2.0));
    let mut mesh = obj(QUAD_OBJ).unwrap();
    smooth_normals_placed(&mut mesh, &placement);
    let normal_matrix = placement.matrix3.inverse().transpose();
    let world: Vec<Vec3> = mesh
        .normals
        .iter()
        .map(|&n| Vec3::from(normal_matrix * glam::Vec3A::from(n)).normalize())
        .collect();
    let expected = [
        [0.195_429_68, 0.250_884_9, 0.948_084_35],
        [0.0, 0.316_227_8, 0.948_683_26],
        [0.648_170_8, -0.018_478_57, 0.761_270_7],
        [0.705_982_74, -0.056_363_437, 0.705_982_74],
        [0.702_246_9, -0.117_041_156, 0.702_246_9],
    ];
    assert_near(&world, &expected);
    assert_eq!(mesh.positions[4], Vec3::new(0.5, 2.0, 0.0));
}

#[test]
fn vertices_of_no_triangle_with_area_get_the_x_axis() {
    let mut mesh = obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3").unwrap();
    smooth_normals(&mut mesh);
    assert_near(&mesh.normals, &[[1., 0., 0.]; 3]);
}

#[test]
fn ascii_ply_skips_what_it_does_not_know() {
    let mesh = ply(TRIANGLE_PLY.as_bytes()).unwrap();
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

#[test]
fn binary_ply_of_both_byte_orders() {
    let little = binary_ply(
        "binary_little_endian",
        f32::to_le_bytes,
        u32::to_le_bytes,
        f64::to_le_bytes,
    );
    let big = binary_ply(
        "binary_big_endian",
        f32::to_be_bytes,
        u32::to_be_bytes,
        f64::to_be_bytes,
    );
    let mesh = ply(&little).unwrap();
    assert_eq!(mesh, ply(&big).unwrap());
    assert_eq!(mesh.triangles, [[2, 1, 0]]);
    assert_near(
        &mesh.positions,
        &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5]],
    );
    assert_near(&mesh.normals, &[[0., 1., 0.]; 3]);
    for cut in [little.len() - 1, little.len() - 30] {
        let text = ply(&little[..cut]).unwrap_err();
        assert!(
            text.starts_with(&format!("f: the file ends at byte {cut}")),
            "{text}"
        );
    }
}

#[test]
fn damage_in_ply_is_reported() {
    let ascii =
        |from: &str, to: &str| ply(TRIANGLE_PLY.replacen(from, to, 1).as_bytes()).unwrap_err();
    assert_eq!(
        ply(b"solid x").unwrap_err(),
        "f:1:1: expected a PLY file, which starts with the line 'ply', found 'solid'"
    );
    assert_eq!(
        ascii("ascii", "text"),
        "f:2:1: unknown format 'text'; expected ascii, binary_little_endian or binary_big_endian"
    );
    assert_eq!(
        ascii("vertex 4", "vertex -4"),
        "f:4:1: '-4' is not a number of elements"
    );
    assert_eq!(
        ascii("float x", "half x"),
        "f:5:1: unknown property type 'half'"
    );
    assert_eq!(
        ascii("float x", "float w"),
        "f: the element 'vertex' lacks a property x, y or z"
    );
    assert_eq!(
        ascii("vertex_indices", "corners"),
        "f: the element 'face' lacks a list 'vertex_indices'"
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
        "f: a face refers to the vertices [0, 1, 4], but there are only 4, counted from 0"
    );
    assert_eq!(
        ascii("3 3 0 1 2", "3 -3 0 1 2"),
        "f:23:5: a list cannot have -3 items here"
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
fn serialized_shapes_of_both_versions_and_precisions() {
    for version in [3, 4] {
        let file = two_shapes(version);
        let plain = serialized(&file, 0).unwrap();
        assert_eq!(plain.triangles, [[0, 1, 2]]);
        assert_near(
            &plain.positions,
            &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5]],
        );
        assert!(plain.normals.is_empty() && plain.uvs.is_empty());
        let rich = serialized(&file, 1).unwrap();
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
        serialized(&file, 2).unwrap_err(),
        "f: there is no shape 2: the file has 2, counted from 0"
    );
    assert_eq!(
        serialized(b"", 0).unwrap_err(),
        "f: the file ends too early for a serialized mesh"
    );
    assert_eq!(
        serialized(b"PK\x03\x04", 0).unwrap_err(),
        "f: expected the mark 0x041C of a serialized mesh at byte 0, found 0x4B50"
    );
    assert_eq!(
        serialized(&[0x1C, 4, 9, 0], 0).unwrap_err(),
        "f: version 9 of the serialized format is unknown; expected 3 or 4"
    );
    let cut = file.len() - 30;
    assert!(serialized(&file[..cut], 0).is_err());
    let mut far = file.clone();
    let table = far.len() - 4 - 16;
    far[table + 4] = 1;
    assert_eq!(
        serialized(&far, 0).unwrap_err(),
        "f: the offset of shape 0 points behind the end of the file"
    );
    let wrong_index = serialized_file(4, &[stream(4, 0x1000, &TRIANGLE, &[0, 1, 3])]);
    assert_eq!(
        serialized(&wrong_index, 0).unwrap_err(),
        "f: triangle 0 refers to the vertices [0, 1, 3], but there are only 3"
    );
    let not_finite = serialized_file(4, &[stream(4, 0x1000, &[f32::NAN; 9], &[0, 1, 2])]);
    assert_eq!(
        serialized(&not_finite, 0).unwrap_err(),
        "f: the position of vertex 0 is not finite"
    );
}

#[test]
fn random_damage_never_panics_and_never_gives_a_broken_mesh() {
    let little = binary_ply(
        "binary_little_endian",
        f32::to_le_bytes,
        u32::to_le_bytes,
        f64::to_le_bytes,
    );
    let shape = MeshFormat::Serialized { shape_index: 1 };
    let seeds = [
        (QUAD_OBJ.as_bytes().to_vec(), MeshFormat::Obj),
        (TRIANGLE_PLY.as_bytes().to_vec(), MeshFormat::Ply),
        (little, MeshFormat::Ply),
        (two_shapes(4), shape),
    ];
    let mut accepted = 0;
    for (seed, format) in seeds {
        for bytes in mutations(&seed, 3000) {
            let Ok(mesh) = parse(&bytes, format) else {
                continue;
            };
            let count = mesh.positions.len();
            assert!(
                mesh.triangles
                    .iter()
                    .flatten()
                    .all(|&i| (i as usize) < count)
            );
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
            assert!(mesh.normals.is_empty() || mesh.normals.len() == count);
            assert!(mesh.uvs.is_empty() || mesh.uvs.len() == count);
            accepted += 1;
        }
    }
    assert!(
        accepted > 100,
        "only {accepted} damaged files still load: the damage is too coarse to test much"
    );
}

#[test]
fn a_missing_file_says_so() {
    let error = read_obj(Path::new("no/such/file.obj")).unwrap_err();
    assert!(matches!(error.kind, crate::FileErrorKind::NotFound));
    assert_eq!(
        error.to_string(),
        "no/such/file.obj: the file does not exist"
    );
}
