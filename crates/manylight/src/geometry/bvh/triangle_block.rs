//! Blocks of eight triangles: the leaves of triangle hierarchies.

use super::item_box::CornerRows;
use super::node::WideNode;
use crate::lanes::{Float, Vector};
use crate::math::Vec2;
use crate::simd::{NARROW, Simd};

/// Up to eight triangles in lanes. Unused lanes hold a degenerate triangle, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Corner, axis, lane.
    pub(super) corners: [[[f32; NARROW]; 3]; 3],
    /// Indices of the triangles in the table of triangles.
    pub(super) ids: [u32; NARROW],
}

impl TriangleBlock {
    /// The block of up to eight triangles with these ids.
    #[inline(always)]
    pub(super) fn new<'a, S: Simd>(
        s: S,
        ids: &[u32],
        corners: impl Fn(u32) -> &'a CornerRows,
    ) -> Self {
        const UNUSED: CornerRows = [[0.0; 4]; 3];
        let rows = Float::gather_quads(s, |lane| {
            let [a, b, c] = ids.get(lane).map_or(&UNUSED, |&id| corners(id));
            [a, b, c]
        });
        let mut block = TriangleBlock {
            corners: [[[0.0; NARROW]; 3]; 3],
            ids: [0; NARROW],
        };
        for (corner, [x, y, z, _]) in block.corners.iter_mut().zip(rows) {
            *corner = Vector::new(x, y, z).store();
        }
        block.ids[..ids.len()].copy_from_slice(ids);
        block
    }

    /// The corners.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, s: S) -> [Vector<S>; 3] {
        [
            Vector::load(s, &self.corners[0]),
            Vector::load(s, &self.corners[1]),
            Vector::load(s, &self.corners[2]),
        ]
    }
}

/// The nodes and leaves of a tree.
#[derive(Clone, Copy)]
pub(super) struct TreeParts<'a> {
    pub(super) nodes: &'a [WideNode],
    pub(super) blocks: &'a [TriangleBlock],
}

/// A hit on a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleHit {
    /// Ray parameter.
    pub(crate) t: f32,
    /// Index of the triangle in the table of triangles.
    pub(crate) id: u32,
    /// Barycentric coordinates of the second and third corner.
    pub(crate) coordinates: Vec2,
}
