//! Tests of the mesh parsers: small, damaged and randomly damaged files of every format.

mod obj;
mod ply;
mod serialized;

use self::{obj::parse_obj, serialized::two_shapes};
use super::*;
use crate::testing::mutations;
use glam::Affine3A;
use manylight::math::Vec3;

/// A square with uv coordinates and a triangle.
const QUAD_OBJ: &str = "# a square and a triangle\nmtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\n v 0 1 0 1.0\nv\t5e-1 2 0\r\n\
    vt 0 0.25\nvt 1 0\nvt 1 1\nvt 0 1 0\no a\ng x\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 4/4 3/3 5/1 # end\nl 1 2";

/// The result with the error as text, for a file named `f`.
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

/// Positions of a triangle.
const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.5];

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
fn smooth_normals_are_weighted_by_angle() {
    let mut mesh = parse_obj(QUAD_OBJ).unwrap();
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
fn placed_smooth_normals_follow_the_transformed_triangles() {
    let placement = Affine3A::from_scale(Vec3::new(1.0, 3.0, -2.0));
    let mut mesh = parse_obj(QUAD_OBJ).unwrap();
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
fn vertices_without_a_triangle_of_positive_area_get_the_x_axis() {
    let mut mesh = parse_obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3").unwrap();
    smooth_normals(&mut mesh);
    assert_near(&mesh.normals, &[[1., 0., 0.]; 3]);
}

#[test]
fn random_damage_never_panics_and_never_gives_a_broken_mesh() {
    let little = ply::binary_little_endian();
    let shape = MeshFormat::Serialized { shape_index: 1 };
    let seeds = [
        (QUAD_OBJ.as_bytes().to_vec(), MeshFormat::Obj),
        (ply::TRIANGLE_PLY.as_bytes().to_vec(), MeshFormat::Ply),
        (little, MeshFormat::Ply),
        (two_shapes(4), shape),
    ];
    let mut accepted = 0;
    for (seed, format) in seeds {
        for bytes in mutations(&seed, 3000) {
            let Ok((mesh, attributes)) = parse(&bytes, format, true) else {
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
            for attribute in attributes {
                let expected = match attribute.place {
                    AttributePlace::Vertices => count,
                    AttributePlace::Triangles => mesh.triangles.len(),
                };
                assert_eq!(attribute.values.len(), expected);
            }
            accepted += 1;
        }
    }
    assert!(
        accepted > 100,
        "only {accepted} damaged files still load: the test covers too little"
    );
}

#[test]
fn missing_files_are_reported() {
    let error = read_mesh(Path::new("no/such/file.obj"), MeshFormat::Obj, false).unwrap_err();
    assert!(matches!(error.kind, crate::FileErrorKind::NotFound));
    assert_eq!(
        error.to_string(),
        "no/such/file.obj: the file does not exist"
    );
}
