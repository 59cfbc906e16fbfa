//! The Disney model of thin surfaces, as Mitsuba 3's `principledthin`: both sides are alike, and light is transmitted without refraction.
//!
//! Source: Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", 2015, section 5.3. Where it leaves a
//! choice, it is Mitsuba 3's, except that Mitsuba 3.9.1 drops light transmitted to directions above the facet that transmits it, which is
//! not reciprocal.

use super::sampling::{MIN_SCHLICK, SHEEN_ALBEDO};
use super::{PrincipledFront, disney_facets, luminance_tint};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::model_sample::ModelSample;
use crate::bsdf::models::fresnel::{self, reflect};
use crate::bsdf::models::microfacet::Microfacets;
use crate::bsdf::{BsdfNumbers, Lobes, NEAR_DELTA_ALPHA};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, PI};

/// Parameters at a point; names as in [`PrincipledThinMaterial`](crate::bsdf::material::PrincipledThinMaterial).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledThinParameters {
    pub base_color: Rgb,
    pub roughness: f32,
    pub anisotropic: f32,
    pub spec_trans: f32,
    pub eta: f32,
    pub spec_tint: f32,
    pub sheen: f32,
    pub sheen_tint: f32,
    pub flatness: f32,
    pub diff_trans: f32,
}

/// The model at a point: diffuse reflection with retro-reflection, flatness and sheen; Lambertian transmission; microfacet reflection and
/// transmission, the latter mirrored at the surface with a roughness that follows the index of refraction.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledThin {
    p: PrincipledThinParameters,
    /// Facets of the reflection.
    facets: Microfacets,
    /// Facets of the transmission.
    through: Microfacets,
    /// Transmitted fraction of the diffuse part, in [0, 1].
    diffuse_through: f32,
}

/// Unnormalized probabilities of the sampling strategies.
struct Strategies {
    diffuse: f32,
    diffuse_through: f32,
    specular: f32,
    specular_through: f32,
}

impl Strategies {
    fn total(&self) -> f32 {
        self.diffuse + self.diffuse_through + self.specular + self.specular_through
    }
}

/// `w` mirrored at the surface if it is on the other side than `side`, a sign.
#[inline]
fn on_side(w: Vec3, side: f32) -> Vec3 {
    Vec3::new(w.x, w.y, w.z * side)
}

impl PrincipledThin {
    pub(in crate::bsdf) fn new(p: PrincipledThinParameters) -> Self {
        // Burley 2015, figure 15.
        let scaled = (0.65 * p.eta - 0.35) * p.roughness;
        PrincipledThin {
            facets: disney_facets(p.roughness, p.anisotropic),
            through: disney_facets(scaled, p.anisotropic),
            diffuse_through: (0.5 * p.diff_trans).clamp(0.0, 1.0),
            p,
        }
    }

    #[inline]
    fn has_specular(&self) -> bool {
        self.p.spec_trans > 0.0
    }

    #[inline]
    fn has_diffuse(&self) -> bool {
        self.p.spec_trans < 1.0
    }

    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        let mut lobes = Lobes::NONE;
        if self.has_diffuse() {
            lobes = lobes.or(Lobes::GLOSSY);
        }
        if self.has_specular() {
            for facets in [&self.facets, &self.through] {
                lobes = lobes.or(microfacet_class(facets.min_alpha()));
            }
        }
        lobes
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes; 1 without such lobes.
    pub(in crate::bsdf) fn glossy_alpha(&self) -> f32 {
        if !self.has_specular() {
            return 1.0;
        }
        [self.facets.min_alpha(), self.through.min_alpha()]
            .into_iter()
            .filter(|&a| a >= NEAR_DELTA_ALPHA)
            .fold(1.0, f32::min)
    }

    /// Reflection by `lobes`.
    fn front(&self, lobes: Lobes) -> PrincipledFront {
        let p = &self.p;
        let interface = lobes.pick(microfacet_class(self.facets.min_alpha()), p.spec_trans);
        let diffuse = lobes.pick(
            Lobes::GLOSSY,
            (1.0 - p.spec_trans) * (1.0 - self.diffuse_through),
        );
        let r0 = ((p.eta - 1.0) / (p.eta + 1.0)).powi(2);
        let tint = luminance_tint(p.base_color);
        PrincipledFront {
            eta: p.eta,
            inv_eta: p.eta.recip(),
            plain: interface * (1.0 - p.spec_tint),
            schlick: interface * p.spec_tint,
            schlick_r0: tint * (interface * p.spec_tint * r0),
            base: p.base_color * (diffuse * FRAC_1_PI),
            sheen: Rgb::WHITE.lerp(tint, p.sheen_tint) * (p.sheen * diffuse),
            roughness: p.roughness,
            flatness: p.flatness,
            layered: 0.0,
            clearcoat: 0.0,
            clearcoat_excess: 0.0,
            clearcoat_norm: 0.0,
        }
    }

