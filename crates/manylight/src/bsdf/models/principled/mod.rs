//! The Disney model, as Mitsuba 3's `principled`.
//!
//! Sources: Burley, "Physically Based Shading at Disney", 2012, and "Extending the Disney BRDF to a BSDF with Integrated
//! Subsurface Scattering", 2015. Where these leave a choice, it is Mitsuba 3's.

mod front;
mod sampling;
mod terms;
mod thin;

pub(in crate::bsdf) use front::{PrincipledFront, PrincipledFrontLanes};
pub(in crate::bsdf) use thin::{PrincipledThin, PrincipledThinParameters};

use super::dielectric::{HalfVector, interface_bounds};
use super::fresnel;
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::material::Distribution;
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::{Lobes, NEAR_DELTA_ALPHA};
use crate::color::Rgb;
use crate::math::{Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_1_PI, PI};

/// Smallest roughness alpha of the main interface, as in Mitsuba 3.
const MIN_ALPHA: f32 = 1e-3;
/// Roughness alpha of the clear coat for a gloss of 0 and of 1 (Burley 2012).
const CLEARCOAT_ALPHA: [f32; 2] = [0.1, 0.001];
/// Factor of the clear coat (Burley 2012).
pub(super) const CLEARCOAT_SCALE: f32 = 0.25;

/// Parameters at a point; names as in [`PrincipledMaterial`](crate::bsdf::material::PrincipledMaterial).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledParameters {
    pub base_color: Rgb,
    pub roughness: f32,
    pub anisotropic: f32,
    pub metallic: f32,
    pub spec_trans: f32,
    pub eta: f32,
    pub spec_tint: f32,
    pub sheen: f32,
    pub sheen_tint: f32,
    pub flatness: f32,
    pub clearcoat: f32,
    pub clearcoat_gloss: f32,
    pub layered: bool,
    pub diffuse_rate: f32,
    pub specular_rate: f32,
    pub clearcoat_rate: f32,
}

/// The model at a point: a diffuse lobe with retro-reflection, an approximation of subsurface scattering (`flatness`) and sheen; the main
/// interface, a microfacet lobe between conductor and dielectric; a clear coat.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Principled {
    base_color: Rgb,
    facets: Microfacets,
    roughness: f32,
    metallic: f32,
    /// Weight of the opaque dielectric.
    brdf: f32,
    /// Weight of the transparent dielectric.
    bsdf: f32,
    eta: f32,
    spec_tint: f32,
    /// The parameter times `1 - metallic`.
    sheen: f32,
    sheen_tint: f32,
    flatness: f32,
    clearcoat: f32,
    clearcoat_alpha: f32,
    /// Normalization of the clear coat's distribution; see [`terms::gtr1`].
    clearcoat_norm: f32,
    layered: bool,
    diffuse_rate: f32,
    specular_rate: f32,
    clearcoat_rate: f32,
}

/// The facets of a Disney model, GGX with `alpha = roughness²` and an aspect ratio by `anisotropic`.
fn disney_facets(roughness: f32, anisotropic: f32) -> Microfacets {
    let alpha = roughness * roughness;
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    Microfacets::new(
        Distribution::Ggx,
        (alpha / aspect).max(MIN_ALPHA),
        (alpha * aspect).max(MIN_ALPHA),
    )
}

/// A color over its luminance; white for black.
fn luminance_tint(color: Rgb) -> Rgb {
    let luminance = color.luminance();
    if luminance > 0.0 {
        color / luminance
    } else {
        Rgb::WHITE
    }
}

impl Principled {
    /// Whether the main interface transmits.
    pub(in crate::bsdf) fn transmits(&self) -> bool {
        self.bsdf > 0.0
    }

    pub(in crate::bsdf) fn new(p: PrincipledParameters) -> Self {
        let [dull, glossy] = CLEARCOAT_ALPHA;
        let clearcoat_alpha = dull + (glossy - dull) * p.clearcoat_gloss;
        let a2 = clearcoat_alpha * clearcoat_alpha;
        Principled {
            base_color: p.base_color,
            facets: disney_facets(p.roughness, p.anisotropic),
            roughness: p.roughness,
            metallic: p.metallic,
            brdf: (1.0 - p.metallic) * (1.0 - p.spec_trans),
            bsdf: (1.0 - p.metallic) * p.spec_trans,
            eta: p.eta,
            spec_tint: p.spec_tint,
            sheen: p.sheen * (1.0 - p.metallic),
            sheen_tint: p.sheen_tint,
            flatness: p.flatness,
            clearcoat: p.clearcoat,
            clearcoat_alpha,
            clearcoat_norm: (a2 - 1.0) / (PI * a2.ln()),
            layered: p.layered,
            diffuse_rate: p.diffuse_rate,
            specular_rate: p.specular_rate,
            clearcoat_rate: p.clearcoat_rate,
        }
    }

    #[inline]
    fn has_diffuse(&self) -> bool {
        self.brdf > 0.0 || self.sheen > 0.0
    }

    #[inline]
    fn specular_class(&self) -> Lobes {
        microfacet_class(self.facets.min_alpha())
    }

