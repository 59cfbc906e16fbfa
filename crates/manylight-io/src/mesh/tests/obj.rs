//! Tests of the OBJ parser.

use super::super::{Mesh, MeshFormat, parse, read_mesh};
use super::{QUAD_OBJ, assert_near, message};
use manylight::math::Vec2;

pub(super) fn parse_obj(text: &str) -> Result<Mesh, String> {
    message(parse(text.as_bytes(), MeshFormat::Obj, false).map(|(mesh, _)| mesh))
}

#[test]
fn obj_polygons_become_fans_and_vertices_keep_their_order() {
    let mesh = parse_obj(QUAD_OBJ).unwrap();
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
    let mesh = parse_obj(text).unwrap();
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
    let expected = parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nf 1/1 2/1 3/1").unwrap();
    assert_eq!(
        parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nf -3/-1 -2/-1 -1/-1").unwrap(),
        expected
    );
    assert_eq!(
        parse_obj("f 1/1 2/1 3/1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1").unwrap(),
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
    let (mesh, _) = read_mesh(&path, MeshFormat::Obj, false).unwrap();
    assert_near(&mesh.normals, &[[1., 0., 0.], [0., 0., 1.], [0., 0., 1.]]);
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
        assert_eq!(parse_obj(text).unwrap_err(), expected, "{text:?}");
    }
}

#[test]
fn odd_but_harmless_obj_files_are_read() {
    assert_eq!(parse_obj("").unwrap(), Mesh::default());
    assert_eq!(
        parse_obj("v 0 0 0\nv 1 0 0\nf 1 2\n").unwrap().triangles,
        [[0_u32; 3]; 0]
    );
    assert_eq!(
        parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nf 1/1 2/1 3/1")
            .unwrap()
            .uvs,
        [Vec2::new(0.5, 0.0); 3]
    );
}

#[test]
fn corners_of_one_position_are_split_and_shared_however_many_there_are() {
    let count = 300;
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for i in 1..=count {
        text.push_str(&format!("vt {i} 0\n"));
    }
    for i in (1..=count).chain(1..=count) {
        text.push_str(&format!("f 1/{i} 2/1 3/1\n"));
    }
    let mesh = parse_obj(&text).unwrap();
    assert_eq!(mesh.positions.len(), count + 2);
    let (first, second) = mesh.triangles.split_at(count);
    assert_eq!(first, second);
    let u = |t: &[u32; 3]| mesh.uvs[t[0] as usize].x;
    assert!(first.iter().map(u).eq((1..=count).map(|i| i as f32)));
}
