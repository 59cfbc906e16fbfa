//! The modified Phong model of Mitsuba 0.x.
//!
//! Source: Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically Based
//! Rendering", 1994.

use super::lobe_over_base::LobeOverBase;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::Response;
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{Axes, Color, Float, One, Vector, Width, in_lanes};
use crate::math::Vec3;
use std::f32::consts::TAU;

/// `f = ρd / π + ρs (n + 2) / (2π) cosⁿα`, where α is the angle to the mirror direction.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Phong<S: Width> {
    layers: LobeOverBase<S>,
    exponent: Float<S>,
}

in_lanes!(Phong { layers, exponent });

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
