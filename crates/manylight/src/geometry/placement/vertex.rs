//! Attributes of vertices under the transform of their mesh.

use super::triangle::PlacedTriangle;
use crate::geometry::Mesh;
use crate::lanes::{Float, Pair, Width};
use crate::math::{Affine3A, Mat3, Vec2, Vec3};
use glam::Mat3A;

/// A shading normal, not normalized, and texture coordinates.
///
/// The normal is 0 if shading follows the geometric normal. The texture coordinates are NaN if the
/// mesh has none: then those of the corners are (0,0), (1,0), (0,1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlacedVertex([f32; 5]);

impl PlacedVertex {
    /// The vertices of all triangles of meshes with neither shading normals nor texture
    /// coordinates.
    pub(super) const PLAIN: [PlacedVertex; 3] = [
        PlacedVertex::new(Vec3::ZERO, Vec2::ZERO),
        PlacedVertex::new(Vec3::ZERO, Vec2::X),
        PlacedVertex::new(Vec3::ZERO, Vec2::Y),
    ];

    const fn new(normal: Vec3, uv: Vec2) -> Self {
        PlacedVertex([normal.x, normal.y, normal.z, uv.x, uv.y])
    }

    /// The normal and u; v as the last.
    #[inline(always)]
    pub(super) fn quads(&self) -> [&[f32; 4]; 2] {
        let [first @ .., _] = &self.0;
        let [_, last @ ..] = &self.0;
        [first, last]
    }

    /// The texture coordinates.
    #[inline]
    pub(super) fn uv(&self) -> Vec2 {
        Vec2::new(self.0[3], self.0[4])
    }
}

/// The attributes of the vertices of a mesh under a transform.
#[derive(Debug, Default)]
pub(super) struct PlacedVertices {
    /// Empty if the mesh has neither shading normals nor texture coordinates.
    pub(super) vertices: Vec<PlacedVertex>,
    /// Tangents, transformed, not normalized; empty if the mesh has none.
    pub(super) tangents: Vec<Vec3>,
}

impl PlacedVertices {
    /// `triangles` are those of the mesh under the transform.
    pub(super) fn new(
        mesh: &Mesh,
        transform: &Affine3A,
        flip: bool,
        triangles: &[PlacedTriangle],
    ) -> Self {
        let normals = NormalTransform::new(transform, flip);
        let normal = |i: usize| normals.apply(mesh.normals[i]);
        let is_shaded = !mesh.tangents.is_empty() || !is_flat(mesh, normal, triangles);
        let vertex = |i: usize| {
            PlacedVertex::new(
                if is_shaded { normal(i) } else { Vec3::ZERO },
                mesh.uvs.get(i).copied().unwrap_or(Vec2::NAN),
            )
        };
        let count = match is_shaded || !mesh.uvs.is_empty() {
            true => mesh.positions.len(),
            false => 0,
        };
        PlacedVertices {
            vertices: (0..count).map(vertex).collect(),
            tangents: mesh
                .tangents
                .iter()
                .map(|&t| transform.transform_vector3(t))
                .collect(),
        }
    }
}

/// Whether all vertex normals equal the geometric normals of their triangles up to rounding, or
/// there are none.
fn is_flat(mesh: &Mesh, normal: impl Fn(usize) -> Vec3, triangles: &[PlacedTriangle]) -> bool {
    /// Difference per component that counts as equal.
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    let is_flat = |triangle: &PlacedTriangle, i: u32| {
        let ng = triangle.ng();
        normal(i as usize)
            .normalize_or(ng)
            .abs_diff_eq(ng, ROUNDING)
    };
    mesh.normals.is_empty()
        || triangles
            .iter()
            .zip(&mesh.triangles)
            .all(|(triangle, corners)| corners.iter().all(|&i| is_flat(triangle, i)))
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

/// `values` at the three corners, interpolated with the weights of the corners.
#[inline(always)]
pub(super) fn mix<S: Width>([a, b, c]: [Float<S>; 3], weights: [Float<S>; 3]) -> Float<S> {
    c.mul_add(weights[2], b.mul_add(weights[1], a * weights[0]))
}

/// The texture coordinates of the corners, defaults where the mesh has none.
#[inline(always)]
pub(super) fn corner_uvs<S: Width>([a, b, c]: [Pair<S>; 3]) -> [Pair<S>; 3] {
    let exist = a.x.equals(a.x);
    if exist.all() {
        return [a, b, c];
    }
    [
        Pair::new(exist.select(a.x, 0.0), exist.select(a.y, 0.0)),
        Pair::new(exist.select(b.x, 1.0), exist.select(b.y, 0.0)),
        Pair::new(exist.select(c.x, 0.0), exist.select(c.y, 1.0)),
    ]
}
