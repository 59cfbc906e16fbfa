//! A sampled point of an element.

use crate::color::Rgb;
use crate::math::Vec3;

/// A point of an element, sampled as seen from a receiver.
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
