//! Meshes and curves.

use crate::folder::with_file;
use crate::messages::check_file_error;
use manylight::geometry::Mesh;
use manylight_io::FileError;
use manylight_io::mesh::{
    AttributePlace, MeshAttribute, MeshFormat, orient_to_normals, read_curves, read_mesh,
    smooth_normals,
};

/// Reads an OBJ file.
pub(crate) fn check_obj(input: &[u8]) {
    with_file(input, "mesh.obj", |path| {
        check(read_mesh(path, MeshFormat::Obj, true));
    });
}

/// Reads a PLY file.
pub(crate) fn check_ply(input: &[u8]) {
    with_file(input, "mesh.ply", |path| {
        check(read_mesh(path, MeshFormat::Ply, true));
    });
}

/// Reads the first two meshes of a serialized file.
pub(crate) fn check_serialized(input: &[u8]) {
    with_file(input, "mesh.serialized", |path| {
        for shape_index in 0..2 {
            let format = MeshFormat::Serialized { shape_index };
            check(read_mesh(path, format, true));
        }
    });
}

/// Reads a file of curves of at least two points.
pub(crate) fn check_curves(input: &[u8]) {
    with_file(input, "curves.txt", |path| match read_curves(path, 2) {
        Ok(curves) => {
            let points = curves.iter().flatten();
            assert!(points.clone().all(|p| p.is_finite()));
            assert!(curves.iter().all(|curve| curve.len() >= 2));
        }
        Err(error) => check_file_error(&error),
    });
}

/// Checks that indices are valid and numbers finite, also after the steps that scenes take.
fn check(read: Result<(Mesh, Vec<MeshAttribute>), FileError>) {
    let (mut mesh, attributes) = match read {
        Ok(read) => read,
        Err(error) => return check_file_error(&error),
    };
    let vertices = mesh.positions.len();
    for attribute in &attributes {
        let expected = match attribute.place {
            AttributePlace::Vertices => vertices,
            AttributePlace::Triangles => mesh.triangles.len(),
        };
        assert_eq!(attribute.values.len(), expected, "{}", attribute.name);
    }
    check_mesh(&mesh);
    orient_to_normals(&mut mesh, false);
    smooth_normals(&mut mesh);
    check_mesh(&mesh);
}

fn check_mesh(mesh: &Mesh) {
    let vertices = mesh.positions.len();
    for (name, count) in [("normals", mesh.normals.len()), ("uvs", mesh.uvs.len())] {
        assert!(
            count == 0 || count == vertices,
            "{count} {name} of {vertices} vertices"
        );
    }
    let mut indices = mesh.triangles.iter().flatten();
    assert!(
        indices.all(|&i| (i as usize) < vertices),
        "an index out of range"
    );
    assert!(
        mesh.positions.iter().all(|p| p.is_finite()),
        "a position is not finite"
    );
    assert!(
        mesh.normals.iter().all(|n| n.is_finite()),
        "a normal is not finite"
    );
}
