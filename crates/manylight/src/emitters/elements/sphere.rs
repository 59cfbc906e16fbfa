//! Sampling of spheres by the solid angle of their visible caps.

use super::sampling::ElementSampling;
use super::visible_point::VisiblePoints;
use crate::lanes::{Axes, Color, Float, Mask, Pair, Vector, Width, Word};
use crate::math::Vec3;
use std::f32::consts::TAU;

/// Spheres as seen from the points `p`: cones of directions.
pub(super) struct SphereCones<S: Width> {
    p: Vector<S>,
    center: Vector<S>,
    radius: Float<S>,
    offset: Float<S>,
    distance: Float<S>,
    one_minus_cos: Float<S>,
    radiance: Color<S>,
    /// The lanes with a cone. There is none inside and within `offset` of the surface, where it is
    /// not defined or inaccurate.
    pub(super) outside: Mask<S>,
}

impl<S: Width> SphereCones<S> {
    /// The cones in the lanes of `lanes`, where all elements are spheres.
    #[inline(always)]
    pub(super) fn load(
        sampling: &[ElementSampling],
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
    ) -> Self {
        let s = p.x.width();
        let zero = p.x.same(0.0);
        let (mut center, mut radius, mut offset) = (Vector::splat(s, Vec3::ZERO), zero, zero);
        let mut radiance = Color::black(s);
        for (i, lanes) in element.groups(lanes) {
            if let ElementSampling::Sphere(of) = &sampling[i as usize] {
                center = Vector::select(lanes, Vector::splat(s, of.center), center);
                radius = lanes.select(of.radius, radius);
                offset = lanes.select(of.offset, offset);
                radiance = Color::select(lanes, Color::splat(s, of.radiance), radiance);
            }
        }
        let d2 = (center - p).length_squared();
        let sin2 = radius * radius / d2;
        SphereCones {
            p,
            center,
            radius,
            offset,
            distance: d2.sqrt(),
            // 1 - cos without cancellation, for spheres that are small or far away.
            one_minus_cos: sin2 / (1.0 + (1.0 - sin2).sqrt()),
            radiance,
            outside: lanes & d2.gt((radius + offset).squared()),
        }
    }

    /// Density of [`SphereCones::sample`] per solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> Float<S> {
        1.0 / (self.one_minus_cos * TAU)
    }

    /// The points in uniform directions of the cones.
    #[inline(always)]
    pub(super) fn sample(&self, u: Pair<S>) -> VisiblePoints<S> {
        let axis = (self.center - self.p) * self.distance.recip();
        let drop = u.y * self.one_minus_cos;
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).safe_sqrt());
        let (sin_phi, cos_phi) = u.x.sin_cos_turns();
        let wi = Axes::from_normal(axis)
            .to_world(Vector::new(sin * cos_phi, sin * sin_phi, cos))
            .normalize();
        // The nearer of the two intersections of the ray with the sphere.
        let half_chord2 = self.radius * self.radius - (self.distance * sin).squared();
        let y = self.p + wi * (self.distance * cos - half_chord2.safe_sqrt());
        let n = (y - self.center).normalize();
        VisiblePoints {
            wi,
            target: self.center + n * (self.radius + self.offset),
            pdf: self.pdf(),
            radiance: self.radiance,
            valid: self.outside,
        }
    }
}
