//! Conductors.

use super::fresnel::{ConductorFresnel, reflect};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;

/// Lower bound of the reflectance of rough surfaces where it is estimated at the surface normal: facets reflect at other angles.
const MIN_FACET_REFLECTANCE: f32 = 0.05;

/// A smooth, one-sided conductor.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct SmoothConductor {
    pub fresnel: ConductorFresnel,
    pub tint: Rgb,
}

impl SmoothConductor {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        if cos > 0.0 {
            (self.fresnel.reflectance(cos) * self.tint).max_channel()
        } else {
            0.0
        }
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
        (given.z > 0.0)
            .then(|| ModelSample::mirror(given, self.fresnel.reflectance(given.z) * self.tint, 1.0))
    }
}

/// A rough, one-sided conductor: `f = F D G / (4 cosθ_i cosθ_o)`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughConductor {
    pub facets: Microfacets,
    pub fresnel: ConductorFresnel,
    pub tint: Rgb,
}

impl RoughConductor {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        if cos <= 0.0 {
            return 0.0;
        }
        let f = self.fresnel.reflectance(cos);
        (f.zip(Rgb::splat(MIN_FACET_REFLECTANCE), f32::max) * self.tint).max_channel()
    }

    #[inline]
    pub(in crate::bsdf) fn alpha(&self) -> f32 {
        self.facets.min_alpha()
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.respond(wi, wo, lobes).values.sum()
    }

    /// See [`Model::respond`](crate::bsdf::model::Model::respond).
    #[inline]
    pub(in crate::bsdf) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        if !lobes.has(self.lobes()) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Response::NONE;
        }
        let m = (wi + wo).normalize();
        let pdf = self.facets.reflected_pdf(wo, m);
        let tint = self.fresnel.reflectance(wo.dot(m)) * self.tint;
        let mut values = ByClass::BLACK;
        values[self.lobes()] = tint * (pdf * self.facets.masking(wi, m));
        Response { values, pdf }
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if !lobes.has(self.lobes()) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let halves = incident.halves(wo);
        let f = (self.fresnel.bound(halves.cosines) * self.tint).max_channel();
        f * self.facets.projected_bound(halves.highest, incident) * self.facets.seen(wo)
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes()) || given.z <= 0.0 || other.z <= 0.0 {
            return 0.0;
        }
        self.facets
            .reflected_pdf(given, (given + other).normalize())
    }

    #[inline]
    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let w = reflect(given, self.facets.sample(given, u.direction));
        (w.z > 0.0).then(|| ModelSample::finite(w))
    }
}
