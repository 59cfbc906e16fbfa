//! Sampling of the principled model.

use super::terms::gtr1;
use super::{CLEARCOAT_SCALE, Principled};
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::models::dielectric::HalfVector;
use crate::bsdf::models::fresnel::{self, reflect, refract};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::math::trig::sin_cos_turns;
use crate::math::{Vec2, Vec3, float::safe_sqrt};
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

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
    /// Probabilities for the given direction. From below, only the main interface is sampled.
    fn strategies(&self, given: Vec3, lobes: Lobes) -> Strategies {
        let pick = |class, rate| if lobes.has(class) { rate } else { 0.0 };
        if given.z < 0.0 {
            let transparent = if self.bsdf > 0.0 { 1.0 } else { 0.0 };
            return Strategies {
                diffuse: 0.0,
                clearcoat: 0.0,
                specular: pick(self.specular_class(), transparent),
            };
        }
        let mut chosen = Strategies {
            diffuse: pick(Lobes::GLOSSY, self.brdf * self.diffuse_rate),
            clearcoat: pick(
                self.clearcoat_class(),
                CLEARCOAT_SCALE * self.clearcoat * self.clearcoat_rate,
            ),
            specular: pick(self.specular_class(), self.specular_rate),
        };
        // Without a positive probability by these rates, lobes of the requested classes must be reachable nevertheless.
        if chosen.total() == 0.0 {
            chosen.diffuse = pick(Lobes::GLOSSY, 1.0);
            chosen.clearcoat = pick(self.clearcoat_class(), self.clearcoat);
            chosen.specular = pick(self.specular_class(), 1.0);
        }
        chosen
    }

    /// Probability of transmission at the main interface, at a facet of reflectance `r`.
    #[inline]
    fn transmission_probability(&self, given: Vec3, r: f32) -> f32 {
        if given.z > 0.0 {
            self.bsdf * (1.0 - r)
        } else {
            1.0 - r
        }
    }

    /// See [`Model::pdf`](crate::bsdf::model::Model::pdf).
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        HalfVector::new(given, other, self.eta)
            .map_or(0.0, |half| self.pdf_by(&half, given, other, lobes))
    }

    /// The density for two directions with this half vector.
    pub(super) fn pdf_by(&self, half: &HalfVector, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        let strategies = self.strategies(given, lobes);
        let total = strategies.total();
        if total == 0.0 {
            return 0.0;
        }
        let mut pdf = 0.0;
        if strategies.specular > 0.0 {
            let r = fresnel::dielectric(given.dot(half.m), self.eta).reflectance;
            let transmission = self.transmission_probability(given, r);
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
        let strategies = self.strategies(given, lobes);
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
        let interface = fresnel::dielectric(given.dot(m), self.eta);
        if left >= self.transmission_probability(given, interface.reflectance) {
            let w = reflect(given, m);
            return (w.z * given.z > 0.0).then(|| ModelSample::finite(w));
        }
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
