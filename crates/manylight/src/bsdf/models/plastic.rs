//! A dielectric coat over a Lambertian base, with all interreflections between the two.

use super::coat::{COSINES, Coat, interpolate};
use super::fresnel::{self, reflect};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::response::Response;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// Whether interreflections under the coat change the color of the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bsdf) enum ColorShift {
    /// Yes: each channel loses light by its own albedo.
    Nonlinear,
    /// No: each channel loses light as for an albedo of 1, which is Mitsuba's default.
    Linear,
}

/// Albedo of the base under the coat, without the transmittances of entry and exit: ρ / (η² (1 - ρ r)). `internal` is r, the
/// reflectance of the coat from inside for diffuse light.
fn base_through_coat(reflectance: Rgb, eta: f32, internal: f32, shift: ColorShift) -> Rgb {
    let trapped = match shift {
        ColorShift::Nonlinear => reflectance * internal,
        ColorShift::Linear => Rgb::splat(internal),
    };
    reflectance.zip(trapped, |rho, t| rho / (eta * eta * (1.0 - t)))
}

/// Probability of sampling the coat instead of the base, for the reflectance `r` of the coat.
#[inline]
fn coat_probability(r: f32, coat_share: f32) -> f32 {
    let (coat, base) = (r * coat_share, (1.0 - r) * (1.0 - coat_share));
    if coat + base > 0.0 {
        coat / (coat + base)
    } else {
        1.0
    }
}

/// Albedo of the base with interreflections, without the transmittance of entry: the diffuse transmittance of exit is η² (1 - r).
fn base_albedo(base: Rgb, eta: f32, internal: f32) -> f32 {
    base.max_channel() * (eta * eta * (1.0 - internal))
}

/// The tint's share of the sum of tint and [`base_albedo`].
fn coat_share(tint: Rgb, base_albedo: f32) -> f32 {
    let s = tint.max_channel();
    if s + base_albedo > 0.0 {
        s / (s + base_albedo)
    } else {
        0.5
    }
}

/// Albedo estimate of coat and base where the coat reflects the fraction `r`: `[coat, base]`.
fn albedo_estimates(r: f32, tint: Rgb, base_albedo: f32) -> [f32; 2] {
    [r * tint.max_channel(), (1.0 - r) * base_albedo]
}

/// A smooth coat over a Lambertian base.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Plastic {
    pub eta: f32,
    /// See [`base_through_coat`].
    pub base: Rgb,
    tint: Rgb,
    coat_share: f32,
    base_albedo: f32,
}

impl Plastic {
    pub(in crate::bsdf) fn new(eta: f32, reflectance: Rgb, tint: Rgb, shift: ColorShift) -> Self {
        let internal = fresnel::diffuse_reflectance(1.0 / eta);
        let base = base_through_coat(reflectance, eta, internal, shift);
        let base_albedo = base_albedo(base, eta, internal);
        Plastic {
            eta,
            base,
            tint,
            coat_share: coat_share(tint, base_albedo),
            base_albedo,
        }
    }

    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        if cos <= 0.0 {
            return 0.0;
        }
        let r = fresnel::dielectric(cos, self.eta).reflectance;
        let [coat, base] = albedo_estimates(r, self.tint, self.base_albedo);
        lobes.pick(Lobes::DELTA, coat) + lobes.pick(Lobes::DIFFUSE, base)
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE.or(Lobes::DELTA)
    }

    #[inline]
    fn coat_probability(&self, r: f32, lobes: Lobes) -> f32 {
        match (lobes.has(Lobes::DELTA), lobes.has(Lobes::DIFFUSE)) {
            (true, true) => coat_probability(r, self.coat_share),
            (true, false) => 1.0,
            _ => 0.0,
        }
    }

    #[inline]
    pub(in crate::bsdf) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.base * fresnel::coat_transmittance(wi.z, self.eta)
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::DIFFUSE) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.diffuse_weight(wi) * (fresnel::coat_transmittance(wo.z, self.eta) * wi.z * FRAC_1_PI)
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if !lobes.has(Lobes::DIFFUSE) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let [enters, leaves] = [cos, wo.z].map(|cos| fresnel::coat_transmittance(cos, self.eta));
        let projection = incident.projection(cos);
        self.base.max_channel() * (enters * leaves * projection * FRAC_1_PI)
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z <= 0.0 || other.z <= 0.0 || !lobes.has(Lobes::DIFFUSE) {
            return 0.0;
        }
        let r = fresnel::dielectric(given.z, self.eta).reflectance;
        (1.0 - self.coat_probability(r, lobes)) * warp::cosine_hemisphere_pdf(other.z)
    }

    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let r = fresnel::dielectric(given.z, self.eta).reflectance;
        let probability = self.coat_probability(r, lobes);
        if u.lobe < probability {
            return Some(ModelSample::mirror(given, self.tint * r, probability));
        }
        Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)))
    }
}