    #[inline]
    fn clearcoat_class(&self) -> Lobes {
        microfacet_class(self.clearcoat_alpha)
    }

    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        let mut lobes = self.specular_class();
        if self.has_diffuse() {
            lobes = lobes.or(Lobes::GLOSSY);
        }
        if self.clearcoat > 0.0 {
            lobes = lobes.or(self.clearcoat_class());
        }
        lobes
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes; 1 without such lobes.
    pub(in crate::bsdf) fn glossy_alpha(&self) -> f32 {
        let clearcoat = if self.clearcoat > 0.0 {
            self.clearcoat_alpha
        } else {
            1.0
        };
        [self.facets.min_alpha(), clearcoat]
            .into_iter()
            .filter(|&a| a >= NEAR_DELTA_ALPHA)
            .fold(1.0, f32::min)
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let Some(half) = HalfVector::new(wo, wi, self.eta) else {
            return Rgb::BLACK;
        };
        self.eval_by(&half, wi, wo, lobes)
    }

    /// See [`Model::respond`](crate::bsdf::model::Model::respond).
    pub(in crate::bsdf) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let Some(half) = HalfVector::new(wo, wi, self.eta) else {
            return Response::NONE;
        };
        Response {
            values: ByClass::of(self.lobes().and(lobes), |class| {
                self.eval_by(&half, wi, wo, class)
            }),
            pdf: self.pdf_by(&half, wo, wi, lobes),
        }
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z == 0.0 {
            return 0.0;
        }
        let mut bound = 0.0;
        if wo.z > 0.0 {
            let seen = self.facets.seen(wo);
            bound += self.front(lobes).bound(&self.facets, incident, wo, seen);
        }
        if self.transmits() && lobes.has(self.specular_class()) {
            let [reflected, transmitted] = interface_bounds(&self.facets, self.eta, incident, wo);
            if wo.z < 0.0 {
                bound += self.bsdf * reflected;
            }
            bound += self.bsdf * safe_sqrt(self.base_color.max_channel()) * transmitted;
        }
        bound
    }

    /// The value for two directions with this half vector.
    fn eval_by(&self, half: &HalfVector, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if half.reflects && wo.z > 0.0 {
            let front = self.front(lobes);
            let seen = self.facets.seen(wo);
            return if front.has_extras() {
                front.eval::<true>(&self.facets, wi, wo, seen)
            } else {
                front.eval::<false>(&self.facets, wi, wo, seen)
            };
        }
        if lobes.has(self.specular_class()) {
            self.specular(wi, wo, half)
        } else {
            Rgb::BLACK
        }
    }

    /// Reflection by `lobes` on the front.
    pub(in crate::bsdf) fn front(&self, lobes: Lobes) -> PrincipledFront {
        let weight = |class: Lobes| if lobes.has(class) { 1.0 } else { 0.0 };
        let (interface, diffuse) = (weight(self.specular_class()), weight(Lobes::GLOSSY));
        let tinted = (1.0 - self.metallic) * self.spec_tint;
        let r0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let tint = luminance_tint(self.base_color);
        let schlick_r0 = self.base_color * self.metallic + tint * (r0 * tinted);
        let sheen = Rgb::WHITE.lerp(tint, self.sheen_tint);
        PrincipledFront {
            eta: self.eta,
            inv_eta: self.eta.recip(),
            plain: (1.0 - self.metallic) * (1.0 - self.spec_tint) * interface,
            schlick: (self.metallic + tinted) * interface,
            schlick_r0: schlick_r0 * interface,
            base: self.base_color * (self.brdf * FRAC_1_PI * diffuse),
            sheen: sheen * (self.sheen * diffuse),
            roughness: self.roughness,
            flatness: self.flatness,
            layered: if self.layered { 1.0 } else { 0.0 },
            clearcoat: self.clearcoat * CLEARCOAT_SCALE * weight(self.clearcoat_class()),
            clearcoat_excess: self.clearcoat_excess(),
            clearcoat_norm: self.clearcoat_norm,
        }
    }

    /// Microfacets of the main interface.
    pub(in crate::bsdf) fn facets(&self) -> &Microfacets {
        &self.facets
    }

    /// See [`terms::gtr1`].
    fn clearcoat_excess(&self) -> f32 {
        self.clearcoat_alpha * self.clearcoat_alpha - 1.0
    }

    /// The main interface: transmission, and reflection on the back.
    fn specular(&self, wi: Vec3, wo: Vec3, half: &HalfVector) -> Rgb {
        if self.bsdf == 0.0 {
            return Rgb::BLACK;
        }
        let m = half.m;
        let r = fresnel::dielectric(wo.dot(m), self.eta).reflectance;
        let masking = self.facets.masking(wi, m) * self.facets.masking(wo, m);
        let common = self.bsdf * self.facets.density(m) * masking / wo.z.abs();
        if half.reflects {
            return Rgb::splat(0.25 * common * r);
        }
        let (i, o) = (wi.dot(m), wo.dot(m));
        let scale = (1.0 - r) * common * (i * o).abs() / (o + half.eta * i).powi(2);
        self.base_color.map(safe_sqrt) * scale
    }
}
