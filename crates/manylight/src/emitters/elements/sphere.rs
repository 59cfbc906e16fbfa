//! Sampling of a sphere by the solid angle of its visible cap.

use super::visible_point::VisiblePoint;
use crate::color::Rgb;
use crate::math::trig::sin_cos_turns;
use crate::math::{Frame, Vec2, Vec3};
use std::f32::consts::TAU;

/// The cone of directions from a point outside a sphere to the sphere.
pub(super) struct SphereCone {
    p: Vec3,
    center: Vec3,
    radius: f32,
    offset: f32,
    distance: f32,
    one_minus_cos: f32,
}

impl SphereCone {
    /// The cone seen from `p`. `offset` is the distance by which points are moved off the sphere. `None` inside and within
    /// `offset` of the surface, where the cone is not defined or inaccurate.
    pub(super) fn new(center: Vec3, radius: f32, offset: f32, p: Vec3) -> Option<Self> {
        let to_center = center - p;
        let d2 = to_center.length_squared();
        if d2 <= (radius + offset) * (radius + offset) {
            return None;
        }
        let sin2 = radius * radius / d2;
        // 1 - cos without cancellation, for spheres that are small or far away.
        let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
        Some(SphereCone {
            p,
            center,
            radius,
            offset,
            distance: d2.sqrt(),
            one_minus_cos,
        })
    }

    /// Density of [`SphereCone::sample`] per solid angle.
    pub(super) fn pdf(&self) -> f32 {
        1.0 / (TAU * self.one_minus_cos)
    }

    /// The point in a uniform direction of the cone.
    pub(super) fn sample(&self, radiance: Rgb, u: Vec2) -> VisiblePoint {
        let axis = (self.center - self.p) / self.distance;
        let drop = u.y * self.one_minus_cos;
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).sqrt());
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        let wi = Frame::from_normal(axis)
            .to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
            .normalize();
        // The nearer of the two intersections of the ray with the sphere.
        let half_chord2 = self.radius * self.radius - (self.distance * sin).powi(2);
        let y = self.p + wi * (self.distance * cos - half_chord2.max(0.0).sqrt());
        let n = (y - self.center).normalize();
        let target = self.center + n * (self.radius + self.offset);
        VisiblePoint {
            wi,
            target,
            pdf: self.pdf(),
            radiance,
        }
    }
}