    /// Factor of the microfacet transmission by `lobes`, without Fresnel's factor.
    fn specular_through(&self, lobes: Lobes) -> Rgb {
        let class = microfacet_class(self.through.min_alpha());
        self.p.base_color * lobes.pick(class, self.p.spec_trans)
    }

    /// Factor of the cosine in the diffuse transmission by `lobes`.
    fn diffuse_through(&self, lobes: Lobes) -> Rgb {
        let weight = (1.0 - self.p.spec_trans) * self.diffuse_through * FRAC_1_PI;
        self.p.base_color * lobes.pick(Lobes::GLOSSY, weight)
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if wi.z * wo.z == 0.0 {
            return Rgb::BLACK;
        }
        let reflects = wi.z * wo.z > 0.0;
        let side = 1.0f32.copysign(wo.z);
        let (wi, wo) = (on_side(wi, 1.0f32.copysign(wi.z)), on_side(wo, side));
        if reflects {
            let seen = self.facets.seen(wo);
            return self.front(lobes).eval::<true>(&self.facets, wi, wo, seen);
        }
        let diffuse = self.diffuse_through(lobes) * wi.z;
        let specular = self.specular_through(lobes);
        if specular.is_black() {
            return diffuse;
        }
        let half = wi + wo;
        let cos = 0.5 * half.length();
        let passed = 1.0 - fresnel::dielectric(cos, self.p.eta).reflectance;
        let density = self.through.visible_density(wi, half) * self.through.seen(wo);
        diffuse + specular * (passed * density)
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z == 0.0 {
            return 0.0;
        }
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let near = incident.map(|w| on_side(w, side));
        let far = incident.map(|w| on_side(w, -side));
        let seen = self.facets.seen(wo);
        let front = self.front(lobes);
        front.bound(&self.facets, &near, wo, seen) + self.bound_through(&far, wo, lobes)
    }

    /// Upper bound of the transmission over a cone that has been mirrored to the side of `wo`, above the surface.
    fn bound_through(&self, mirrored: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = mirrored.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        let diffuse = self.diffuse_through(lobes).max_channel() * mirrored.projection(cos);
        let specular = self.specular_through(lobes).max_channel();
        let halves = mirrored.halves(wo);
        let density =
            self.through.projected_bound(halves.highest, mirrored) * self.through.seen(wo);
        diffuse + specular * density
    }

    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        self.strategies(cos, lobes).total()
    }

    /// Probabilities for a given direction of this cosine: estimates of the light that each lobe returns.
    fn strategies(&self, cos: f32, lobes: Lobes) -> Strategies {
        let cos = cos.abs();
        let front = self.front(lobes);
        let passed = 1.0 - fresnel::dielectric(cos, self.p.eta).reflectance;
        Strategies {
            diffuse: PI * front.base.max_channel() + SHEEN_ALBEDO * front.sheen.max_channel(),
            diffuse_through: PI * self.diffuse_through(lobes).max_channel(),
            specular: front.interface_reflectance(cos, MIN_SCHLICK).max_channel(),
            // Facets transmit at other angles than that to the surface normal.
            specular_through: self.specular_through(lobes).max_channel() * passed.max(MIN_SCHLICK),
        }
    }

    /// See [`Model::pdf`](crate::bsdf::model::Model::pdf).
    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z * other.z == 0.0 {
            return 0.0;
        }
        let strategies = self.strategies(given.z, lobes);
        let total = strategies.total();
        if total == 0.0 {
            return 0.0;
        }
        let reflects = given.z * other.z > 0.0;
        let given = on_side(given, 1.0f32.copysign(given.z));
        let other = on_side(other, 1.0f32.copysign(other.z));
        let m = (given + other).normalize();
        let (diffuse, specular, facets) = if reflects {
            (strategies.diffuse, strategies.specular, &self.facets)
        } else {
            let s = &strategies;
            (s.diffuse_through, s.specular_through, &self.through)
        };
        let mut pdf = diffuse * warp::cosine_hemisphere_pdf(other.z);
        if specular > 0.0 {
            pdf += specular * facets.reflected_pdf(given, m);
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
        let side = 1.0f32.copysign(given.z);
        let given = on_side(given, side);
        let s = self.strategies(given.z, lobes);
        let chosen = u.lobe * s.total();
        let diffuse = s.diffuse + s.diffuse_through;
        let (w, reflects) = if chosen < diffuse {
            (warp::cosine_hemisphere(u.direction), chosen < s.diffuse)
        } else {
            let reflects = chosen < diffuse + s.specular;
            let facets = if reflects {
                &self.facets
            } else {
                &self.through
            };
            (reflect(given, facets.sample(given, u.direction)), reflects)
        };
        let sign = if reflects { side } else { -side };
        (w.z > 0.0 && s.total() > 0.0).then(|| ModelSample::finite(on_side(w, sign)))
    }
}
