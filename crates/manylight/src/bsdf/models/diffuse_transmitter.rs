//! Lambertian transmission, as of thin leaves and paper.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, Mask, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf,
};
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Diffuse transmission in both directions: `f = τ / π` for directions on opposite sides. Its class
/// is `GLOSSY`, because `DIFFUSE` lobes reflect.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct DiffuseTransmitter<S: Width> {
    pub transmittance: Color<S>,
}

impl<S: Width> ScatteringModel<S> for DiffuseTransmitter<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.transmittance.r.width(), Lobes::GLOSSY)
    }

    #[inline(always)]
    fn albedo_estimate(&self, _: Float<S>, _: Classes<S>) -> Float<S> {
        self.transmittance.max_channel()
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let pdf = lobes.glossy.select(self.pdf(wo, wi, lobes), 0.0);
        let values = ByClass {
            glossy: self.transmittance * pdf,
            ..ByClass::black(pdf.width())
        };
        Response { values, pdf }
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, _: Classes<S>) -> Float<S> {
        let crosses = (given.z * other.z).lt(0.0);
        crosses.select(cosine_hemisphere_pdf(other.z.abs()), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let w = cosine_hemisphere(u.direction).scale_z(-given.z.sign());
        ModelSample::finite(w, Mask::splat(given.z.width(), true))
    }

    #[inline(always)]
    fn transmits(&self) -> Mask<S> {
        Mask::splat(self.lobes().glossy.width(), true)
    }
}

impl ModelBound for DiffuseTransmitter<One> {
    #[inline]
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::GLOSSY) || wo.z == 0.0 {
            return 0.0;
        }
        let side = -1.0f32.copysign(wo.z);
        let opposite = incident.map(|w| Vec3::new(w.x, w.y, w.z * side));
        let [_, cos] = opposite.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        self.transmittance.max_channel().get() * opposite.projection(cos) * FRAC_1_PI
    }
}
