//! Oren and Nayar's model of rough diffuse surfaces, with the roughness parameter of Mitsuba 0.x.
//!
//! Source: Oren and Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH 1994.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::material::OrenNayarVariant;
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes,
};
use crate::math::{Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};

/// V-shaped grooves of Lambertian facets with Gaussian slopes of variance σ².
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughDiffuse<S: Width> {
    reflectance: Color<S>,
    sigma2: Float<S>,
    variant: OrenNayarVariant,
}

in_lanes!(RoughDiffuse { reflectance, sigma2; variant });

/// Sines and cosines of the angles in both forms of the model. `alpha` is the larger polar angle,
/// `beta` the smaller.
struct Angles<S: Width> {
    cos_phi: Float<S>,
    sin_alpha: Float<S>,
    cos_alpha: Float<S>,
    sin_beta: Float<S>,
    cos_beta: Float<S>,
}

impl<S: Width> Angles<S> {
    #[inline(always)]
    fn new(a: Vector<S>, b: Vector<S>) -> Self {
        let (sin_a, sin_b) = ((1.0 - a.z * a.z).safe_sqrt(), (1.0 - b.z * b.z).safe_sqrt());
        let sines = sin_a * sin_b;
        let cos_phi = ((a.x * b.x + a.y * b.y) / sines).clamp(-1.0, 1.0);
        let a_is_beta = a.z.gt(b.z);
        Angles {
            // For smaller sines the azimuth is undefined in single precision.
            cos_phi: sines.gt(1e-8).select(cos_phi, 0.0),
            sin_alpha: a_is_beta.select(sin_b, sin_a),
            cos_alpha: a_is_beta.select(b.z, a.z),
            sin_beta: a_is_beta.select(sin_a, sin_b),
            cos_beta: a_is_beta.select(a.z, b.z),
        }
    }

    #[inline(always)]
    fn tan_beta(&self) -> Float<S> {
        self.sin_beta / self.cos_beta
    }
}

impl<S: Width> RoughDiffuse<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(
        reflectance: Color<S>,
        alpha: Float<S>,
        variant: OrenNayarVariant,
    ) -> Self {
        // Mitsuba 0.x takes Beckmann's alpha; σ = alpha / √2 matches it.
        RoughDiffuse {
            reflectance,
            sigma2: 0.5 * alpha * alpha,
            variant,
        }
    }

    /// Oren and Nayar's qualitative model.
    #[inline(always)]
    fn qualitative_model(&self, t: &Angles<S>) -> Color<S> {
        let a = 1.0 - 0.5 * self.sigma2 / (self.sigma2 + 0.33);
        let b = 0.45 * self.sigma2 / (self.sigma2 + 0.09);
        self.reflectance * (a + b * t.cos_phi.max(0.0) * t.sin_alpha * t.tan_beta())
    }

    /// Oren and Nayar's fit of single scattering and interreflection.
    #[inline(always)]
    fn full_model(&self, t: &Angles<S>) -> Color<S> {
        let alpha_part = t.cos_alpha.clamp(-1.0, 1.0).acos() * (1.0 / FRAC_PI_2);
        let beta_part = t.cos_beta.clamp(-1.0, 1.0).acos() * (1.0 / FRAC_PI_2);
        let rough = self.sigma2 / (self.sigma2 + 0.09);

        let c1 = 1.0 - 0.5 * self.sigma2 / (self.sigma2 + 0.33);
        let bend = beta_part * beta_part * beta_part;
        let bend = t.cos_phi.gt(0.0).select(0.0, bend);
        let c2 = 0.45 * rough * (t.sin_alpha - bend);
        let c3 = 0.125 * rough * (alpha_part * beta_part).squared();
        let c4 = 0.17 * self.sigma2 / (self.sigma2 + 0.13);

        // tan((α + β) / 2) from the half-angle formula.
        let tan_half = (t.sin_alpha + t.sin_beta) / (t.cos_alpha + t.cos_beta);
        let single = c1 + t.cos_phi * c2 * t.tan_beta() + (1.0 - t.cos_phi.abs()) * c3 * tan_half;
        let double = c4 * (1.0 - t.cos_phi * beta_part.squared());
        self.reflectance * single + self.reflectance * self.reflectance * double
    }
}

impl<S: Width> ScatteringModel<S> for RoughDiffuse<S> {
    /// `GLOSSY`, but `DIFFUSE` without roughness: then it is Lambert's model.
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        let is_smooth = self.sigma2.equals(0.0);
        Classes {
            diffuse: is_smooth,
            glossy: !is_smooth,
            ..Classes::splat(is_smooth.width(), Lobes::NONE)
        }
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        cos.gt(0.0).select(self.reflectance.max_channel(), 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let class = self.lobes().and(lobes);
        let above = wi.z.gt(0.0) & wo.z.gt(0.0) & class.any();
        let angles = Angles::new(wi, wo);
        let shape = match self.variant {
            OrenNayarVariant::Full => self.full_model(&angles),
            OrenNayarVariant::Qualitative => self.qualitative_model(&angles),
        };
        let pdf = wi.z * FRAC_1_PI;
        let value = shape * pdf;
        let values = ByClass {
            diffuse: value.within(class.diffuse),
            glossy: value.within(class.glossy),
            near_delta: Color::black(pdf.width()),
        };
        Response { values, pdf }.within(above)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, _: Classes<S>) -> Float<S> {
        given.z.gt(0.0).select(cosine_hemisphere_pdf(other.z), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        ModelSample::finite(cosine_hemisphere(u.direction), given.z.gt(0.0))
    }

    #[inline(always)]
    fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        self.reflectance.within(wi.z.gt(0.0) & self.lobes().diffuse)
    }
}

impl ModelBound for RoughDiffuse<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = incident.cosines();
        if !lobes.has(self.lobes().get()) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let sigma2 = self.sigma2.get();
        // β is the smaller angle, so tanβ cosθ_i is at most sinθ_i and at most tanθ_o cosθ_i. And
        // tan((α + β) / 2) cosβ <= 2.
        let tan_o = safe_sqrt(1.0 - wo.z * wo.z) / wo.z;
        let projection = incident.projection(cos);
        let (grazing, steep) = match incident.projected {
            None => ((tan_o * cos).min(1.0), 1.0),
            Some(projected) => (tan_o * projected, projected / wo.z),
        };
        let first = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
        let rough = sigma2 / (sigma2 + 0.09);
        let single = first * projection + 0.45 * rough * grazing;
        let (single, double) = match self.variant {
            OrenNayarVariant::Full => {
                let double = 0.17 * sigma2 / (sigma2 + 0.13);
                (
                    single + 0.125 * rough * 2.0 * steep,
                    2.0 * double * projection,
                )
            }
            OrenNayarVariant::Qualitative => (single, 0.0),
        };
        let rho = self.reflectance.max_channel().get();
        rho * (single + rho * double) * FRAC_1_PI
    }
}
