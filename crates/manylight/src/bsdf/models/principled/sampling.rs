//! Sampling of the principled model.

use super::Principled;
use super::terms::gtr1;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::models::dielectric::HalfVector;
use crate::bsdf::models::fresnel::{self, reflect, refract};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::math::trig::sin_cos_turns;
use crate::math::{Vec2, Vec3, float::safe_sqrt};
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, PI};

/// Albedo of sheen at weight 1, an estimate. Not measured.
pub(super) const SHEEN_ALBEDO: f32 = 0.05;

/// Lower bound of Schlick's term where the reflectance of rough surfaces is estimated at the surface normal: facets reflect at other angles.
pub(super) const MIN_SCHLICK: f32 = 0.02;

/// Unnormalized probabilities of the sampling strategies.
struct Strategies {
    diffuse: f32,
    clearcoat: f32,
    specular: f32,
}

impl Strategies {
    fn total(&self) -> f32 {
        self.diffuse + self.clearcoat + self.specular
    }
}

impl Principled {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        self.strategies(cos, lobes).total()
    }

    /// Probabilities for a given direction of this cosine: estimates of the light that each lobe returns, times the rate of the material.
    /// From below, only the main interface is sampled.
    fn strategies(&self, cos: f32, lobes: Lobes) -> Strategies {
        if cos < 0.0 {
            let transparent = if self.bsdf > 0.0 { 1.0 } else { 0.0 };
            return Strategies {
                diffuse: 0.0,
                clearcoat: 0.0,
                specular: lobes.pick(self.specular_class(), transparent),
            };
        }
        let front = self.front(Lobes::FINITE);
        let diffuse = PI * front.base.max_channel() + SHEEN_ALBEDO * front.sheen.max_channel();
        let specular =
            front.interface_reflectance(cos, MIN_SCHLICK).max_channel() + self.transmitted(cos);
        let mut chosen = Strategies {
            diffuse: lobes.pick(Lobes::GLOSSY, diffuse * self.diffuse_rate),
            clearcoat: lobes.pick(
                self.clearcoat_class(),
                front.clearcoat_reflectance(cos) * self.clearcoat_rate,
            ),
            specular: lobes.pick(self.specular_class(), specular * self.specular_rate),
        };
        // Without a positive probability by these rates, lobes of the requested classes must be reachable nevertheless.
        if chosen.total() == 0.0 {
            chosen.diffuse = lobes.pick(Lobes::GLOSSY, 1.0);
            chosen.clearcoat = lobes.pick(self.clearcoat_class(), self.clearcoat);
            chosen.specular = lobes.pick(self.specular_class(), 1.0);
        }
        chosen
    }

    /// Fraction of light that the main interface transmits at the cosine `cos`: the largest channel.
    #[inline]
    fn transmitted(&self, cos: f32) -> f32 {
        if self.bsdf == 0.0 {
            return 0.0;
        }
        let r = fresnel::dielectric(cos, self.eta).reflectance;
        self.bsdf * (1.0 - r) * safe_sqrt(self.base_color.max_channel())
    }

    /// Probability of transmission at a facet of the main interface with normal `m`, in proportion to the light that the facet returns.
    #[inline]
    fn transmission_probability(&self, given: Vec3, m: Vec3) -> f32 {
        let cos = given.dot(m);
        let transmitted = self.transmitted(cos);
        if transmitted == 0.0 {
            return 0.0;
        }
        let reflected = if given.z > 0.0 {
            let front = self.front(Lobes::FINITE);
            front.interface_reflectance(cos, 0.0).max_channel()
        } else {
            self.bsdf * fresnel::dielectric(cos, self.eta).reflectance
        };
        transmitted / (transmitted + reflected)
    }

    /// See [`Model::pdf`](crate::bsdf::model::Model::pdf).
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        HalfVector::new(given, other, self.eta)
            .map_or(0.0, |half| self.pdf_by(&half, given, other, lobes))
    }

    /// The density for two directions with this half vector.
    pub(super) fn pdf_by(&self, half: &HalfVector, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        let strategies = self.strategies(given.z, lobes);
        let total = strategies.total();
        if total == 0.0 {
            return 0.0;
        }
        let mut pdf = 0.0;
        if strategies.specular > 0.0 {
            let transmission = self.transmission_probability(given, half.m);
            let choice = if half.reflects {
                1.0 - transmission
            } else {
                transmission
            };
            pdf += strategies.specular * choice * half.pdf(&self.facets, given, other);
        }
        if half.reflects && given.z > 0.0 {
            pdf += strategies.diffuse * other.z * FRAC_1_PI;
            if strategies.clearcoat > 0.0 {
                let m = half.m;
                pdf +=
                    strategies.clearcoat * self.clearcoat_density(m.z) * m.z / (4.0 * other.dot(m));
            }
        }
        pdf / total
    }

    /// See [`Model::sample`](crate::bsdf::model::Model::sample).
    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        if given.z == 0.0 {
            return None;
        }
        let strategies = self.strategies(given.z, lobes);
        let chosen = u.lobe * strategies.total();
        if chosen < strategies.diffuse {
            return Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)));
        }
        if chosen < strategies.diffuse + strategies.clearcoat {
            let w = reflect(given, self.sample_clearcoat(u.direction));
            return (w.z > 0.0).then(|| ModelSample::finite(w));
        }
        if strategies.specular == 0.0 {
            return None;
        }
        let left = (chosen - strategies.diffuse - strategies.clearcoat) / strategies.specular;
        let m = self
            .facets
            .sample(if given.z > 0.0 { given } else { -given }, u.direction);
        if left >= self.transmission_probability(given, m) {
            let w = reflect(given, m);
            return (w.z * given.z > 0.0).then(|| ModelSample::finite(w));
        }
        let interface = fresnel::dielectric(given.dot(m), self.eta);
        let w = refract(given, m, &interface);
        (w.z * given.z < 0.0).then_some(ModelSample {
            w,
            eta: interface.eta,
            delta: None,
        })
    }

    /// A facet normal of the clear coat.
    fn sample_clearcoat(&self, u: Vec2) -> Vec3 {
        let a2 = self.clearcoat_alpha * self.clearcoat_alpha;
        let cos2 = (1.0 - a2.powf(1.0 - u.y)) / (1.0 - a2);
        let sin = safe_sqrt(1.0 - cos2);
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        Vec3::new(cos_phi * sin, sin_phi * sin, safe_sqrt(cos2))
    }

    /// Density of facet normals of the clear coat.
    fn clearcoat_density(&self, cos_m: f32) -> f32 {
        gtr1(self.clearcoat_excess(), self.clearcoat_norm, cos_m)
    }
}
