//! Boxes against shafts: what lies between two boxes.
//!
//! The hull of two boxes A and B is made of the boxes `(1 - t) A + t B`. So a third box meets the hull if for some `t` in [0, 1]
//! it overlaps that box along each axis, and each of the six conditions bounds `t` from one side: this is the slab test of a
//! ray, with two lines per axis instead of one. Derived; exact for boxes.

use crate::math::{Aabb, Vec3};
use crate::simd::{Floats, NARROW, Simd, WIDE};

/// Differences smaller than this, relative to coordinates, count as this: far below rounding, yet no reciprocal overflows.
const NEGLIGIBLE: f32 = 1e-10;

/// Outweighs the rounding of bounds on `t`, which matter between 0 and 1.
const SLACK: f32 = 8.0 * f32::EPSILON;

/// Outweighs the rounding of the shift, relative to it.
const SHIFT_MARGIN: f32 = 2.0 * f32::EPSILON;

/// One shaft, to test eight boxes at once.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct Shaft {
    /// By plane of the third box, in the order of a node's bounds: `t` is bounded by `plane * scale - shift`.
    scale: [f32; 6],
    shift: [f32; 6],
    /// Whether the bound is a lower one.
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
            // The upper side of the hull must not stay below the lower plane, nor its lower side above the upper plane.
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

    /// The part of [0, 1] where the shaft may meet the boxes, and the boxes that it does meet: never an empty place of a node.
    #[inline(always)]
    pub(super) fn cut<S: Simd>(&self, s: S, bounds: &[[f32; NARROW]; 6]) -> (S::F, S::F, u32) {
        let (mut near, mut far) = (s.splat(0.0), s.splat(1.0));
        for (plane, bounds) in bounds.iter().enumerate() {
            let t = s.mul_sub(
                s.load(bounds),
                s.splat(self.scale[plane]),
                s.splat(self.shift[plane]),
            );
            if self.is_near[plane] {
                near = s.max(t, near);
            } else {
                far = s.min(t, far);
            }
        }
        let met = s.bits(s.le(near, s.add(far, s.splat(SLACK))));
        (near, far, met)
    }
}

fn negligible(a: Aabb, b: Aabb) -> f32 {
    let all = a.union(b);
    let size = all.min.abs().max(all.max.abs()).max_element();
    (size * NEGLIGIBLE).max(f32::MIN_POSITIVE)
}

/// Sixteen shafts, to test one box against all.
pub(super) struct Shafts {
    scale: [[f32; WIDE]; 6],
    /// Infinite where the bound is an upper one, so that it never counts as a lower one.
    near_shift: [[f32; WIDE]; 6],
    /// The other way round.
    far_shift: [[f32; WIDE]; 6],
}

impl Shafts {
    /// Between `a[i]` and `b[j]` in lane `4 i + j`.
    #[inline(always)]
    pub(super) fn new<S: Simd>(s: S, a: &[Aabb; 4], b: &[Aabb; 4], all: (Aabb, Aabb)) -> Self {
        let w = s.wide();
        let tiny = w.splat(negligible(all.0, all.1));
        let mut shafts = Shafts {
            scale: [[0.0; WIDE]; 6],
            near_shift: [[f32::INFINITY; WIDE]; 6],
            far_shift: [[f32::NEG_INFINITY; WIDE]; 6],
        };
        for plane in 0..6 {
            let axis = plane % 3;
            let near_if_rising = plane < 3;
            let (mut from, mut to) = ([0.0; WIDE], [0.0; WIDE]);
            for lane in 0..WIDE {
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
            let from = w.load(&from);
            let zero = w.splat(0.0);
            let d = w.add(w.sub(w.load(&to), from), zero);
            let scale = w.div(w.splat(1.0), w.mul_sign(w.max(w.abs(d), tiny), d));
            let shift = w.mul(from, scale);
            let margin = w.mul(w.abs(shift), w.splat(SHIFT_MARGIN));
            let raised = w.store(w.add(shift, margin));
            let lowered = w.store(w.sub(shift, margin));
            let falling = w.bits(w.lt(d, zero));
            shafts.scale[plane] = w.store(scale);
            for lane in 0..WIDE {
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

    /// The shafts that meet a box: its lower x, y, z, upper x, y, z.
    #[inline(always)]
    pub(super) fn meeting<S: Simd>(&self, s: S, bounds: [f32; 6]) -> u32 {
        let w = s.wide();
        let (mut near, mut far) = (w.splat(0.0), w.splat(1.0));
        for (plane, &bound) in bounds.iter().enumerate() {
            let (bound, scale) = (w.splat(bound), w.load(&self.scale[plane]));
            near = w.max(
                near,
                w.mul_sub(bound, scale, w.load(&self.near_shift[plane])),
            );
            far = w.min(far, w.mul_sub(bound, scale, w.load(&self.far_shift[plane])));
        }
        w.bits(w.le(near, w.add(far, w.splat(SLACK))))
    }
}

/// Middle and half the extent.
#[inline(always)]
pub(super) fn middle_and_half(b: &Aabb) -> (Vec3, Vec3) {
    let middle = b.center();
    (middle, (b.max - middle).max(middle - b.min))
}
