//! A thin dielectric pane: two interfaces without a visible offset by refraction.

use super::fresnel;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;

/// Mirror reflection on both sides, and straight-through transmission.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct ThinDielectric {
    pub eta: f32,
    pub reflection_tint: Rgb,
    pub transmission_tint: Rgb,
}

impl ThinDielectric {
    /// Reflectance with all internal reflections: r + t r t + t r³ t + ... = 2r / (1 + r).
    #[inline]
    fn reflectance(&self, cos: f32) -> f32 {
        let r = fresnel::dielectric(cos.abs(), self.eta).reflectance;
        2.0 * r / (1.0 + r)
    }

    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        self.reflection_tint.max_channel() * self.reflectance(cos)
    }

    /// Straight-through transmittance at the cosine `cos`.
    #[inline]
    pub(in crate::bsdf) fn transmittance(&self, cos: f32) -> Rgb {
        self.transmission_tint * (1.0 - self.reflectance(cos))
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DELTA
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, _wi: Vec3, _wo: Vec3, _lobes: Lobes) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, _arriving: &IncidentCone, _wo: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, _given: Vec3, _other: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    #[inline]
    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        _u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        let fraction = self.reflection_tint * self.reflectance(given.z);
        Some(ModelSample::mirror(given, fraction, 1.0))
    }
}
