//! The region that rays of one octant may reach: which boxes and triangles are tested against single rays of a group at all.

use super::node::WideNode;
use super::traverse::FAR_MARGIN;
use super::triangle_block::TriangleBlock;
use crate::lanes::Lanes3;
use crate::simd::Simd;

/// Margin for the rounding of a ray's slab test, in units of the largest `|o / d|`. Twice the error of the test.
const SHIFT_MARGIN: f32 = 16.0 * f32::EPSILON;

/// Bounds of the origins and of the reciprocal directions of rays of one octant.
pub(super) struct Beam {
    octant: usize,
    /// Per axis, the origin with the earliest entry through near planes, and the one with the latest exit through far planes.
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

    /// Parameters before which no ray of the beam enters the children of a node, and after which none leaves them.
    #[inline(always)]
    pub(super) fn cut_node<S: Simd>(&self, s: S, node: &WideNode, reach: f32) -> (S::F, S::F) {
        let near = |axis: usize| s.load(&node.bounds[axis + 3 * (self.octant >> axis & 1)]);
        let far = |axis: usize| s.load(&node.bounds[axis + 3 * (!self.octant >> axis & 1)]);
        let near = [near(0), near(1), near(2)];
        self.cut(s, near, [far(0), far(1), far(2)], reach)
    }

    /// The triangles of a block that a ray of the beam may hit, as bits.
    #[inline(always)]
    pub(super) fn meets<S: Simd>(&self, s: S, block: &TriangleBlock, reach: f32) -> u32 {
        let (x, y, z) = (
            self.planes(s, block, 0),
            self.planes(s, block, 1),
            self.planes(s, block, 2),
        );
        let (near, far) = self.cut(s, [x.0, y.0, z.0], [x.1, y.1, z.1], reach);
        s.bits(s.le(near, far))
    }

    /// The near and the far planes of the boxes of triangles.
    #[inline(always)]
    fn planes<S: Simd>(&self, s: S, block: &TriangleBlock, axis: usize) -> (S::F, S::F) {
        let corner = |i: usize| s.load(&block.corners[i][axis]);
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let lower = s.min(s.min(a, b), c);
        let upper = s.max(s.max(a, b), c);
        if self.octant >> axis & 1 == 0 {
            (lower, upper)
        } else {
            (upper, lower)
        }
    }

    #[inline(always)]
    fn cut<S: Simd>(&self, s: S, near: [S::F; 3], far: [S::F; 3], reach: f32) -> (S::F, S::F) {
        let mut enter = s.splat(0.0);
        let mut leave = s.splat(f32::INFINITY);
        for axis in 0..3 {
            let (least, most) = (s.splat(self.least[axis]), s.splat(self.most[axis]));
            let slack = s.splat(self.slack[axis]);
            let before = s.sub(near[axis], s.splat(self.first[axis]));
            let t = s.min(s.mul(before, least), s.mul(before, most));
            enter = s.max(enter, s.sub(t, slack));
            let behind = s.sub(far[axis], s.splat(self.last[axis]));
            let t = s.max(s.mul(behind, least), s.mul(behind, most));
            leave = s.min(leave, s.add(t, slack));
        }
        let margin = s.splat(FAR_MARGIN * FAR_MARGIN);
        (enter, s.min(s.mul(leave, margin), s.splat(reach)))
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
