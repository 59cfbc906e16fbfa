//! The Disney model in the form of Mitsuba 3's `principled`.
//!
//! Sources: Burley, "Physically Based Shading at Disney", 2012, and "Extending the Disney BRDF to a BSDF with Integrated
//! Subsurface Scattering", 2015. Where the two leave a choice, Mitsuba 3's is taken.

use super::bound::Arriving;
use super::dielectric::{Half, interface_bounds};
use super::fresnel::{self, reflect, refract};
use super::material::Distribution;
use super::microfacet::Microfacets;
use super::model::{ModelSample, microfacet_class};
use super::principled_front::Front;
use super::response::{ByClass, Response};
use super::{BsdfNumbers, Lobes, NEAR_DELTA_ALPHA};
use crate::color::Rgb;
use crate::math::trig::sin_cos_turns;
use crate::math::{Vec2, Vec3, float::safe_sqrt};
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, PI};

/// Smallest microfacet roughness.
const MIN_ALPHA: f32 = 1e-3;
/// The clear coat's roughness where its gloss is 0 and 1.
const CLEARCOAT_ALPHA: [f32; 2] = [0.1, 0.001];
/// What a full clear coat is scaled by.
const CLEARCOAT_SCALE: f32 = 0.25;

/// Parameters at a point; names as in [`PrincipledMaterial`](super::material::PrincipledMaterial).
#[derive(Clone, Copy, Debug)]
pub(super) struct PrincipledParameters {
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
    pub diffuse_rate: f32,
    pub specular_rate: f32,
    pub clearcoat_rate: f32,
}

/// Diffuse with retro-reflection, flattened towards a fake subsurface term, sheen, one microfacet interface between metal
/// and glass, and a clear coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Principled {
    base_color: Rgb,
    luminance: f32,
    facets: Microfacets,
    roughness: f32,
    metallic: f32,
    /// Weight of the opaque dielectric.
    brdf: f32,
    /// Weight of the transparent dielectric.
    bsdf: f32,
    eta: f32,
    spec_tint: f32,
    /// Times one minus metallic.
    sheen: f32,
    sheen_tint: f32,
    flatness: f32,
    clearcoat: f32,
    clearcoat_alpha: f32,
    /// See [`Front`].
    clearcoat_norm: f32,
    diffuse_rate: f32,
    specular_rate: f32,
    clearcoat_rate: f32,
}

