//! Blocks of eight triangles: the leaves of triangle hierarchies.

use super::node::WideNode;
use crate::lanes::Vector;
use crate::math::{Vec2, Vec3};
use crate::simd::{NARROW, Simd};

/// Up to eight triangles in lanes. Unused lanes hold a degenerate triangle, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Corner, axis, lane.
    pub(super) corners: [[[f32; NARROW]; 3]; 3],
    /// Indices of the triangles in the list from which the hierarchy was built.
    pub(super) ids: [u32; NARROW],
}

impl TriangleBlock {
    pub(super) fn new(ids: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut block = TriangleBlock {
            corners: [[[0.0; NARROW]; 3]; 3],
            ids: [0; NARROW],
        };
        for (lane, &id) in ids.iter().enumerate() {
            block.ids[lane] = id;
            for (corner, p) in triangles[id as usize].iter().enumerate() {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = p[axis];
                }
            }
        }
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
    /// Index of the triangle in the list from which the hierarchy was built.
    pub(crate) id: u32,
    /// Barycentric coordinates of the second and third corner.
    pub(crate) coordinates: Vec2,
}
