//! Triangles of a leaf relative to a visibility tile, and their edge functions.

use super::edge_volumes::ROUNDINGS;
use super::triangle_block::TriangleBlock;
use crate::lanes::vectors::{
    abs3, add3, broadcast3, cross, dot, dot_add, load3, scale3, splat3, store3, sub3,
};
use crate::math::Vec3;
use crate::simd::{LANES, NARROW, Simd, Sixteen};

/// The triangles of a block relative to the center of a tile.
pub(super) struct LeafTriangles {
    /// Indices: corner, axis, lane.
    corners: [[[f32; NARROW]; 3]; 3],
    pub(super) normal: [[f32; NARROW]; 3],
    /// Dot product of the normal with a corner.
    pub(super) height: [f32; NARROW],
}

impl LeafTriangles {
    #[inline(always)]
    pub(super) fn new<S: Simd>(s: S, block: &TriangleBlock, origin: Vec3) -> Self {
        let o = splat3(s, origin);
        let [a, b, c] = [
            load3(s, &block.corners[0]),
            load3(s, &block.corners[1]),
            load3(s, &block.corners[2]),
        ];
        let normal = cross(s, sub3(s, c, a), sub3(s, a, b));
        let [a, b, c] = [sub3(s, a, o), sub3(s, b, o), sub3(s, c, o)];
        LeafTriangles {
            corners: [store3(s, a), store3(s, b), store3(s, c)],
            normal: store3(s, normal),
            height: s.store(dot(s, normal, a)),
        }
    }
}

/// Direction and midpoint of an edge.
pub(super) type Edge<V> = ([V; 3], [V; 3]);

/// One triangle, broadcast to all lanes.
pub(super) struct Triangle<W: Sixteen> {
    pub(super) edges: [Edge<W::F>; 3],
    pub(super) normal: [W::F; 3],
    pub(super) height: W::F,
}

impl<W: Sixteen> Triangle<W> {
    #[inline(always)]
    pub(super) fn new(w: W, triangles: &LeafTriangles, lane: usize) -> Self {
        let [a, b, c] = [
            broadcast3(w, &triangles.corners[0], lane),
            broadcast3(w, &triangles.corners[1], lane),
            broadcast3(w, &triangles.corners[2], lane),
        ];
        Triangle {
            edges: [edge(w, a, b), edge(w, b, c), edge(w, c, a)],
            normal: broadcast3(w, &triangles.normal, lane),
            height: w.splat(triangles.height[lane]),
        }
    }
}

/// An edge. Its midpoint loses less precision than its ends, and is the same for both triangles at the edge.
#[inline(always)]
fn edge<W: Sixteen>(w: W, a: [W::F; 3], b: [W::F; 3]) -> Edge<W::F> {
    let half = w.splat(0.5);
    (sub3(w, b, a), scale3(w, add3(w, a, b), half))
}

/// The planes through each of sixteen points and one edge. A light `l` is inside if `normal · l + offset >= 0`.
pub(super) struct EdgePlanes {
    pub(super) normal: [[f32; LANES]; 3],
    pub(super) offset: [f32; LANES],
}

impl EdgePlanes {
    #[inline(always)]
    pub(super) fn new<W: Sixteen>(
        w: W,
        (e, m): Edge<W::F>,
        p: [W::F; 3],
        upwards: W::F,
        size: f32,
    ) -> Self {
        let n = cross(w, e, sub3(w, p, m));
        let n = [
            w.mul_sign(n[0], upwards),
            w.mul_sign(n[1], upwards),
            w.mul_sign(n[2], upwards),
        ];
        let slack = w.mul(sum_of_sizes(w, n), w.splat(ROUNDINGS * size));
        let offset = w.sub(slack, dot(w, n, p));
        EdgePlanes {
            normal: store3(w, n),
            offset: w.store(offset),
        }
    }

    #[inline(always)]
    pub(super) fn inside<W: Sixteen>(&self, w: W, row: usize, l: [W::F; 3]) -> u32 {
        let n = broadcast3(w, &self.normal, row);
        let value = dot_add(w, n, l, w.splat(self.offset[row]));
        w.bits(w.le(w.splat(0.0), value))
    }
}

/// Sum of the magnitudes of the components.
#[inline(always)]
pub(super) fn sum_of_sizes<W: Sixteen>(w: W, n: [W::F; 3]) -> W::F {
    let [x, y, z] = abs3(w, n);
    w.add(w.add(x, y), z)
}
