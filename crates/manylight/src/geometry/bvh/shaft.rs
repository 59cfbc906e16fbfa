//! Intersection of boxes with shafts, the convex hulls of two boxes.
//!
//! The hull of the boxes A and B is the union of the boxes `(1 - t) A + t B` over `t` in [0, 1]. A
//! third box meets the hull if for some `t` it overlaps that box along each axis. Each of the six
//! conditions bounds `t` on one side. This is the slab test of a ray with two lines per axis in
//! place of one. Own derivation; exact for boxes.

use crate::lanes::{Float, LANES, Sixteen};
use crate::math::{Aabb, Vec3};
use crate::simd::{NARROW, Simd};

/// Smallest difference between two planes, relative to the largest coordinate. Far below rounding;
/// keeps reciprocals finite.
const NEGLIGIBLE: f32 = 1e-10;

/// Margin for the rounding of bounds on `t`, absolute, since only bounds from 0 to 1 matter.
const SLACK: f32 = 8.0 * f32::EPSILON;

/// Margin for the rounding of the shift, relative to it.
const SHIFT_MARGIN: f32 = 2.0 * f32::EPSILON;

/// One shaft, tested against eight boxes at once.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct Shaft {
    /// By plane of the third box, in the order of
    /// [`WideNode::bounds`](super::node::WideNode::bounds): the bound on `t` is
    /// `plane * scale - shift`.
    scale: [f32; 6],
    shift: [f32; 6],
    /// Whether the bound is a lower bound.
    is_near: [bool; 6],
}

impl Shaft {
    /// The hull of two boxes.
    pub(in crate::geometry) fn new(a: Aabb, b: Aabb) -> Self {
        let tiny = negligible(a, b);
        let mut shaft = Shaft {
            scale: [0.0; 6],
            shift: [0.0; 6],
            is_near: [false; 6],
        };
        for axis in 0..3 {
            // The upper side of the hull must reach the lower plane of the box, the lower side of
            // the hull its upper plane.
            shaft.bound(axis, a.max[axis], b.max[axis], tiny, true);
            shaft.bound(axis + 3, a.min[axis], b.min[axis], tiny, false);
        }
        shaft
    }

    fn bound(&mut self, plane: usize, a: f32, b: f32, tiny: f32, near_if_rising: bool) {
        let d = b - a + 0.0;
        let scale = 1.0 / d.abs().max(tiny).copysign(d);
        let is_near = (d >= 0.0) == near_if_rising;
        let shift = a * scale;
        let margin = shift.abs() * SHIFT_MARGIN;
        self.scale[plane] = scale;
        self.shift[plane] = if is_near {
            shift + margin
        } else {
            shift - margin
        };
        self.is_near[plane] = is_near;
    }

    /// For each box the bounds on `t` within [0, 1], and the boxes that meet the shaft, as bits.
    /// Unused lanes of a node never do.
    #[inline(always)]
    pub(super) fn cut<S: Simd>(
        &self,
        s: S,
        bounds: &[[f32; NARROW]; 6],
    ) -> (Float<S>, Float<S>, u32) {
        let (mut near, mut far) = (Float::splat(s, 0.0), Float::splat(s, 1.0));
        for (plane, bounds) in bounds.iter().enumerate() {
            let t = Float::load(s, bounds).mul_sub(self.scale[plane], self.shift[plane]);
            if self.is_near[plane] {
                near = t.max(near);
            } else {
                far = t.min(far);
            }
        }
        let met = near.le(far + SLACK).bits();
        (near, far, met)
    }
}

fn negligible(a: Aabb, b: Aabb) -> f32 {
    let all = a.union(b);
    let size = all.min.abs().max(all.max.abs()).max_element();
    (size * NEGLIGIBLE).max(f32::MIN_POSITIVE)
}

/// Sixteen shafts, tested against one box at once.
pub(super) struct Shafts {
    scale: [[f32; LANES]; 6],
    /// Shift of lower bounds; infinite for upper bounds, which then have no effect.
    near_shift: [[f32; LANES]; 6],
    /// Shift of upper bounds; infinite for lower bounds.
    far_shift: [[f32; LANES]; 6],
}

impl Shafts {
    /// The shaft between `a[i]` and `b[j]` is in lane `4 i + j`. `all` are the bounds of all `a`,
    /// and of all `b`.
    #[inline(always)]
    pub(super) fn new<S: Sixteen>(s: S, a: &[Aabb; 4], b: &[Aabb; 4], all: (Aabb, Aabb)) -> Self {
        let tiny = negligible(all.0, all.1);
        let mut shafts = Shafts {
            scale: [[0.0; LANES]; 6],
            near_shift: [[f32::INFINITY; LANES]; 6],
            far_shift: [[f32::NEG_INFINITY; LANES]; 6],
        };
        for plane in 0..6 {
            let axis = plane % 3;
            let near_if_rising = plane < 3;
            let (mut from, mut to) = ([0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let (a, b) = (&a[lane / 4], &b[lane % 4]);
                let side = |b: &Aabb| {
                    if near_if_rising {
                        b.max[axis]
                    } else {
                        b.min[axis]
                    }
                };
                (from[lane], to[lane]) = (side(a), side(b));
            }
            let from = Float::load(s, &from);
            let d = Float::load(s, &to) - from + 0.0;
            let scale = 1.0 / d.abs().max(tiny).mul_sign(d);
            let shift = from * scale;
            let margin = shift.abs() * SHIFT_MARGIN;
            let raised = (shift + margin).store();
            let lowered = (shift - margin).store();
            let falling = d.lt(0.0).bits();
            shafts.scale[plane] = scale.store();
            for lane in 0..LANES {
                let rising = falling >> lane & 1 == 0;
                if rising == near_if_rising {
                    shafts.near_shift[plane][lane] = raised[lane];
                } else {
                    shafts.far_shift[plane][lane] = lowered[lane];
                }
            }
        }
        shafts
    }

    /// The shafts that meet the box with these lower x, y, z, upper x, y, z.
    #[inline(always)]
    pub(super) fn meeting<S: Sixteen>(&self, s: S, bounds: [f32; 6]) -> u32 {
        let (mut near, mut far) = (Float::splat(s, 0.0), Float::splat(s, 1.0));
        for (plane, &bound) in bounds.iter().enumerate() {
            let (bound, scale) = (Float::splat(s, bound), Float::load(s, &self.scale[plane]));
            let near_shift = Float::load(s, &self.near_shift[plane]);
            let far_shift = Float::load(s, &self.far_shift[plane]);
            near = near.max(bound.mul_sub(scale, near_shift));
            far = far.min(bound.mul_sub(scale, far_shift));
        }
        near.le(far + SLACK).bits()
    }
}

/// Center and half extents of a box. The half extents cover the box despite the rounding of the
/// center.
#[inline(always)]
pub(super) fn middle_and_half(b: &Aabb) -> (Vec3, Vec3) {
    let middle = b.center();
    (middle, (b.max - middle).max(middle - b.min))
}
