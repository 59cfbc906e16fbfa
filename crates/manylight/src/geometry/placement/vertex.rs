//! Attributes of vertices under the transform of their mesh.

use crate::lanes::{Float, Pair, Width};
use crate::math::{Vec2, Vec3};

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

    pub(super) const fn new(normal: Vec3, uv: Vec2) -> Self {
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
