//! The geometry of shapes, and meshes of parametric surfaces.

use super::super::elements::Elements;
use manylight::geometry::Mesh;
use manylight::ids::ShapeId;
use manylight::math::{Affine3A, Vec2, Vec3};

/// The geometry of a shape with its transform.
pub(super) struct Geometry {
    pub(super) shape: ShapeId,
    pub(super) world_from_object: Affine3A,
    /// Whether the normals of the core point to the other side than those of PBRT.
    pub(super) is_reversed: bool,
    /// The shapes that PBRT makes of it.
    pub(super) elements: Elements,
}

/// Appends a mesh.
pub(super) fn append(mesh: &mut Mesh, piece: Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(piece.positions);
    mesh.normals.extend(piece.normals);
    mesh.uvs.extend(piece.uvs);
    let moved = piece.triangles.into_iter();
    mesh.triangles
        .extend(moved.map(|triangle| triangle.map(|i| i + first)));
}

/// A mesh of `n[0]` x `n[1]` quadrilaterals over the unit square of (u, v), each split into two
/// triangles. `surface` gives position and normal at (u, v); the texture coordinates are (u, v).
pub(super) fn grid(n: [usize; 2], surface: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=n[1] {
        for i in 0..=n[0] {
            let (u, v) = (i as f32 / n[0] as f32, j as f32 / n[1] as f32);
            let (p, normal) = surface(u, v);
            mesh.positions.push(p);
            mesh.normals.push(normal.normalize_or(Vec3::Z));
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let at = |i: usize, j: usize| (j * (n[0] + 1) + i) as u32;
    for j in 0..n[1] {
        for i in 0..n[0] {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let [a, b, c, d] = corners;
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        }
    }
    // At poles an edge has no length.
    let positions = &mesh.positions;
    mesh.triangles.retain(|triangle| {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        a != b && b != c && c != a
    });
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_two_triangles_for_each_cell() {
        let mesh = grid([3, 2], |u, v| (Vec3::new(u, v, 0.0), Vec3::Z));
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (12, 12));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }
}
