//! The modified Phong model of Mitsuba 0.x.
//!
//! Source: Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering", 1994.

use super::diffuse::Diffuse;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::trig::sin_cos_turns;
use crate::math::{Frame, Vec3, float::safe_sqrt};
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, TAU};

/// Sum of both albedos after scaling, if it was above 1; as in Mitsuba 0.x.
const SAFE_ALBEDO: f32 = 0.99;

/// Scales two albedos so that their sum stays below one in every channel.
pub(in crate::bsdf) fn conserve_energy(diffuse: Rgb, specular: Rgb) -> (Rgb, Rgb) {
    let sum = (diffuse + specular).max_channel();
    let scale = if sum > 1.0 { SAFE_ALBEDO / sum } else { 1.0 };
    (diffuse * scale, specular * scale)
}

/// Probability of sampling the specular lobe instead of the diffuse base.
pub(in crate::bsdf) fn lobe_share(diffuse: Rgb, specular: Rgb) -> f32 {
    let (d, s) = (diffuse.max_channel(), specular.max_channel());
    if d + s > 0.0 { s / (d + s) } else { 0.5 }
}

/// `f = ρd / π + ρs (n + 2) / (2π) cosⁿα`, where α is the angle to the mirror direction.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Phong {
    pub base: Diffuse,
    specular: Rgb,
    exponent: f32,
    share: f32,
}

impl Phong {
    pub(in crate::bsdf) fn new(diffuse: Rgb, specular: Rgb, exponent: f32) -> Self {
        let (diffuse, specular) = conserve_energy(diffuse, specular);
        let share = lobe_share(diffuse, specular);
        Phong {
            base: Diffuse {
                reflectance: diffuse,
            },
            specular,
            exponent: exponent.max(0.0),
            share,
        }
    }

    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        if cos <= 0.0 {
            return 0.0;
        }
        lobes.pick(self.lobe_class(), self.specular.max_channel())
            + lobes.pick(Lobes::DIFFUSE, self.base.reflectance.max_channel())
    }

    /// Roughness of a microfacet lobe of the same width: exp(-n α²/2) = exp(-θh²/alpha²) with α = 2 θh.
    #[inline]
    pub(in crate::bsdf) fn alpha(&self) -> f32 {
        (2.0 * self.exponent).max(1.0).sqrt().recip()
    }

    #[inline]
    fn lobe_class(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE.or(self.lobe_class())
    }

    #[inline]
    fn lobe_probability(&self, lobes: Lobes) -> f32 {
        match (lobes.has(self.lobe_class()), lobes.has(Lobes::DIFFUSE)) {
            (true, true) => self.share,
            (true, false) => 1.0,
            _ => 0.0,
        }
    }

    /// cosⁿα between `a` and the mirror direction of `b`.
    #[inline]
    fn falloff(&self, a: Vec3, b: Vec3) -> f32 {
        let cos = (a.z * b.z - a.x * b.x - a.y * b.y).min(1.0);
        if cos > 0.0 {
            cos.powf(self.exponent)
        } else {
            0.0
        }
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        let mut sum = self.base.eval(wi, wo, lobes);
        if lobes.has(self.lobe_class()) {
            sum += self.specular * ((self.exponent + 2.0) / TAU * self.falloff(wi, wo) * wi.z);
        }
        sum
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let mut bound = self.base.bound(incident, wo, lobes);
        if lobes.has(self.lobe_class()) {
            let [_, nearest] = incident.cosines_to(Vec3::new(-wo.x, -wo.y, wo.z));
            let falloff = nearest.max(0.0).powf(self.exponent);
            let projection = incident.projection(cos);
            bound +=
                self.specular.max_channel() * ((self.exponent + 2.0) / TAU * falloff * projection);
        }
        bound
    }

    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z <= 0.0 || other.z <= 0.0 || !lobes.has(self.lobes()) {
            return 0.0;
        }
        let share = self.lobe_probability(lobes);
        let lobe = (self.exponent + 1.0) / TAU * self.falloff(given, other);
        share * lobe + (1.0 - share) * other.z * FRAC_1_PI
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
        if u.lobe >= self.lobe_probability(lobes) {
            return Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)));
        }
        let cos = (1.0 - u.direction.y).powf(1.0 / (self.exponent + 1.0));
        let sin = safe_sqrt(1.0 - cos * cos);
        let (sin_phi, cos_phi) = sin_cos_turns(u.direction.x);
        let mirror = Vec3::new(-given.x, -given.y, given.z);
        let w = Frame::from_normal(mirror).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos));
        (w.z > 0.0).then(|| ModelSample::finite(w))
    }
}
