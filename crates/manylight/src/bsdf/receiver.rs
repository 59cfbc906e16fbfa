//! A scattering function whose viewer is fixed: what a gathering point evaluates for every light.

use super::bound::Arriving;
use super::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::math::{Spread, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A scattering function seen by one viewer, for sums over many directions of incidence.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'b, 's> {
    bsdf: &'b Bsdf<'s>,
    wo: Vec3,
    lobes: Lobes,
    /// For a plain Lambertian surface: `f`, to be multiplied by the cosine on the viewer's side.
    lambert: Option<Rgb>,
}

impl Receiver<'_, '_> {
    /// [`Bsdf::f_cos_wi`] for this viewer and set of lobes.
    #[inline]
    pub fn f_cos_wi(&self, wi: Vec3) -> Rgb {
        if let Some(f) = self.lambert {
            let cos = self.bsdf.frame.n.dot(wi) * 1.0f32.copysign(self.wo.z);
            return f * cos.max(0.0);
        }
        self.bsdf
            .eval_local(self.bsdf.frame.to_local(wi), self.wo, self.lobes)
    }

    /// Upper bound of every channel of [`Receiver::f_cos_wi`] for directions so far from the unit vector `axis`.
    pub(super) fn bound(&self, axis: Vec3, spread: Spread) -> f32 {
        let arriving = Arriving {
            axis: self.bsdf.frame.to_local(axis),
            spread,
            projected: None,
        };
        self.bsdf.bound_local(&arriving, self.wo, self.lobes)
    }
}

impl<'s> Bsdf<'s> {
    /// The function of `wi` that is left when the viewer is fixed; see [`Receiver`].
    #[inline]
    pub fn receiver(&self, wo: Vec3, lobes: Lobes) -> Receiver<'_, 's> {
        let wo = self.frame.to_local(wo);
        let lambert = self
            .plain_lambert(wo)
            .filter(|_| lobes.has(Lobes::DIFFUSE))
            .map(|lambert| lambert.albedo * FRAC_1_PI);
        Receiver {
            bsdf: self,
            wo,
            lobes,
            lambert,
        }
    }
}
