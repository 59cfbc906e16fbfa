//! Segments with a common origin against blocks of triangles.
//!
//! An edge function is the volume between the origin, the edge and the direction. Its setup serves all rays of a packet. An edge (a, b)
//! enters as (a - b) x (a + b), which loses less precision for distant edges than a x b. Near a corner the value is subject to rounding;
//! values that rounding may turn negative count as inside, so that no ray passes between neighbors.

use super::triangle_block::TriangleBlock;
use crate::lanes::vectors::{abs3, add3, cross, dot, load3, sub3};
use crate::simd::{Simd, Width};

/// Edge functions and planes of eight triangles for an origin.
pub(super) struct EdgeVolumes<V> {
    /// Normals of the planes through the origin and each edge; the edge function is their dot product with the direction.
    pub(super) edges: [[V; 3]; 3],
    /// Tolerance of each edge function for rounding, for a direction with largest component 1.
    pub(super) tolerances: [V; 3],
    /// Normals of the triangles.
    pub(super) normal: [V; 3],
    /// Dot product of the normal with the vector from the origin to the triangle.
    pub(super) height: V,
}

/// Directions of segments from the common origin: one per lane, or one in all lanes.
pub(super) struct SegmentDirections<V> {
    pub(super) d: [V; 3],
    /// Magnitude of the largest component.
    pub(super) size: V,
}

impl<V: Copy> EdgeVolumes<V> {
    #[inline(always)]
    pub(super) fn new<L: Simd<F = V>>(s: L, block: &TriangleBlock, o: [V; 3]) -> Self {
        let [a, b, c] = [
            load3(s, &block.corners[0]),
            load3(s, &block.corners[1]),
            load3(s, &block.corners[2]),
        ];
        // Edges are differences of corners, not of their rounded offsets from the origin.
        let [ab, bc, ca] = [sub3(s, a, b), sub3(s, b, c), sub3(s, c, a)];
        let [a, b, c] = [sub3(s, a, o), sub3(s, b, o), sub3(s, c, o)];
        let edges = [
            cross(s, ab, add3(s, a, b)),
            cross(s, bc, add3(s, b, c)),
            cross(s, ca, add3(s, c, a)),
        ];
        let normal = cross(s, ca, ab);
        let tolerances = [
            tolerance(s, edges[0]),
            tolerance(s, edges[1]),
            tolerance(s, edges[2]),
        ];
        EdgeVolumes {
            edges,
            tolerances,
            normal,
            height: dot(s, normal, a),
        }
    }

    /// The lanes in which the segment hits the triangle: all edge functions have one sign, and the parameter `height / (normal · d)` of the
    /// plane is in (0, 1).
    #[inline(always)]
    pub(super) fn hit_by<L: Width<F = V>>(&self, s: L, segments: &SegmentDirections<V>) -> L::M {
        let facing = dot(s, self.normal, segments.d);
        let [u, v, w] = [
            self.edge(s, 0, segments, facing),
            self.edge(s, 1, segments, facing),
            self.edge(s, 2, segments, facing),
        ];
        let zero = s.splat(0.0);
        let inside = s.le(zero, s.min(s.min(u, v), w));
        let height = s.mul_sign(self.height, facing);
        s.and(
            inside,
            s.and(s.lt(zero, height), s.lt(height, s.mul_sign(facing, facing))),
        )
    }

    #[inline(always)]
    fn edge<L: Width<F = V>>(
        &self,
        s: L,
        edge: usize,
        segments: &SegmentDirections<V>,
        facing: V,
    ) -> V {
        let value = s.mul_sign(dot(s, self.edges[edge], segments.d), facing);
        s.mul_add(self.tolerances[edge], segments.size, value)
    }

    /// The triangles that a segment with a direction in a box may hit, as bits; conservative. `middle` and `half` are the center and half
    /// extents of the box, `size` is the largest component of any direction in it.
    #[inline(always)]
    pub(super) fn within<L: Simd<F = V>>(
        &self,
        s: L,
        middle: [V; 3],
        half: [V; 3],
        size: V,
    ) -> u32 {
        let zero = s.splat(0.0);
        let reach = dot(s, abs3(s, self.normal), half);
        let facing = dot(s, self.normal, middle);
        let (least, greatest) = (s.sub(facing, reach), s.add(facing, reach));
        // Forwards means along the normal.
        let mut forwards = s.and(s.lt(zero, self.height), s.lt(self.height, greatest));
        let mut backwards = s.and(s.lt(self.height, zero), s.lt(least, self.height));
        for edge in 0..3 {
            let n = self.edges[edge];
            let slack = s.mul(self.tolerances[edge], size);
            let reach = s.add(dot(s, abs3(s, n), half), slack);
            let value = dot(s, n, middle);
            forwards = s.and(forwards, s.le(zero, s.add(value, reach)));
            backwards = s.and(backwards, s.le(s.sub(value, reach), zero));
        }
        s.bits(s.or(forwards, backwards))
    }
}

#[inline(always)]
fn tolerance<L: Width>(s: L, n: [L::F; 3]) -> L::F {
    let [x, y, z] = abs3(s, n);
    s.mul(s.add(s.add(x, y), z), s.splat(ROUNDINGS))
}

/// Bound of the rounding error of an edge function, relative to the sum of the magnitudes of its terms.
pub(super) const ROUNDINGS: f32 = 2.0 * f32::EPSILON;
