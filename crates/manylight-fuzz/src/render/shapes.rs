//! Shapes: quadrics, and meshes with degenerate and repeated triangles.

use super::numbers::Numbers;
use manylight::geometry::{Mesh, Shape};
use manylight::math::Vec3;

/// Most vertices and triangles of a mesh.
const MAX_VERTICES: usize = 12;
const MAX_TRIANGLES: usize = 16;

pub(super) fn shapes(numbers: &mut Numbers) -> Vec<Shape> {
    (0..1 + numbers.below(4)).map(|_| shape(numbers)).collect()
}

fn shape(numbers: &mut Numbers) -> Shape {
    match numbers.below(8) {
        0 => Shape::Sphere {
            center: numbers.vec3(-1.0, 1.0),
            radius: numbers.float(0.1, 2.0),
        },
        1 => Shape::Disk,
        2 => Shape::Cylinder {
            p0: numbers.vec3(-1.0, 1.0),
            p1: numbers.vec3(-1.0, 1.0),
            radius: numbers.float(0.1, 1.0),
        },
        3 | 4 => Shape::Mesh(room()),
        _ => Shape::Mesh(mesh(numbers)),
    }
}

/// A closed box around the camera.
fn room() -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 0 { -5.0 } else { 5.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    let quads = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..Mesh::default()
    }
}

fn mesh(numbers: &mut Numbers) -> Mesh {
    let vertices = numbers.below(MAX_VERTICES + 1);
    let positions: Vec<Vec3> = (0..vertices).map(|_| numbers.vec3(-2.0, 2.0)).collect();
    let triangles = if vertices == 0 {
        0
    } else {
        numbers.below(MAX_TRIANGLES + 1)
    };
    let mut corner = || numbers.below(vertices) as u32;
    let mut triangles: Vec<[u32; 3]> = (0..triangles)
        .map(|_| [corner(), corner(), corner()])
        .collect();
    if numbers.rarely(4) {
        triangles.extend_from_within(..);
    }
    let normals: Vec<Vec3> = if numbers.flag() {
        (0..vertices).map(|_| numbers.direction()).collect()
    } else {
        Vec::new()
    };
    let tangents = if !normals.is_empty() && numbers.rarely(4) {
        (0..vertices).map(|_| numbers.direction()).collect()
    } else {
        Vec::new()
    };
    let uvs = if numbers.flag() {
        (0..vertices).map(|_| numbers.vec2(-1.0, 2.0)).collect()
    } else {
        Vec::new()
    };
    Mesh {
        positions,
        normals,
        tangents,
        uvs,
        triangles,
    }
}
