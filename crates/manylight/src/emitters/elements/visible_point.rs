//! Sampled points of elements, in lanes.

use crate::lanes::{Color, Float, Mask, Vector, Width};
use crate::math::Vec3;

/// A point of an element per lane, sampled as seen from a receiver.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct VisiblePoints<S: Width> {
    /// Unit direction from the receiver to the point.
    pub(in crate::emitters) wi: Vector<S>,
    /// The point, moved off the surface.
    pub(in crate::emitters) target: Vector<S>,
    /// Density per solid angle. Of points without extent, the squared distance in m².
    pub(in crate::emitters) pdf: Float<S>,
    /// Radiance towards the receiver in W/(m² sr). Of points without extent, the radiant intensity
    /// in W/sr.
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
