//! Meshes under the transforms of their primitives.

use super::triangle::{PlacedTriangle, TriangleCorners};
use super::vertex::PlacedVertex;
use crate::geometry::{Mesh, Primitive};
use crate::lanes::One;
use crate::math::{Affine3A, Mat3, Vec2, Vec3};
use glam::Mat3A;
use rayon::prelude::*;

/// A mesh under the transform of its primitive.
pub(super) struct PlacedMesh<'a> {
    pub(super) mesh: &'a Mesh,
    transform: &'a Affine3A,
    flip: bool,
    normals: NormalTransform,
    /// Whether shading follows the normals of the vertices.
    is_shaded: bool,
}

impl<'a> PlacedMesh<'a> {
    pub(super) fn new(mesh: &'a Mesh, primitive: &'a Primitive) -> Self {
        let (transform, flip) = (&primitive.world_from_object, primitive.flip_normals);
        let mut placed = PlacedMesh {
            mesh,
            transform,
            flip,
            normals: NormalTransform::new(transform, flip),
            is_shaded: true,
        };
        placed.is_shaded = !mesh.tangents.is_empty() || !placed.is_flat();
        placed
    }

    /// Number of vertices with attributes: none if the mesh has neither shading normals nor texture
    /// coordinates.
    pub(super) fn vertex_count(&self) -> usize {
        match self.is_shaded || !self.mesh.uvs.is_empty() {
            true => self.mesh.positions.len(),
            false => 0,
        }
    }

    /// The corners of a triangle, with the indices of vertices that it has in the mesh and without
    /// vertex tangents.
    #[inline]
    pub(super) fn corners(&self, index: usize) -> TriangleCorners {
        let vertices = self.mesh.triangles[index];
        let position = |i: u32| {
            let position = self.mesh.positions[i as usize];
            self.transform.transform_point3(position)
        };
        TriangleCorners {
            p: vertices.map(position),
            uvs: match self.mesh.uvs.is_empty() {
                true => [Vec2::ZERO, Vec2::X, Vec2::Y],
                false => vertices.map(|i| self.mesh.uvs[i as usize]),
            },
            flip: self.flip,
            vertices,
            tangents_behind: 0,
        }
    }

    /// The attributes of a vertex.
    pub(super) fn vertex(&self, index: usize) -> PlacedVertex {
        let normal = match self.is_shaded {
            true => self.normals.apply(self.mesh.normals[index]),
            false => Vec3::ZERO,
        };
        let uv = self.mesh.uvs.get(index).copied();
        PlacedVertex::new(normal, uv.unwrap_or(Vec2::NAN))
    }

    /// The tangent at a vertex, not normalized.
    pub(super) fn tangent(&self, index: usize) -> Vec3 {
        self.transform.transform_vector3(self.mesh.tangents[index])
    }

    /// Whether all vertex normals equal the geometric normals of their triangles up to rounding, or
    /// there are none.
    fn is_flat(&self) -> bool {
        /// Difference per component that counts as equal.
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        if self.mesh.normals.is_empty() {
            return true;
        }
        let is_flat = |index: usize| {
            let [triangle] = PlacedTriangle::each(One, &[self.corners(index)]);
            let ng = triangle.ng();
            self.mesh.triangles[index].iter().all(|&i| {
                let normal = self.normals.apply(self.mesh.normals[i as usize]);
                normal.normalize_or(ng).abs_diff_eq(ng, ROUNDING)
            })
        };
        // Most meshes that are not flat are curved at their first triangle.
        let rest = 1..self.mesh.triangles.len();
        (self.mesh.triangles.is_empty() || is_flat(0)) && rest.into_par_iter().all(is_flat)
    }
}

/// Transform of vertex normals.
struct NormalTransform {
    /// Inverse transpose of the transform, reversed for flipped normals.
    matrix: Mat3,
    /// Whether all lengths scale alike, so that normals may be interpolated before they are
    /// normalized.
    is_similarity: bool,
}

impl NormalTransform {
    fn new(transform: &Affine3A, flip: bool) -> Self {
        /// Relative difference of squared scales that counts as equal.
        const SIMILARITY: f32 = 1e-5;
        let m = transform.matrix3;
        let scale = m.x_axis.length_squared();
        let gram = m.transpose() * m;
        let is_similarity =
            gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(scale)), SIMILARITY * scale);
        let matrix: Mat3 = m.inverse().transpose().into();
        NormalTransform {
            matrix: if flip { -matrix } else { matrix },
            is_similarity,
        }
    }

    fn apply(&self, normal: Vec3) -> Vec3 {
        let normal = self.matrix * normal;
        match self.is_similarity {
            true => normal,
            false => normal.normalize_or_zero(),
        }
    }
}
