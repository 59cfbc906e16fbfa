//! Lambertian transmission, as of thin leaves and paper, with or without a dielectric interface.
//!
//! Source of the interface: KHR_materials_diffuse_transmission, where the transmission is a base
//! under the interface as diffuse reflection is.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::models::fresnel;
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, Mask, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes,
};
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Index of refraction of a clear coat.
const COAT_ETA: f32 = 1.5;

/// Diffuse transmission in both directions: `f = τ / π` for directions on opposite sides, times
/// what passes the layers. Its class is `GLOSSY`, because `DIFFUSE` lobes reflect.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct DiffuseTransmitter<S: Width> {
    pub transmittance: Color<S>,
    /// Index of refraction of the interface; 1: none.
    pub eta: f32,
    /// Weight of the clear coat.
    pub coat: Float<S>,
}

in_lanes!(DiffuseTransmitter { transmittance, coat; eta });

impl<S: Width> DiffuseTransmitter<S> {
    /// Without layers.
    #[inline(always)]
    pub(in crate::bsdf) fn plain(transmittance: Color<S>) -> Self {
        DiffuseTransmitter {
            transmittance,
            eta: 1.0,
            coat: transmittance.r.same(0.0),
        }
    }

    /// Fraction of light that passes the interface at the cosine `cos` to a facet.
    #[inline(always)]
    fn passing(&self, cos: Float<S>) -> Float<S> {
        fresnel::coat_transmittance(cos, self.eta)
    }

    /// Fraction of light that passes the coat at the cosine `cos` >= 0 to the surface normal.
    #[inline(always)]
    fn coat_passing(&self, cos: Float<S>) -> Float<S> {
        1.0 - self.coat * (1.0 - fresnel::coat_transmittance(cos, COAT_ETA))
    }
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
        let mut passing = pdf;
        if self.eta != 1.0 {
            let mirrored = wi.scale_z(wi.z.same(-1.0));
            passing = passing * self.passing(0.5 * (mirrored + wo).length());
        }
        if self.coat.gt(0.0).any() {
            passing = passing * self.coat_passing(wi.z.abs()) * self.coat_passing(wo.z.abs());
        }
        let values = ByClass {
            glossy: self.transmittance * passing,
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
        // Both layers pass more light at larger cosines.
        let above = Vec3::new(wo.x, wo.y, wo.z.abs());
        let [_, facing] = opposite.halves(above).cosines;
        let passing = self.passing(facing.into())
            * self.coat_passing(cos.into())
            * self.coat_passing(above.z.into());
        let transmittance = self.transmittance.max_channel() * passing;
        transmittance.get() * opposite.projection(cos) * FRAC_1_PI
    }
}
