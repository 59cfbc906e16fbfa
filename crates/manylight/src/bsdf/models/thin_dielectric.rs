//! A thin dielectric pane: two interfaces without a visible offset by refraction.

use super::fresnel;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width};

/// Mirror reflection on both sides, and straight-through transmission.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct ThinDielectric<S: Width> {
    pub eta: f32,
    pub reflection_tint: Color<S>,
    pub transmission_tint: Color<S>,
}

impl<S: Width> ThinDielectric<S> {
    /// Reflectance with all internal reflections: r + t r t + t r³ t + ... = 2r / (1 + r).
    #[inline(always)]
    fn reflectance(&self, cos: Float<S>) -> Float<S> {
        let r = fresnel::dielectric(cos.abs(), cos.same(self.eta)).reflectance;
        2.0 * r / (1.0 + r)
    }

    /// Straight-through transmittance at the cosine `cos`.
    #[inline(always)]
    pub(in crate::bsdf) fn transmittance(&self, cos: Float<S>) -> Color<S> {
        self.transmission_tint * (1.0 - self.reflectance(cos))
    }
}

impl<S: Width> ScatteringModel<S> for ThinDielectric<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.reflection_tint.r.width(), Lobes::DELTA)
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        self.reflection_tint.max_channel() * self.reflectance(cos)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, _: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let fraction = self.reflection_tint * self.reflectance(given.z);
        let everywhere = Mask::splat(given.z.width(), true);
        ModelSample::mirror(given, fraction, given.z.same(1.0), everywhere)
    }
}

impl ModelBound for ThinDielectric<One> {}
