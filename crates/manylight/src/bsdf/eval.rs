//! Values and densities of a scattering function.

use super::lambert::Lambert;
use super::leaf::Given;
use super::model::Model;
use super::response::Response;
use super::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// See [`Bsdf::direct_response`].
#[derive(Clone, Copy, Debug)]
pub struct DirectResponse {
    /// `f |wi·ng|` of the `NON_SPECULAR` lobes.
    pub non_specular: Rgb,
    /// `f |wi·ng|` of the `NEAR_DELTA` lobes.
    pub near_delta: Rgb,
    /// Density of [`Bsdf::sample_wi`] for all lobes, per solid angle.
    pub pdf: f32,
}

impl Bsdf<'_> {
    /// `f(wi → wo)` in 1/sr: `f_s |wi·ns| / |wi·ng|`, where `f_s` is the model in the shading frame. With this definition all
    /// other formulas use geometric cosines. Whether `wi` and `wo` are on the same side is decided by the shading normal `ns`, as in
    /// Mitsuba's path tracer. Transmission scales radiance by η².
    #[inline]
    pub fn f(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let cos = wi.dot(self.ng).abs();
        if cos == 0.0 {
            return Rgb::BLACK;
        }
        self.f_cos_wi(wi, wo, lobes) / cos
    }

    /// `f |wi·ng|`, the factor of incident radiance. Computed without a division by the cosine.
    #[inline]
    pub fn f_cos_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !self.lobes.has(lobes.and(Lobes::FINITE)) {
            return Rgb::BLACK;
        }
        self.eval_local(self.frame.to_local(wi), self.frame.to_local(wo), lobes)
    }

    /// [`Bsdf::f_cos_wi`] of the `NON_SPECULAR` and of the `NEAR_DELTA` lobes, and [`Bsdf::pdf_wi`] of all lobes, at the cost of one
    /// evaluation: what next-event estimation needs. `None` if nothing is scattered to `wo`.
    #[inline]
    pub fn direct_response(&self, wi: Vec3, wo: Vec3) -> Option<DirectResponse> {
        let (wi, wo) = (self.frame.to_local(wi), self.frame.to_local(wo));
        if let Some(lambert) = self.plain_lambert(wo) {
            let pdf = lambert.pdf(wi);
            return (pdf > 0.0).then_some(DirectResponse {
                non_specular: lambert.albedo * pdf,
                near_delta: Rgb::BLACK,
                pdf,
            });
        }
        let Response { values, pdf } = self.respond_local(wi, wo, Lobes::ALL);
        let non_specular = values[Lobes::DIFFUSE] + values[Lobes::GLOSSY];
        let near_delta = values[Lobes::NEAR_DELTA];
        (!non_specular.is_black() || !near_delta.is_black()).then_some(DirectResponse {
            non_specular,
            near_delta,
            pdf,
        })
    }

    /// `f |wo·ng|`: radiant intensity towards `wo` over incident flux.
    #[inline]
    pub fn f_cos_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.f(wi, wo, lobes) * wo.dot(self.ng).abs()
    }

    /// Density of [`Bsdf::sample_wi`] per solid angle, without delta lobes.
    #[inline]
    pub fn pdf_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        self.pdf_local(
            Given::Wo,
            self.frame.to_local(wo),
            self.frame.to_local(wi),
            lobes,
        )
    }

    /// Density of [`Bsdf::sample_wo`] per solid angle, without delta lobes.
    #[inline]
    pub fn pdf_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        self.pdf_wo_local(self.frame.to_local(wi), wo, self.frame.to_local(wo), lobes)
    }

    /// [`Bsdf::pdf_wo`] with `wi` and `wo` in the shading frame as `given` and `other`.
    #[inline]
    pub(super) fn pdf_wo_local(&self, given: Vec3, wo: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        let pdf = self.pdf_local(Given::Wi, given, other, lobes);
        let defensive = self.defensive_probability(given, lobes);
        if defensive == 0.0 {
            return pdf;
        }
        let about_ng = if given.z * other.z > 0.0 {
            wo.dot(self.ng).abs() * FRAC_1_PI
        } else {
            0.0
        };
        (1.0 - defensive) * pdf + defensive * about_ng
    }

    /// Fraction of light that passes straight through along `w`, as if there were no surface (mask, null, thin dielectric).
    /// The weights of the lobes contain the opacity.
    #[inline]
    pub fn transmittance(&self, w: Vec3) -> Rgb {
        if !self.is_transparent {
            return Rgb::BLACK;
        }
        let local = self.frame.to_local(w);
        let mut sum = Rgb::splat(self.pass_through[usize::from(local.z < 0.0)]);
        for leaf in self.leaves.iter().flatten() {
            if let Model::ThinDielectric(thin) = &leaf.model {
                sum += thin.transmittance(local.z) * leaf.weight;
            }
        }
        sum
    }

    /// `a(wi)` of the `DIFFUSE` lobes, `f = a(wi) b(wo) / π` on the side of `wi`: incident flux Φ gives the radiant intensity
    /// `Φ a(wi) b(wo) |wo·ng| / π`.
    #[inline]
    pub fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        let cos = wi.dot(self.ng).abs();
        if cos == 0.0 || !self.lobes.has(Lobes::DIFFUSE) {
            return Rgb::BLACK;
        }
        let local = self.frame.to_local(wi);
        let sum: Rgb = self
            .leaves
            .iter()
            .flatten()
            .map(|leaf| leaf.diffuse_weight(local))
            .sum();
        sum * (local.z.abs() / cos)
    }

    /// The surface as Lambert's model alone, for the shortcuts of the most frequent material. `None` for other materials, and on a
    /// black side.
    #[inline]
    pub(super) fn plain_lambert(&self, wo: Vec3) -> Option<Lambert> {
        match &self.leaves {
            [Some(leaf), None, ..] => leaf.plain_lambert(wo),
            _ => None,
        }
    }

    /// [`Bsdf::f_cos_wi`] for directions in the shading frame.
    #[inline]
    pub(super) fn eval_local(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let mut sum = Rgb::BLACK;
        for leaf in self.leaves.iter().map_while(Option::as_ref) {
            sum += leaf.eval(wi, wo, lobes);
        }
        sum
    }

    /// Density of sampling `other` given `given`, both in the shading frame, without defensive sampling.
    #[inline]
    fn pdf_local(&self, end: Given, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if let [Some(leaf), None, ..] = &self.leaves {
            return if leaf.can_sample(given, lobes) {
                leaf.pdf(end, given, other, lobes)
            } else {
                0.0
            };
        }
        let (mut sum, mut total) = (0.0, 0.0);
        for (leaf, weight) in self.weighted_leaves(given, lobes) {
            sum += weight * leaf.pdf(end, given, other, lobes);
            total += weight;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }

    /// `f |wi·ns|` of `lobes` by class, and the density of sampling `wi` given `wo`. Directions in the shading frame.
    #[inline]
    pub(super) fn respond_local(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let mut sum = Response::NONE;
        let mut total = 0.0;
        for (leaf, weight) in self.weighted_leaves(wo, lobes) {
            let Response { values, pdf } = leaf.respond(wi, wo, lobes);
            sum.values.add(&values, leaf.weight);
            sum.pdf += pdf * weight;
            total += weight;
        }
        if total > 0.0 {
            sum.pdf /= total;
        }
        sum
    }
}
