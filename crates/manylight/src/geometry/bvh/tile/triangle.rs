//! Triangles of a leaf relative to a visibility tile, and their edge functions.

use crate::geometry::bvh::edge_volumes::{ROUNDINGS, sum_of_sizes};
use crate::geometry::bvh::triangle_block::TriangleBlock;
use crate::lanes::{Float, LANES, Sixteen, Vector, Width, lane};
use crate::math::Vec3;
use crate::simd::{NARROW, Simd};

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
        let o = Vector::splat(s, origin);
        let [a, b, c] = block.load(s);
        let normal = (c - a).cross(a - b);
        let (a, b, c) = (a - o, b - o, c - o);
        LeafTriangles {
            corners: [a.store(), b.store(), c.store()],
            normal: normal.store(),
            height: normal.dot(a).store(),
        }
    }
}

/// An edge.
#[derive(Clone, Copy)]
pub(super) struct Edge<S: Width> {
    pub(super) direction: Vector<S>,
    /// The midpoint. It loses less precision than the ends, and is the same for both triangles at
    /// the edge.
    pub(super) middle: Vector<S>,
}

impl<S: Width> Edge<S> {
    #[inline(always)]
    fn new(a: Vector<S>, b: Vector<S>) -> Self {
        Edge {
            direction: b - a,
            middle: (a + b) * 0.5,
        }
    }
}

/// One triangle, broadcast to all lanes.
pub(super) struct Triangle<S: Width> {
    pub(super) edges: [Edge<S>; 3],
    pub(super) normal: Vector<S>,
    pub(super) height: Float<S>,
}

impl<S: Sixteen> Triangle<S> {
    #[inline(always)]
    pub(super) fn new(s: S, triangles: &LeafTriangles, place: usize) -> Self {
        let a = Vector::splat(s, lane(&triangles.corners[0], place).into());
        let b = Vector::splat(s, lane(&triangles.corners[1], place).into());
        let c = Vector::splat(s, lane(&triangles.corners[2], place).into());
        Triangle {
            edges: [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)],
            normal: Vector::splat(s, lane(&triangles.normal, place).into()),
            height: Float::splat(s, triangles.height[place]),
        }
    }
}

/// The planes through each of sixteen points and one edge. A light `l` is inside if
/// `normal · l + offset >= 0`.
pub(super) struct EdgePlanes {
    pub(super) normal: [[f32; LANES]; 3],
    pub(super) offset: [f32; LANES],
}

impl EdgePlanes {
    #[inline(always)]
    pub(super) fn new<S: Sixteen>(
        edge: Edge<S>,
        p: Vector<S>,
        upwards: Float<S>,
        size: f32,
    ) -> Self {
        let n = edge.direction.cross(p - edge.middle);
        let n = Vector::new(
            n.x.mul_sign(upwards),
            n.y.mul_sign(upwards),
            n.z.mul_sign(upwards),
        );
        let slack = sum_of_sizes(n) * (ROUNDINGS * size);
        EdgePlanes {
            normal: n.store(),
            offset: (slack - n.dot(p)).store(),
        }
    }

    #[inline(always)]
    pub(super) fn inside<S: Sixteen>(&self, row: usize, l: Vector<S>) -> u32 {
        let s = l.x.width();
        let n = Vector::splat(s, lane(&self.normal, row).into());
        let value = n.dot_add(l, Float::splat(s, self.offset[row]));
        value.ge(0.0).bits()
    }
}