/// A rough coat over a Lambertian base.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughPlastic<'s> {
    pub facets: Microfacets,
    pub eta: f32,
    /// Transmittance of the coat from outside, over the cosine on [0, 1].
    pub transmittance: &'s [f32; COSINES],
    /// See [`base_through_coat`].
    pub base: Rgb,
    pub tint: Rgb,
    coat_share: f32,
    base_albedo: f32,
}

impl<'s> RoughPlastic<'s> {
    pub(in crate::bsdf) fn new(
        facets: Microfacets,
        eta: f32,
        coat: &'s Coat,
        colors: (Rgb, Rgb),
        shift: ColorShift,
    ) -> Self {
        let (reflectance, tint) = colors;
        let internal = coat.internal_reflectance;
        let base = base_through_coat(reflectance, eta, internal, shift);
        let base_albedo = base_albedo(base, eta, internal);
        RoughPlastic {
            facets,
            eta,
            transmittance: &coat.transmittance,
            base,
            tint,
            coat_share: coat_share(tint, base_albedo),
            base_albedo,
        }
    }

    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        if cos <= 0.0 {
            return 0.0;
        }
        let r = 1.0 - interpolate(self.transmittance, cos);
        let [coat, base] = albedo_estimates(r, self.tint, self.base_albedo);
        lobes.pick(self.coat_class(), coat) + lobes.pick(Lobes::DIFFUSE, base)
    }

    #[inline]
    pub(in crate::bsdf) fn alpha(&self) -> f32 {
        self.facets.min_alpha()
    }

    /// Largest transmittance of the coat from outside.
    #[inline]
    pub(in crate::bsdf) fn max_transmittance(&self) -> f32 {
        self.transmittance.iter().copied().fold(0.0, f32::max)
    }

    /// The class of the reflection at the coat.
    #[inline]
    pub(in crate::bsdf) fn coat_class(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE.or(self.coat_class())
    }

    /// Probability of sampling the coat, for its transmittance in the given direction.
    #[inline]
    fn coat_probability(&self, transmittance: f32, lobes: Lobes) -> f32 {
        match (lobes.has(self.coat_class()), lobes.has(Lobes::DIFFUSE)) {
            (true, true) => coat_probability(1.0 - transmittance, self.coat_share),
            (true, false) => 1.0,
            _ => 0.0,
        }
    }

    #[inline]
    pub(in crate::bsdf) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.base * interpolate(self.transmittance, wi.z)
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.respond(wi, wo, lobes).values.sum()
    }

    /// See [`Model::respond`](crate::bsdf::model::Model::respond).
    pub(in crate::bsdf) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let mut response = Response::NONE;
        if wi.z <= 0.0 || wo.z <= 0.0 || !lobes.has(self.lobes()) {
            return response;
        }
        let leaves = interpolate(self.transmittance, wo.z);
        let coat = self.coat_probability(leaves, lobes);
        if lobes.has(self.coat_class()) {
            let m = (wi + wo).normalize();
            let f = fresnel::dielectric(wo.dot(m), self.eta).reflectance;
            let pdf = self.facets.reflected_pdf(wo, m);
            response.values[self.coat_class()] = self.tint * (f * pdf * self.facets.masking(wi, m));
            response.pdf = coat * pdf;
        }
        if lobes.has(Lobes::DIFFUSE) {
            let cosine = warp::cosine_hemisphere_pdf(wi.z);
            response.values[Lobes::DIFFUSE] = self.diffuse_weight(wi) * (leaves * cosine);
            response.pdf += (1.0 - coat) * cosine;
        }
        response
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let mut bound = 0.0;
        if lobes.has(self.coat_class()) {
            let halves = incident.halves(wo);
            let f = fresnel::dielectric(halves.cosines[0], self.eta).reflectance;
            let visible = self.facets.projected_bound(halves.highest, incident);
            bound += self.tint.max_channel() * f * visible * self.facets.seen(wo);
        }
        if lobes.has(Lobes::DIFFUSE) {
            let enters = self.max_transmittance();
            let leaves = interpolate(self.transmittance, wo.z);
            let projection = incident.projection(cos);
            bound += self.base.max_channel() * (enters * leaves * projection * FRAC_1_PI);
        }
        bound
    }

    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z <= 0.0 || other.z <= 0.0 || !lobes.has(self.lobes()) {
            return 0.0;
        }
        let coat = self.coat_probability(interpolate(self.transmittance, given.z), lobes);
        let mut pdf = (1.0 - coat) * warp::cosine_hemisphere_pdf(other.z);
        if coat > 0.0 {
            pdf += coat
                * self
                    .facets
                    .reflected_pdf(given, (given + other).normalize());
        }
        pdf
    }

    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let transmittance = interpolate(self.transmittance, given.z);
        if u.lobe >= self.coat_probability(transmittance, lobes) {
            return Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)));
        }
        let w = reflect(given, self.facets.sample(given, u.direction));
        (w.z > 0.0).then(|| ModelSample::finite(w))
    }
}
