//! A diffuse base under microfacets, of which each gets what the other one leaves: the model of
//! Ashikhmin and Shirley with the distributions of `microfacet`, as PBRT v3's `substrate`.
//!
//! Source: Ashikhmin and Shirley, "An Anisotropic Phong BRDF Model", 2000; Pharr, Jakob and
//! Humphreys, "Physically Based Rendering", 3rd edition, section 8.5.

use super::fresnel::reflect;
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::color::Rgb;
use crate::lanes::{
    Color, Float, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes,
};
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The factor that makes the albedo of the base 1 at most: 28/23.
const BASE_SCALE: f32 = 28.0 / 23.0;

/// `f = 28/(23π) ρd (1 - ρs) a(θi) a(θo) + D F / (4 cosθh max(cosθi, cosθo))`, with
/// `a(θ) = 1 - (1 - cosθ/2)⁵`, Schlick's reflectance `F` at the angle θh to the half vector.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Substrate<S: Width> {
    /// ρd (1 - ρs).
    base: Color<S>,
    /// ρs, the reflectance at normal incidence.
    specular: Color<S>,
    facets: Microfacets<S>,
}

in_lanes!(Substrate {
    base,
    specular,
    facets
});

impl<S: Width> Substrate<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(
        diffuse: Color<S>,
        specular: Color<S>,
        facets: Microfacets<S>,
    ) -> Self {
        Substrate {
            base: diffuse * specular.map(|s| 1.0 - s),
            specular,
            facets,
        }
    }

    /// The classes of the base: `GLOSSY`, because it depends on the direction.
    #[inline(always)]
    fn base_class(&self) -> Classes<S> {
        Classes::splat(self.base.r.width(), Lobes::GLOSSY)
    }

    /// Schlick's reflectance.
    #[inline(always)]
    fn reflectance(&self, cos: Float<S>) -> Color<S> {
        let weight = fifth_power(1.0 - cos.min(1.0));
        self.specular.map(|s| s + (1.0 - s) * weight)
    }

    /// `f cosθ_i` of the base for directions above the surface.
    #[inline(always)]
    fn base_value(&self, wi: Vector<S>, wo: Vector<S>) -> Color<S> {
        self.base * (entrance(wi.z) * entrance(wo.z) * wi.z * (BASE_SCALE * FRAC_1_PI))
    }

    /// `f cosθ_i` of the facets with normal `m` for directions above the surface.
    #[inline(always)]
    fn facet_value(&self, wi: Vector<S>, wo: Vector<S>, m: Vector<S>) -> Color<S> {
        let cos = wi.dot(m);
        let scale = self.facets.density(m) * wi.z / (4.0 * cos * wi.z.max(wo.z));
        self.reflectance(cos) * cos.gt(0.0).select(scale, 0.0)
    }

    /// Probability of sampling a facet, given a direction with this cosine.
    #[inline(always)]
    fn facet_probability(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let facets = self.reflectance(cos).max_channel();
        let base = lobes.glossy.select(self.base.max_channel(), 0.0);
        let both = facets + base;
        let share = both.gt(0.0).select(facets / both, 1.0);
        lobes.has(self.facets.class()).select(share, 0.0)
    }
}

/// `a(θ)`, the part of light at a cosine that reaches or leaves the base.
#[inline(always)]
fn entrance<S: Width>(cos: Float<S>) -> Float<S> {
    1.0 - fifth_power(1.0 - 0.5 * cos)
}

#[inline(always)]
fn fifth_power<S: Width>(x: Float<S>) -> Float<S> {
    let x2 = x * x;
    x2 * x2 * x
}

impl<S: Width> ScatteringModel<S> for Substrate<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        self.base_class().or(self.facets.class())
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let facets = self.reflectance(cos).max_channel();
        let facets = lobes.has(self.facets.class()).select(facets, 0.0);
        let base = lobes.glossy.select(self.base.max_channel(), 0.0);
        cos.gt(0.0).select(facets + base, 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let above = lobes.has(self.lobes()) & wi.z.gt(0.0) & wo.z.gt(0.0);
        if above.none() {
            return Response::none(wi.z.width());
        }
        let m = (wi + wo).normalize();
        let class = self.facets.class();
        let mut values = ByClass::of_microfacets(class, lobes, self.facet_value(wi, wo, m));
        values.glossy += self.base_value(wi, wo).within(lobes.glossy);
        let pdf = self.pdf(wo, wi, lobes);
        Response { values, pdf }.within(above)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let above = lobes.has(self.lobes()) & given.z.gt(0.0) & other.z.gt(0.0);
        let m = (given + other).normalize();
        let share = self.facet_probability(given.z, lobes);
        let facets = self.facets.reflected_pdf(given, m);
        let pdf = share * facets + (1.0 - share) * cosine_hemisphere_pdf(other.z);
        above.select(pdf, 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        let of_facet = u.lobe.lt(self.facet_probability(given.z, lobes));
        let mirrored = reflect(given, self.facets.sample(given, u.direction));
        let valid = given.z.gt(0.0) & (mirrored.z.gt(0.0) | !of_facet);
        let w = Vector::select(of_facet, mirrored, cosine_hemisphere(u.direction));
        ModelSample::finite(w, valid)
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        self.facets.min_alpha()
    }
}

impl ModelBound for Substrate<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [lowest, cos] = incident.cosines();
        if wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let projection = incident.projection(cos);
        let mut bound = 0.0;
        if lobes.has(Lobes::GLOSSY) {
            let entrances = entrance::<One>(cos.into()).get() * entrance::<One>(wo.z.into()).get();
            let base = self.base.max_channel().get();
            bound += base * entrances * projection * (BASE_SCALE * FRAC_1_PI);
        }
        if lobes.has(self.facets.class().get()) {
            let lowest = lowest.max(0.0);
            let halves = incident.halves(wo);
            // Of directions above the surface, the sum of the cosines to it bounds that to the half
            // vector.
            let facing = halves.cosines[0].max(0.5 * (lowest + wo.z));
            let reflectance = Rgb::from(self.reflectance(facing.into())).max_channel();
            let density = self.facets.visible_bound(halves.highest, 1.0);
            bound += reflectance * density * projection / (4.0 * facing * lowest.max(wo.z));
        }
        bound
    }
}
