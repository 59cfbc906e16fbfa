//! Metals.

use super::bound::Arriving;
use super::fresnel::{Metal, reflect};
use super::microfacet::Microfacets;
use super::model::{ModelSample, microfacet_class};
use super::response::{ByClass, Response};
use super::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;

/// A smooth, one-sided metal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mirror {
    pub metal: Metal,
    pub tint: Rgb,
}

impl Mirror {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::DELTA
    }

    #[inline]
    pub(super) fn eval(&self, _wi: Vec3, _wo: Vec3, _lobes: Lobes) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    pub(super) fn bound(&self, _arriving: &Arriving, _wo: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    #[inline]
    pub(super) fn pdf(&self, _given: Vec3, _other: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    #[inline]
    pub(super) fn sample(
        &self,
        given: Vec3,
        _u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        (given.z > 0.0)
            .then(|| ModelSample::mirror(given, self.metal.reflectance(given.z) * self.tint, 1.0))
    }
}

/// A rough, one-sided metal: `f = F D G / (4 cosθ_i cosθ_o)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughConductor {
    pub facets: Microfacets,
    pub metal: Metal,
    pub tint: Rgb,
}

impl RoughConductor {
    #[inline]
    pub(super) fn alpha(&self) -> f32 {
        self.facets.min_alpha()
    }

    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.respond(wi, wo, lobes).values.sum()
    }

    /// See [`Model::respond`](super::model::Model::respond).
    #[inline]
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        if !lobes.has(self.lobes()) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Response::NONE;
        }
        let m = (wi + wo).normalize();
        let pdf = self.facets.reflected_pdf(wo, m);
        let tint = self.metal.reflectance(wo.dot(m)) * self.tint;
        let mut values = ByClass::BLACK;
        values[self.lobes()] = tint * (pdf * self.facets.masking(wi, m));
        Response { values, pdf }
    }

    #[inline]
    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = arriving.cosines();
        if !lobes.has(self.lobes()) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let halves = arriving.halves(wo);
        let f = (self.metal.bound(halves.cosines) * self.tint).max_channel();
        f * self.facets.projected_bound(halves.highest, arriving) * self.facets.seen(wo)
    }

    #[inline]
    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes()) || given.z <= 0.0 || other.z <= 0.0 {
            return 0.0;
        }
        self.facets
            .reflected_pdf(given, (given + other).normalize())
    }

    #[inline]
    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, _lobes: Lobes) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let w = reflect(given, self.facets.sample(given, u.direction));
        (w.z > 0.0).then(|| ModelSample::finite(w))
    }
}
