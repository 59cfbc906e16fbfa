//! The modified Phong model of Mitsuba 0.x.
//!
//! Source: Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically Based
//! Rendering", 1994.

use super::diffuse::Diffuse;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Axes, Color, Float, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf,
};
use crate::math::Vec3;
use std::f32::consts::TAU;

/// Sum of both albedos after scaling, if it was above 1; as in Mitsuba 0.x.
const SAFE_ALBEDO: f32 = 0.99;

/// A lobe over a diffuse base, and the choice between both.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeOverBase<S: Width> {
    pub(super) base: Diffuse<S>,
    pub(super) specular: Color<S>,
    /// The classes of the lobe.
    pub(super) class: Classes<S>,
    /// Probability of sampling the lobe, if both are requested.
    share: Float<S>,
}

impl<S: Width> LobeOverBase<S> {
    /// Scales the two albedos so that their sum stays below one in every channel.
    #[inline(always)]
    pub(super) fn new(diffuse: Color<S>, specular: Color<S>, class: Classes<S>) -> Self {
        let sum = (diffuse + specular).max_channel();
        let scale = sum.gt(1.0).select(SAFE_ALBEDO / sum, 1.0);
        let (diffuse, specular) = (diffuse * scale, specular * scale);
        let (d, s) = (diffuse.max_channel(), specular.max_channel());
        LobeOverBase {
            base: Diffuse {
                reflectance: diffuse,
            },
            specular,
            class,
            share: (d + s).gt(0.0).select(s / (d + s), 0.5),
        }
    }

    #[inline(always)]
    pub(super) fn lobes(&self) -> Classes<S> {
        self.base.lobes().or(self.class)
    }

    #[inline(always)]
    pub(super) fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let lobe = lobes
            .has(self.class)
            .select(self.specular.max_channel(), 0.0);
        let base = lobes
            .diffuse
            .select(self.base.reflectance.max_channel(), 0.0);
        cos.gt(0.0).select(lobe + base, 0.0)
    }

    /// Probability of sampling the lobe instead of the base.
    #[inline(always)]
    pub(super) fn probability(&self, lobes: Classes<S>) -> Float<S> {
        let with_lobe = lobes.diffuse.select(self.share, 1.0);
        lobes.has(self.class).select(with_lobe, 0.0)
    }

    /// The response for directions above the surface, where the lobe has `value` and is sampled
    /// with the density `lobe_pdf`.
    #[inline(always)]
    pub(super) fn respond(
        &self,
        (wi, wo): (Vector<S>, Vector<S>),
        lobes: Classes<S>,
        value: Float<S>,
        lobe_pdf: Float<S>,
    ) -> Response<S> {
        let above = wi.z.gt(0.0) & wo.z.gt(0.0);
        let base = self.base.respond(wi, wo, lobes);
        let values = ByClass {
            diffuse: base.values.diffuse,
            ..ByClass::of_microfacets(self.class, lobes, self.specular * value)
        };
        let pdf = self.pdf(wi.z, lobes, lobe_pdf);
        Response { values, pdf }.within(above)
    }

    /// Density of a direction of cosine `cos` above the surface.
    #[inline(always)]
    pub(super) fn pdf(&self, cos: Float<S>, lobes: Classes<S>, lobe_pdf: Float<S>) -> Float<S> {
        let share = self.probability(lobes);
        let pdf = share * lobe_pdf + (1.0 - share) * cosine_hemisphere_pdf(cos);
        lobes.has(self.lobes()).select(pdf, 0.0)
    }

    /// A sample given a direction of cosine `cos`, where `w` is a direction of the lobe.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        cos: Float<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
        w: Vector<S>,
    ) -> ModelSample<S> {
        let of_lobe = u.lobe.lt(self.probability(lobes));
        let valid = cos.gt(0.0) & (w.z.gt(0.0) | !of_lobe);
        ModelSample::finite(
            Vector::select(of_lobe, w, cosine_hemisphere(u.direction)),
            valid,
        )
    }
}

/// `f = ρd / π + ρs (n + 2) / (2π) cosⁿα`, where α is the angle to the mirror direction.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Phong<S: Width> {
    pub(super) layers: LobeOverBase<S>,
    exponent: Float<S>,
}

impl<S: Width> Phong<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(diffuse: Color<S>, specular: Color<S>, exponent: Float<S>) -> Self {
        let exponent = exponent.max(0.0);
        let class = Classes::of_microfacets(alpha(exponent));
        Phong {
            layers: LobeOverBase::new(diffuse, specular, class),
            exponent,
        }
    }

    /// cosⁿα between `a` and the mirror direction of `b`.
    #[inline(always)]
    fn falloff(&self, a: Vector<S>, b: Vector<S>) -> Float<S> {
        let cos = (a.z * b.z - a.x * b.x - a.y * b.y).min(1.0);
        cos.gt(0.0).select(cos.powf(self.exponent), 0.0)
    }
}

impl<S: Width> ScatteringModel<S> for Phong<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        self.layers.lobes()
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        self.layers.albedo_estimate(cos, lobes)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let falloff = self.falloff(wi, wo) * (1.0 / TAU);
        let value = (self.exponent + 2.0) * falloff * wi.z;
        let pdf = (self.exponent + 1.0) * falloff;
        self.layers.respond((wi, wo), lobes, value, pdf)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let lobe = (self.exponent + 1.0) * (1.0 / TAU) * self.falloff(given, other);
        let above = given.z.gt(0.0) & other.z.gt(0.0);
        above.select(self.layers.pdf(other.z, lobes, lobe), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        let cos = (1.0 - u.direction.y).powf((self.exponent + 1.0).recip());
        let sin = (1.0 - cos * cos).safe_sqrt();
        let (sin_phi, cos_phi) = u.direction.x.sin_cos_turns();
        let mirror = Vector::new(-given.x, -given.y, given.z);
        let about = Vector::new(sin * cos_phi, sin * sin_phi, cos);
        let w = Axes::from_normal(mirror).to_world(about);
        self.layers.sample(given.z, u, lobes, w)
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        alpha(self.exponent)
    }

    #[inline(always)]
    fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        self.layers.base.diffuse_weight(wi)
    }
}

/// Roughness of a microfacet lobe of the same width: exp(-n α²/2) = exp(-θh²/alpha²) with α = 2 θh.
#[inline(always)]
fn alpha<S: Width>(exponent: Float<S>) -> Float<S> {
    (2.0 * exponent).max(1.0).sqrt().recip()
}

impl ModelBound for Phong<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let LobeOverBase {
            base,
            specular,
            class,
            ..
        } = &self.layers;
        let mut bound = base.bound(incident, wo, lobes);
        if lobes.has(class.get()) {
            let exponent = self.exponent.get();
            let [_, nearest] = incident.cosines_to(Vec3::new(-wo.x, -wo.y, wo.z));
            let falloff = nearest.max(0.0).powf(exponent);
            let projection = incident.projection(cos);
            bound += specular.max_channel().get() * ((exponent + 2.0) / TAU * falloff * projection);
        }
        bound
    }
}