/// Relative probabilities of the sampling strategies.
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
    /// Whether light passes to the other side.
    pub(super) fn transmits(&self) -> bool {
        self.bsdf > 0.0
    }

    pub(super) fn new(p: PrincipledParameters) -> Self {
        let alpha = p.roughness * p.roughness;
        let aspect = (1.0 - 0.9 * p.anisotropic).sqrt();
        let facets = Microfacets::new(
            Distribution::Ggx,
            (alpha / aspect).max(MIN_ALPHA),
            (alpha * aspect).max(MIN_ALPHA),
        );
        let [dull, glossy] = CLEARCOAT_ALPHA;
        let clearcoat_alpha = dull + (glossy - dull) * p.clearcoat_gloss;
        let a2 = clearcoat_alpha * clearcoat_alpha;
        Principled {
            base_color: p.base_color,
            luminance: p.base_color.luminance(),
            facets,
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
            diffuse_rate: p.diffuse_rate,
            specular_rate: p.specular_rate,
            clearcoat_rate: p.clearcoat_rate,
        }
    }

    /// Hue and saturation of the base.
    fn tint(&self) -> Rgb {
        if self.luminance > 0.0 {
            self.base_color / self.luminance
        } else {
            Rgb::WHITE
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

    pub(super) fn lobes(&self) -> Lobes {
        let mut lobes = self.specular_class();
        if self.has_diffuse() {
            lobes = lobes.or(Lobes::GLOSSY);
        }
        if self.clearcoat > 0.0 {
            lobes = lobes.or(self.clearcoat_class());
        }
        lobes
    }

    /// Roughness of the narrowest `GLOSSY` lobe.
    pub(super) fn glossy_alpha(&self) -> f32 {
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

    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let Some(half) = Half::new(wo, wi, self.eta) else {
            return Rgb::BLACK;
        };
        self.eval_by(&half, wi, wo, lobes)
    }

    /// See [`Model::respond`](super::model::Model::respond).
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let Some(half) = Half::new(wo, wi, self.eta) else {
            return Response::NONE;
        };
        Response {
            values: ByClass::of(self.lobes().and(lobes), |class| {
                self.eval_by(&half, wi, wo, class)
            }),
            pdf: self.pdf_by(&half, wo, wi, lobes),
        }
    }

    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z == 0.0 {
            return 0.0;
        }
        let mut bound = 0.0;
        if wo.z > 0.0 {
            let seen = self.facets.seen(wo);
            bound += self.front(lobes).bound(&self.facets, arriving, wo, seen);
        }
        if self.transmits() && lobes.has(self.specular_class()) {
            let [reflected, transmitted] = interface_bounds(&self.facets, self.eta, arriving, wo);
            if wo.z < 0.0 {
                bound += self.bsdf * reflected;
            }
            bound += self.bsdf * safe_sqrt(self.base_color.max_channel()) * transmitted;
        }
        bound
    }

    fn eval_by(&self, half: &Half, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
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

    /// What the front reflects by way of `lobes`.
    pub(super) fn front(&self, lobes: Lobes) -> Front {
        let weight = |class: Lobes| if lobes.has(class) { 1.0 } else { 0.0 };
        let (interface, diffuse) = (weight(self.specular_class()), weight(Lobes::GLOSSY));
        let tinted = (1.0 - self.metallic) * self.spec_tint;
        let r0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let schlick_r0 = self.base_color * self.metallic + self.tint() * (r0 * tinted);
        let sheen = Rgb::WHITE.lerp(self.tint(), self.sheen_tint);
        Front {
            eta: self.eta,
            inv_eta: self.eta.recip(),
            plain: (1.0 - self.metallic) * (1.0 - self.spec_tint) * interface,
            schlick: (self.metallic + tinted) * interface,
            schlick_r0: schlick_r0 * interface,
            base: self.base_color * (self.brdf * FRAC_1_PI * diffuse),
            sheen: sheen * (self.sheen * diffuse),
            roughness: self.roughness,
            flatness: self.flatness,
            clearcoat: self.clearcoat * CLEARCOAT_SCALE * weight(self.clearcoat_class()),
            clearcoat_excess: self.clearcoat_excess(),
            clearcoat_norm: self.clearcoat_norm,
        }
    }

    /// The microfacets of the main interface.
    pub(super) fn facets(&self) -> &Microfacets {
        &self.facets
    }

    fn clearcoat_density(&self, cos_m: f32) -> f32 {
        gtr1(self.clearcoat_excess(), self.clearcoat_norm, cos_m)
    }

    fn clearcoat_excess(&self) -> f32 {
        self.clearcoat_alpha * self.clearcoat_alpha - 1.0
    }

    /// The main interface, but for reflection on the front.
    fn specular(&self, wi: Vec3, wo: Vec3, half: &Half) -> Rgb {
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

    /// From below only the interface is sampled.
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
        // With the rates that are left to the classes asked for, a lobe could be out of reach.
        if chosen.total() == 0.0 {
            chosen.diffuse = pick(Lobes::GLOSSY, 1.0);
            chosen.clearcoat = pick(self.clearcoat_class(), self.clearcoat);
            chosen.specular = pick(self.specular_class(), 1.0);
        }
        chosen
    }

    /// Given the interface, how likely transmission is chosen at a facet of reflectance `r`.
    #[inline]
    fn transmission_probability(&self, given: Vec3, r: f32) -> f32 {
        if given.z > 0.0 {
            self.bsdf * (1.0 - r)
        } else {
            1.0 - r
        }
    }

    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        Half::new(given, other, self.eta)
            .map_or(0.0, |half| self.pdf_by(&half, given, other, lobes))
    }

    fn pdf_by(&self, half: &Half, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
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

    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
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

    fn sample_clearcoat(&self, u: Vec2) -> Vec3 {
        let a2 = self.clearcoat_alpha * self.clearcoat_alpha;
        let cos2 = (1.0 - a2.powf(1.0 - u.y)) / (1.0 - a2);
        let sin = safe_sqrt(1.0 - cos2);
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        Vec3::new(cos_phi * sin, sin_phi * sin, safe_sqrt(cos2))
    }
}

/// (1 - cos)⁵.
#[inline(always)]
pub(super) fn schlick_weight(cos: f32) -> f32 {
    let x = (1.0 - cos).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Burley's GTR1 distribution, from `α² - 1` and `(α² - 1) / (π ln α²)`.
#[inline(always)]
pub(super) fn gtr1(excess: f32, norm: f32, cos_m: f32) -> f32 {
    let density = norm / (1.0 + excess * cos_m * cos_m);
    if density * cos_m > 1e-20 {
        density
    } else {
        0.0
    }
}

/// Smith's masking for an isotropic GGX surface.
#[inline(always)]
pub(super) fn ggx_masking(cos: f32, alpha: f32) -> f32 {
    let tan2 = (1.0 - cos * cos) / (cos * cos);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}
