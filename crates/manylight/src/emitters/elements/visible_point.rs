//! Sampled points of elements.

use crate::color::Rgb;
use crate::lanes::{Color, Float, LANES, Mask, Vector, Width};
use crate::math::Vec3;

/// A point of an element, sampled as seen from a receiver.
#[derive(Clone, Copy)]
pub(in crate::emitters) struct VisiblePoint {
    /// Unit direction from the receiver to the point.
    pub(in crate::emitters) wi: Vec3,
    /// The point, moved off the surface.
    pub(in crate::emitters) target: Vec3,
    /// Density per solid angle.
    pub(in crate::emitters) pdf: f32,
    /// Radiance towards the receiver.
    pub(in crate::emitters) radiance: Rgb,
}

/// A [`VisiblePoint`] per lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct VisiblePoints<S: Width> {
    pub(in crate::emitters) wi: Vector<S>,
    pub(in crate::emitters) target: Vector<S>,
    /// As of single points. Of points without extent, the squared distance in m², with the radiant
    /// intensity in W/sr in `radiance`.
    pub(in crate::emitters) pdf: Float<S>,
    pub(in crate::emitters) radiance: Color<S>,
    /// The lanes with a point that emits towards the receiver.
    pub(in crate::emitters) valid: Mask<S>,
}

impl<S: Width> VisiblePoints<S> {
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        VisiblePoints {
            wi: Vector::splat(s, Vec3::ZERO),
            target: Vector::splat(s, Vec3::ZERO),
            pdf: Float::splat(s, 1.0),
            radiance: Color::black(s),
            valid: Mask::splat(s, false),
        }
    }

    /// `point(i)` in the lanes `i` of `lanes`.
    #[inline(always)]
    pub(super) fn each(lanes: Mask<S>, point: impl Fn(usize) -> Option<VisiblePoint>) -> Self {
        let s = lanes.width();
        let mut points = [None; LANES];
        for i in crate::simd::set_bits(lanes.bits()) {
            points[i % LANES] = point(i);
        }
        let valid = s.each(|i| points[i].is_some());
        let bits = (0..S::LANES).map(|i| u32::from(valid.as_ref()[i]) << i);
        VisiblePoints {
            wi: Vector::from_fn(s, |i| points[i].map_or(Vec3::ZERO, |y| y.wi)),
            target: Vector::from_fn(s, |i| points[i].map_or(Vec3::ZERO, |y| y.target)),
            pdf: Float::from_fn(s, |i| points[i].map_or(1.0, |y| y.pdf)),
            radiance: Color::from_fn(s, |i| points[i].map_or(Rgb::BLACK, |y| y.radiance)),
            valid: Mask::from_bits(s, bits.sum()),
        }
    }

    /// `a` in the lanes of `m`, `b` elsewhere.
    #[inline(always)]
    pub(super) fn select(m: Mask<S>, a: Self, b: Self) -> Self {
        VisiblePoints {
            wi: Vector::select(m, a.wi, b.wi),
            target: Vector::select(m, a.target, b.target),
            pdf: m.select(a.pdf, b.pdf),
            radiance: Color::select(m, a.radiance, b.radiance),
            valid: (m & a.valid) | (!m & b.valid),
        }
    }
}
