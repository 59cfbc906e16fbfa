//! Segments with a common origin against blocks of triangles.
//!
//! An edge function is the volume between the origin, the edge and the direction. Its setup serves
//! all rays of a packet. An edge (a, b) enters as (a - b) x (a + b), which loses less precision for
//! distant edges than a x b. Near a corner the value is subject to rounding; values that rounding
//! may turn negative count as inside, so that no ray passes between neighbors.

use super::triangle_block::TriangleBlock;
use crate::lanes::{Float, Mask, Vector, Width};
use crate::simd::Simd;

/// Edge functions and planes of triangles for an origin.
pub(super) struct EdgeVolumes<S: Width> {
    /// Normals of the planes through the origin and each edge; the edge function is their dot
    /// product with the direction.
    pub(super) edges: [Vector<S>; 3],
    /// Tolerance of each edge function for rounding, for a direction with largest component 1.
    pub(super) tolerances: [Float<S>; 3],
    /// Normals of the triangles.
    pub(super) normal: Vector<S>,
    /// Dot product of the normal with the vector from the origin to the triangle.
    pub(super) height: Float<S>,
}

/// Directions of segments from the common origin.
pub(super) struct SegmentDirections<S: Width> {
    pub(super) d: Vector<S>,
    /// Magnitude of the largest component.
    pub(super) size: Float<S>,
}

impl<S: Simd> EdgeVolumes<S> {
    /// Of the eight triangles of a block, for the origin `o`.
    #[inline(always)]
    pub(super) fn new(s: S, block: &TriangleBlock, o: Vector<S>) -> Self {
        let [a, b, c] = block.load(s);
        // Edges are differences of corners, not of their rounded offsets from the origin.
        let (ab, bc, ca) = (a - b, b - c, c - a);
        let (a, b, c) = (a - o, b - o, c - o);
        let edges = [ab.cross(a + b), bc.cross(b + c), ca.cross(c + a)];
        let normal = ca.cross(ab);
        EdgeVolumes {
            edges,
            tolerances: [
                sum_of_sizes(edges[0]) * ROUNDINGS,
                sum_of_sizes(edges[1]) * ROUNDINGS,
                sum_of_sizes(edges[2]) * ROUNDINGS,
            ],
            normal,
            height: normal.dot(a),
        }
    }

    /// The triangles that a segment with a direction in a box may hit, as bits; conservative.
    /// `middle` and `half` are the center and half extents of the box, `size` is the largest
    /// component of any direction in it.
    #[inline(always)]
    pub(super) fn within(&self, middle: Vector<S>, half: Vector<S>, size: f32) -> u32 {
        let reach = self.normal.abs().dot(half);
        let facing = self.normal.dot(middle);
        let (least, greatest) = (facing - reach, facing + reach);
        // Forwards means along the normal.
        let mut forwards = self.height.gt(0.0) & self.height.lt(greatest);
        let mut backwards = self.height.lt(0.0) & least.lt(self.height);
        for edge in 0..3 {
            let n = self.edges[edge];
            let reach = n.abs().dot(half) + self.tolerances[edge] * size;
            let value = n.dot(middle);
            forwards = forwards & (value + reach).ge(0.0);
            backwards = backwards & (value - reach).le(0.0);
        }
        (forwards | backwards).bits()
    }
}

impl<S: Width> EdgeVolumes<S> {
    /// The lanes in which the segment hits the triangle: all edge functions have one sign, and the
    /// parameter `height / (normal · d)` of the plane is in (0, 1).
    #[inline(always)]
    pub(super) fn hit_by(&self, segments: &SegmentDirections<S>) -> Mask<S> {
        let facing = self.normal.dot(segments.d);
        let u = self.edge(0, segments, facing);
        let v = self.edge(1, segments, facing);
        let w = self.edge(2, segments, facing);
        let inside = u.min(v).min(w).ge(0.0);
        let height = self.height.mul_sign(facing);
        inside & (height.gt(0.0) & height.lt(facing.mul_sign(facing)))
    }

    #[inline(always)]
    fn edge(&self, edge: usize, segments: &SegmentDirections<S>, facing: Float<S>) -> Float<S> {
        let value = self.edges[edge].dot(segments.d).mul_sign(facing);
        self.tolerances[edge].mul_add(segments.size, value)
    }
}

/// Sum of the magnitudes of the components.
#[inline(always)]
pub(super) fn sum_of_sizes<S: Width>(n: Vector<S>) -> Float<S> {
    let size = n.abs();
    size.x + size.y + size.z
}

/// Bound of the rounding error of an edge function, relative to the sum of the magnitudes of its
/// terms.
pub(super) const ROUNDINGS: f32 = 2.0 * f32::EPSILON;
