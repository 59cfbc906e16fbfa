//! Lambertian transmission, as of thin leaves and paper.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// Diffuse transmission in both directions: `f = τ / π` for directions on opposite sides. Its class is `GLOSSY`, because `DIFFUSE` lobes
/// reflect.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct DiffuseTransmitter {
    pub transmittance: Rgb,
}

impl DiffuseTransmitter {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, _cos: f32, _lobes: Lobes) -> f32 {
        self.transmittance.max_channel()
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::GLOSSY
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::GLOSSY) || wi.z * wo.z >= 0.0 {
            return Rgb::BLACK;
        }
        self.transmittance * (wi.z.abs() * FRAC_1_PI)
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::GLOSSY) || wo.z == 0.0 {
            return 0.0;
        }
        let side = -1.0f32.copysign(wo.z);
        let opposite = incident.map(|w| Vec3::new(w.x, w.y, w.z * side));
        let [_, cos] = opposite.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        self.transmittance.max_channel() * opposite.projection(cos) * FRAC_1_PI
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, _lobes: Lobes) -> f32 {
        if given.z * other.z >= 0.0 {
            0.0
        } else {
            warp::cosine_hemisphere_pdf(other.z.abs())
        }
    }

    #[inline]
    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        let mut w = warp::cosine_hemisphere(u.direction);
        w.z *= -1.0f32.copysign(given.z);
        Some(ModelSample::finite(w))
    }
}
