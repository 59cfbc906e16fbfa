//! Cones of directions, as arguments of upper bounds.

use crate::math::{Spread, Vec3, float::safe_sqrt};
use crate::simd::array;

/// Cosine of half the angle between two nearly opposite directions: below it any half vector counts
/// as possible, because half vectors move without bound there. At 0.04 and 0.16, the pixel variance
/// of `rich-lightcuts` in three scenes is the same to .1 %, and the time within its noise.
const MIN_HALF_COSINE: f32 = 0.08;

/// A cone of directions of incidence, in the frame of a model.
#[derive(Clone, Copy, Debug)]
pub(super) struct IncidentCone {
    /// Unit axis.
    pub(super) axis: Vec3,
    /// Half-angle.
    pub(super) spread: Spread,
    /// Largest value of the cosine by which `f` is multiplied, if that is not the cosine to the
    /// normal of the model.
    pub(super) projected: Option<f32>,
}

/// Bounds on the unit half vectors between one direction and the directions of a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfVectorBounds {
    /// Largest cosine to the normal.
    pub(super) highest: f32,
    /// Smallest and largest cosine between a half vector and its two directions.
    pub(super) cosines: [f32; 2],
}

impl IncidentCone {
    /// The cone in another frame; `change` transforms directions to it.
    #[inline]
    pub(super) fn map(self, change: impl FnOnce(Vec3) -> Vec3) -> Self {
        IncidentCone {
            axis: change(self.axis),
            ..self
        }
    }

    /// Smallest and largest cosine to the normal.
    #[inline(always)]
    pub(super) fn cosines(&self) -> [f32; 2] {
        self.spread.cosines(self.axis.z)
    }

    /// Upper bound of the cosine by which `f` is multiplied; `highest` is the upper bound of the
    /// cosine to the normal.
    #[inline(always)]
    pub(super) fn projection(&self, highest: f32) -> f32 {
        self.projected.unwrap_or(highest)
    }

    /// Upper bound of the cosine by which `f` is multiplied, of light from above the surface.
    #[inline(always)]
    pub(super) fn projection_above(&self) -> f32 {
        let [_, highest] = self.cosines();
        if highest > 0.0 {
            self.projection(highest)
        } else {
            0.0
        }
    }

    /// Smallest and largest cosine to the unit vector `w`.
    #[inline(always)]
    pub(super) fn cosines_to(&self, w: Vec3) -> [f32; 2] {
        self.spread.cosines(self.axis.dot(w))
    }

    /// Bounds on the half vectors with `wo`. If a direction moves by an angle `δ`, its half vector
    /// moves by at most `δ / (2 cosθ_d)`, where `2 θ_d` is the angle to `wo`: `δ / 2` within the
    /// plane of the two directions, `δ / (2 cosθ_d)` perpendicular to it.
    #[inline(always)]
    pub(super) fn halves(&self, wo: Vec3) -> HalfVectorBounds {
        let to_wo = self.cosines_to(wo);
        let cosines: [f32; 2] = array(|end| safe_sqrt(0.5 + 0.5 * to_wo[end]));
        let half = self.axis + wo;
        let cos = half.z / half.length_squared().sqrt();
        let moved = self.spread.half_angle / (2.0 * cosines[0]);
        // Taylor polynomials: lower and upper bounds of the cosine of the angle `moved`, and an
        // upper bound of its sine.
        let moved2 = moved * moved;
        let least = 1.0 - 0.5 * moved2;
        let most = least + moved2 * moved2 * (1.0 / 24.0);
        let along = if cos > 0.0 { most } else { least };
        let highest = cos * along + safe_sqrt(1.0 - cos * cos) * moved;
        let any = cosines[0] < MIN_HALF_COSINE || cos >= least || highest > 1.0;
        HalfVectorBounds {
            highest: if any { 1.0 } else { highest },
            cosines,
        }
    }
}
