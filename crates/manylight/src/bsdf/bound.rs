//! Upper bounds of what a surface reflects of light from all directions in a cone: what a cut through a tree of lights asks. Every model has
//! its own beside its value.

use super::{Bsdf, Lobes};
use crate::math::{Cone, Spread, Vec3, float::safe_sqrt};

/// Where directions lie farther apart than twice the angle with this cosine, the half vector may be any.
const LEAST_COSINE: f32 = 0.08;

/// Light that may arrive from every direction in a cone; in the frame of a model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arriving {
    pub(super) axis: Vec3,
    pub(super) spread: Spread,
    /// The largest cosine by which `f` counts, if that is not the one to the normal of the model.
    pub(super) projected: Option<f32>,
}

/// The unit half vectors between one direction and those in a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves {
    /// Largest cosine to the normal.
    pub(super) highest: f32,
    /// Smallest and largest cosine of the angle to either direction.
    pub(super) cosines: [f32; 2],
}

impl Arriving {
    /// The same in a frame to which `change` brings directions.
    pub(super) fn map(self, change: impl FnOnce(Vec3) -> Vec3) -> Self {
        Arriving {
            axis: change(self.axis),
            ..self
        }
    }

    /// Smallest and largest cosine to the normal.
    #[inline(always)]
    pub(super) fn cosines(&self) -> [f32; 2] {
        self.spread.cosines(self.axis.z)
    }

    /// Upper bound of the cosine by which `f` counts, where that to the normal is at most `highest`.
    #[inline(always)]
    pub(super) fn projection(&self, highest: f32) -> f32 {
        self.projected.unwrap_or(highest)
    }

    /// Smallest and largest cosine to the unit vector `w`.
    #[inline(always)]
    pub(super) fn cosines_to(&self, w: Vec3) -> [f32; 2] {
        self.spread.cosines(self.axis.dot(w))
    }

    /// Half vectors with `wo`. They move by no more than `δ / (2 cosθ_d)` where a direction moves by `δ`, `2 θ_d` being the angle between
    /// the two (derived: half as far in their common plane, and that across it).
    #[inline(always)]
    pub(super) fn halves(&self, wo: Vec3) -> Halves {
        let cosines = self.cosines_to(wo).map(|cos| safe_sqrt(0.5 + 0.5 * cos));
        let half = self.axis + wo;
        let cos = half.z / half.length_squared().sqrt();
        let moved = self.spread.half_angle / (2.0 * cosines[0]);
        // Taylor's polynomials, each on the safe side of the sine or cosine of the angle moved.
        let moved2 = moved * moved;
        let least = 1.0 - 0.5 * moved2;
        let most = least + moved2 * moved2 * (1.0 / 24.0);
        let along = if cos > 0.0 { most } else { least };
        let highest = cos * along + safe_sqrt(1.0 - cos * cos) * moved;
        let any = cosines[0] < LEAST_COSINE || cos >= least || highest > 1.0;
        Halves {
            highest: if any { 1.0 } else { highest },
            cosines,
        }
    }
}

impl Bsdf<'_> {
    /// Upper bound, over all channels and all directions `wi` in `cone`, of [`Bsdf::f_cos_wi`]; infinite for transmission without refraction.
    pub fn bound_f_cos_wi(&self, cone: &Cone, wo: Vec3, lobes: Lobes) -> f32 {
        let arriving = Arriving {
            axis: self.frame.to_local(cone.axis),
            spread: Spread::new(cone.half_angle),
            projected: None,
        };
        self.bound_local(&arriving, self.frame.to_local(wo), lobes)
    }

    /// The same for local directions.
    pub(super) fn bound_local(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        let leaves = self.leaves.iter().map_while(Option::as_ref);
        leaves.map(|leaf| leaf.bound(arriving, wo, lobes)).sum()
    }

    /// The same of [`Bsdf::f_cos_wo`] of the smooth lobes over directions `wo` in `cone`: models are reciprocal, and light that leaves counts by the
    /// geometric normal. Infinite where light is refracted.
    pub fn bound_f_cos_wo(&self, wi: Vec3, cone: &Cone) -> f32 {
        if self.transmits {
            return f32::INFINITY;
        }
        let spread = Spread::new(cone.half_angle);
        let [lowest, highest] = spread.cosines(cone.axis.dot(self.ng));
        let is_flat = self.frame.n == self.ng || self.frame.n == -self.ng;
        let leaving = Arriving {
            axis: self.frame.to_local(cone.axis),
            spread,
            projected: (!is_flat).then_some(highest.max(-lowest)),
        };
        let local = self.frame.to_local(wi);
        let leaves = self.leaves.iter().map_while(Option::as_ref);
        let sum: f32 = leaves
            .map(|leaf| leaf.bound_leaving(local, &leaving, Lobes::NON_SPECULAR))
            .sum();
        sum / wi.dot(self.ng).abs()
    }
}
