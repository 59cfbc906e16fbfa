//! A scattering function with a fixed outgoing direction, for sums over many lights at a gather
//! point.

use super::incident_cone::IncidentCone;
use super::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::math::{Spread, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A scattering function with a fixed `wo` and a fixed set of lobes: a function of `wi`.
#[derive(Clone, Copy, Debug)]
pub struct FixedWo<'b, 's> {
    bsdf: &'b Bsdf<'s>,
    /// In the shading frame.
    wo: Vec3,
    lobes: Lobes,
    /// For a plain Lambertian surface: `f`, a constant on the side of `wo`.
    lambert: Option<Rgb>,
}

impl<'b, 's> FixedWo<'b, 's> {
    /// `bsdf` for a fixed `wo` and set of lobes.
    #[inline]
    pub fn new(bsdf: &'b Bsdf<'s>, wo: Vec3, lobes: Lobes) -> Self {
        let wo = bsdf.frame.to_local(wo.into());
        let lambert = bsdf
            .plain_lambert(wo)
            .filter(|_| lobes.has(Lobes::DIFFUSE))
            .map(|lambert| Rgb::from(lambert.albedo.within(lambert.valid)) * FRAC_1_PI);
        FixedWo {
            bsdf,
            wo: wo.into(),
            lobes,
            lambert,
        }
    }

    /// `f` in 1/sr on the side of `wo`, if that is a constant.
    #[inline]
    pub(crate) fn lambert(&self) -> Option<Rgb> {
        self.lambert
    }

    /// [`Bsdf::f_cos_wi`] for this `wo` and these lobes.
    #[inline]
    pub fn f_cos_wi(&self, wi: Vec3) -> Rgb {
        if let Some(f) = self.lambert {
            let n = Vec3::from(self.bsdf.frame.n);
            let cos = n.dot(wi) * 1.0f32.copysign(self.wo.z);
            return f * cos.max(0.0);
        }
        let wi = self.bsdf.frame.to_local(wi.into());
        let values = self
            .bsdf
            .values_local(wi, self.wo.into(), self.lobes.into());
        values.sum().into()
    }

    /// Upper bound of all channels of [`FixedWo::f_cos_wi`] over the cone around the unit vector
    /// `axis`.
    #[inline]
    pub(crate) fn bound(&self, axis: Vec3, spread: Spread) -> f32 {
        let incident = IncidentCone {
            axis: self.bsdf.frame.to_local(axis.into()).into(),
            spread,
            projected: None,
        };
        self.bsdf.bound_local(&incident, self.wo, self.lobes)
    }
}
