//! The region that rays of one octant may reach: which boxes and triangles are tested against
//! single rays of a group at all.

use super::node::WideNode;
use super::traverse::FAR_MARGIN;
use super::triangle_block::TriangleBlock;
use crate::lanes::{Float, Lanes3};
use crate::simd::Simd;

/// Margin for the rounding of a ray's slab test, in units of the largest `|o / d|`. Twice the error
/// of the test.
const SHIFT_MARGIN: f32 = 16.0 * f32::EPSILON;

/// Bounds of the origins and of the reciprocal directions of rays of one octant.
pub(super) struct Beam {
    octant: usize,
    /// Per axis, the origin with the earliest entry through near planes, and the one with the
    /// latest exit through far planes.
    first: [f32; 3],
    last: [f32; 3],
    /// Least and largest reciprocal of the direction.
    least: [f32; 3],
    most: [f32; 3],
    /// Bound of the rounding of the slab test of a ray.
    slack: [f32; 3],
}

impl Beam {
    /// The beam around rays with origins `o` and reciprocal directions `scale`.
    #[inline(always)]
    pub(super) fn new(octant: usize, o: &Lanes3, scale: &Lanes3) -> Self {
        let mut beam = Beam {
            octant,
            first: [0.0; 3],
            last: [0.0; 3],
            least: [0.0; 3],
            most: [0.0; 3],
            slack: [0.0; 3],
        };
        for axis in 0..3 {
            let (low, high) = range(&o.0[axis]);
            let (least, most) = range(&scale.0[axis]);
            let rising = octant >> axis & 1 == 0;
            (beam.first[axis], beam.last[axis]) = if rising { (high, low) } else { (low, high) };
            (beam.least[axis], beam.most[axis]) = (least, most);
            let largest = low.abs().max(high.abs()) * least.abs().max(most.abs());
            beam.slack[axis] = SHIFT_MARGIN * largest;
        }
        beam
    }

    /// Parameters before which no ray of the beam enters the children of a node, and after which
    /// none leaves them.
    #[inline(always)]
    pub(super) fn cut_node<S: Simd>(
        &self,
        s: S,
        node: &WideNode,
        reach: f32,
    ) -> (Float<S>, Float<S>) {
        let plane = |i: usize| Float::load(s, &node.bounds[i]);
        let near = |axis: usize| plane(axis + 3 * (self.octant >> axis & 1));
        let far = |axis: usize| plane(axis + 3 * (!self.octant >> axis & 1));
        let near = [near(0), near(1), near(2)];
        self.cut(near, [far(0), far(1), far(2)], reach)
    }

    /// The triangles of a block that a ray of the beam may hit, as bits.
    #[inline(always)]
    pub(super) fn meets<S: Simd>(&self, s: S, block: &TriangleBlock, reach: f32) -> u32 {
        let (x, y, z) = (
            self.planes(s, block, 0),
            self.planes(s, block, 1),
            self.planes(s, block, 2),
        );
        let (near, far) = self.cut([x.0, y.0, z.0], [x.1, y.1, z.1], reach);
        near.le(far).bits()
    }

    /// The near and the far planes of the boxes of triangles.
    #[inline(always)]
    fn planes<S: Simd>(&self, s: S, block: &TriangleBlock, axis: usize) -> (Float<S>, Float<S>) {
        let corner = |i: usize| Float::load(s, &block.corners[i][axis]);
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
        if self.octant >> axis & 1 == 0 {
            (lower, upper)
        } else {
            (upper, lower)
        }
    }

    #[inline(always)]
    fn cut<S: Simd>(
        &self,
        near: [Float<S>; 3],
        far: [Float<S>; 3],
        reach: f32,
    ) -> (Float<S>, Float<S>) {
        let mut enter = near[0].same(0.0);
        let mut leave = near[0].same(f32::INFINITY);
        for axis in 0..3 {
            let (least, most) = (self.least[axis], self.most[axis]);
            let before = near[axis] - self.first[axis];
            let t = (before * least).min(before * most);
            enter = enter.max(t - self.slack[axis]);
            let behind = far[axis] - self.last[axis];
            let t = (behind * least).max(behind * most);
            leave = leave.min(t + self.slack[axis]);
        }
        (enter, (leave * (FAR_MARGIN * FAR_MARGIN)).min(reach))
    }
}

/// Least and largest value.
#[inline(always)]
pub(super) fn range<const N: usize>(x: &[f32; N]) -> (f32, f32) {
    let mut low = *x;
    let mut high = *x;
    let mut half = N / 2;
    // A tree of vector operations.
    while half > 0 {
        for i in 0..half {
            low[i] = if low[i + half] < low[i] {
                low[i + half]
            } else {
                low[i]
            };
            high[i] = if high[i + half] > high[i] {
                high[i + half]
            } else {
                high[i]
            };
        }
        half /= 2;
    }
    (low[0], high[0])
}
