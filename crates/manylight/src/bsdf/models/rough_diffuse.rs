//! Oren and Nayar's model of rough diffuse surfaces, with the roughness parameter of Mitsuba 0.x.
//!
//! Source: Oren and Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH 1994.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::{Vec3, float::safe_sqrt};
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};

/// V-shaped grooves of Lambertian facets with Gaussian slopes of variance σ².
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughDiffuse {
    reflectance: Rgb,
    sigma2: f32,
    full: bool,
}

/// Sines and cosines of the angles in both forms of the model. `alpha` is the larger polar angle, `beta` the smaller.
struct Angles {
    cos_phi: f32,
    sin_alpha: f32,
    cos_alpha: f32,
    sin_beta: f32,
    cos_beta: f32,
}

impl Angles {
    fn new(a: Vec3, b: Vec3) -> Self {
        let (sin_a, sin_b) = (safe_sqrt(1.0 - a.z * a.z), safe_sqrt(1.0 - b.z * b.z));
        let sines = sin_a * sin_b;
        // For smaller sines the azimuth is undefined in single precision.
        let cos_phi = if sines > 1e-8 {
            ((a.x * b.x + a.y * b.y) / sines).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        if a.z > b.z {
            Angles {
                cos_phi,
                sin_alpha: sin_b,
                cos_alpha: b.z,
                sin_beta: sin_a,
                cos_beta: a.z,
            }
        } else {
            Angles {
                cos_phi,
                sin_alpha: sin_a,
                cos_alpha: a.z,
                sin_beta: sin_b,
                cos_beta: b.z,
            }
        }
    }

    fn tan_beta(&self) -> f32 {
        self.sin_beta / self.cos_beta
    }
}

impl RoughDiffuse {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        if cos > 0.0 {
            self.reflectance.max_channel()
        } else {
            0.0
        }
    }

    pub(in crate::bsdf) fn new(reflectance: Rgb, alpha: f32, full: bool) -> Self {
        // Mitsuba 0.x takes Beckmann's alpha; σ = alpha / √2 matches it.
        RoughDiffuse {
            reflectance,
            sigma2: 0.5 * alpha * alpha,
            full,
        }
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::GLOSSY
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::GLOSSY) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        let angles = Angles::new(wi, wo);
        let shape = if self.full {
            self.full_model(&angles)
        } else {
            self.qualitative_model(&angles)
        };
        shape * (wi.z * FRAC_1_PI)
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if !lobes.has(Lobes::GLOSSY) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        // β is the smaller angle, so tanβ cosθ_i is at most sinθ_i and at most tanθ_o cosθ_i. And tan((α + β) / 2) cosβ <= 2.
        let tan_o = safe_sqrt(1.0 - wo.z * wo.z) / wo.z;
        let projection = incident.projection(cos);
        let (grazing, steep) = match incident.projected {
            None => ((tan_o * cos).min(1.0), 1.0),
            Some(projected) => (tan_o * projected, projected / wo.z),
        };
        let first = 1.0 - 0.5 * self.sigma2 / (self.sigma2 + 0.33);
        let rough = self.sigma2 / (self.sigma2 + 0.09);
        let single = first * projection + 0.45 * rough * grazing;
        let (single, double) = if self.full {
            let double = 0.17 * self.sigma2 / (self.sigma2 + 0.13);
            (
                single + 0.125 * rough * 2.0 * steep,
                2.0 * double * projection,
            )
        } else {
            (single, 0.0)
        };
        let rho = self.reflectance.max_channel();
        rho * (single + rho * double) * FRAC_1_PI
    }

    /// Oren and Nayar's qualitative model.
    fn qualitative_model(&self, t: &Angles) -> Rgb {
        let a = 1.0 - 0.5 * self.sigma2 / (self.sigma2 + 0.33);
        let b = 0.45 * self.sigma2 / (self.sigma2 + 0.09);
        self.reflectance * (a + b * t.cos_phi.max(0.0) * t.sin_alpha * t.tan_beta())
    }

    /// Oren and Nayar's fit of single scattering and interreflection.
    fn full_model(&self, t: &Angles) -> Rgb {
        let alpha = t.cos_alpha.clamp(-1.0, 1.0).acos();
        let beta = t.cos_beta.clamp(-1.0, 1.0).acos();
        let (alpha_part, beta_part) = (alpha / FRAC_PI_2, beta / FRAC_PI_2);
        let rough = self.sigma2 / (self.sigma2 + 0.09);

        let c1 = 1.0 - 0.5 * self.sigma2 / (self.sigma2 + 0.33);
        let bend = if t.cos_phi > 0.0 {
            0.0
        } else {
            beta_part.powi(3)
        };
        let c2 = 0.45 * rough * (t.sin_alpha - bend);
        let c3 = 0.125 * rough * (alpha_part * beta_part).powi(2);
        let c4 = 0.17 * self.sigma2 / (self.sigma2 + 0.13);

        // tan((α + β) / 2) from the half-angle formula.
        let tan_half = (t.sin_alpha + t.sin_beta) / (t.cos_alpha + t.cos_beta);
        let single = c1 + t.cos_phi * c2 * t.tan_beta() + (1.0 - t.cos_phi.abs()) * c3 * tan_half;
        let double = c4 * (1.0 - t.cos_phi * beta_part.powi(2));
        self.reflectance * single + self.reflectance * self.reflectance * double
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
}
