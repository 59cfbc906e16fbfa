//! Lambertian reflection.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// One-sided Lambertian reflection: `f = ρ / π`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Diffuse {
    pub reflectance: Rgb,
}

impl Diffuse {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        if cos > 0.0 {
            self.reflectance.max_channel()
        } else {
            0.0
        }
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::DIFFUSE) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.reflectance * (wi.z * FRAC_1_PI)
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::DIFFUSE) || wo.z <= 0.0 {
            return 0.0;
        }
        let [_, cos] = incident.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        self.reflectance.max_channel() * incident.projection(cos) * FRAC_1_PI
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, _lobes: Lobes) -> f32 {
        if given.z <= 0.0 {
            0.0
        } else {
            warp::cosine_hemisphere_pdf(other.z)
        }
    }

    #[inline]
    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        (given.z > 0.0).then(|| ModelSample::finite(warp::cosine_hemisphere(u.direction)))
    }

    #[inline]
    pub(in crate::bsdf) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z > 0.0 {
            self.reflectance
        } else {
            Rgb::BLACK
        }
    }
}
