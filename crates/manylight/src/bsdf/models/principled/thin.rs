//! The Disney model of thin surfaces, as Mitsuba 3's `principledthin`: both sides are alike, and
//! light is transmitted without refraction.
//!
//! Source: Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering",
//! 2015, section 5.3. Where it leaves a choice, it is Mitsuba 3's, except that Mitsuba 3.9.1 drops
//! light transmitted to directions above the facet that transmits it, which is not reciprocal.

use super::layers::Layers;
use super::sampling::{MIN_SCHLICK, SHEEN_ALBEDO};
use super::{PrincipledFront, disney_facets, least_glossy, luminance_tint};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::models::fresnel::{self, reflect};
use crate::bsdf::models::microfacet::Microfacets;
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, Mask, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes,
};
use crate::math::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// Parameters at a point; names as in
/// [`PrincipledThinMaterial`](crate::bsdf::material::PrincipledThinMaterial).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledThinParameters<S: Width> {
    pub base_color: Color<S>,
    pub roughness: Float<S>,
    pub anisotropic: Float<S>,
    pub spec_trans: Float<S>,
    pub eta: Float<S>,
    pub spec_tint: Float<S>,
    pub sheen: Float<S>,
    pub sheen_tint: Float<S>,
    pub flatness: Float<S>,
    pub diff_trans: Float<S>,
}

in_lanes!(PrincipledThinParameters {
    base_color,
    roughness,
    anisotropic,
    spec_trans,
    eta,
    spec_tint,
    sheen,
    sheen_tint,
    flatness,
    diff_trans,
});

/// The model at a point: diffuse reflection with retro-reflection, flatness and sheen; Lambertian
/// transmission; microfacet reflection and transmission, the latter mirrored at the surface with a
/// roughness that follows the index of refraction.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledThin<S: Width> {
    p: PrincipledThinParameters<S>,
    /// Facets of the reflection.
    facets: Microfacets<S>,
    /// Facets of the transmission.
    through: Microfacets<S>,
    /// Transmitted fraction of the diffuse part, in [0, 1].
    diffuse_through: Float<S>,
}

in_lanes!(PrincipledThin {
    p,
    facets,
    through,
    diffuse_through
});

/// Unnormalized probabilities of the sampling strategies.
struct Strategies<S: Width> {
    diffuse: Float<S>,
    diffuse_through: Float<S>,
    specular: Float<S>,
    specular_through: Float<S>,
}

impl<S: Width> Strategies<S> {
    #[inline(always)]
    fn total(&self) -> Float<S> {
        self.diffuse + self.diffuse_through + self.specular + self.specular_through
    }
}

/// `w` mirrored at the surface if it is below.
#[inline(always)]
fn upwards<S: Width>(w: Vector<S>) -> Vector<S> {
    Vector { z: w.z.abs(), ..w }
}

impl<S: Width> PrincipledThin<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(p: PrincipledThinParameters<S>) -> Self {
        // Burley 2015, figure 15.
        let scaled = (0.65 * p.eta - 0.35) * p.roughness;
        PrincipledThin {
            facets: disney_facets(p.roughness, p.anisotropic),
            through: disney_facets(scaled, p.anisotropic),
            diffuse_through: (0.5 * p.diff_trans).clamp(0.0, 1.0),
            p,
        }
    }

    #[inline(always)]
    fn has_specular(&self) -> Mask<S> {
        self.p.spec_trans.gt(0.0)
    }

    /// Reflection by `lobes`.
    #[inline(always)]
    fn front(&self, lobes: Classes<S>) -> PrincipledFront<S> {
        let p = &self.p;
        let interface = lobes.has(self.facets.class()).select(p.spec_trans, 0.0);
        let reflected = (1.0 - p.spec_trans) * (1.0 - self.diffuse_through);
        let diffuse = lobes.glossy.select(reflected, 0.0);
        let r0 = ((p.eta - 1.0) / (p.eta + 1.0)).squared();
        let tint = luminance_tint(p.base_color);
        let sheen = tint.map(|v| (1.0 - p.sheen_tint) + v * p.sheen_tint);
        let zero = p.eta.same(0.0);
        PrincipledFront {
            eta: p.eta,
            inv_eta: p.eta.recip(),
            plain: interface * (1.0 - p.spec_tint),
            schlick: interface * p.spec_tint,
            schlick_r0: tint * (interface * p.spec_tint * r0),
            base: p.base_color * (diffuse * FRAC_1_PI),
            sheen: sheen * (p.sheen * diffuse),
            roughness: p.roughness,
            flatness: p.flatness,
            clearcoat: zero,
            clearcoat_excess: zero,
            clearcoat_norm: zero,
            layers: Layers::none(zero.width()),
        }
    }

    /// Factor of the microfacet transmission by `lobes`, without Fresnel's factor.
    #[inline(always)]
    fn specular_through(&self, lobes: Classes<S>) -> Color<S> {
        let weight = lobes
            .has(self.through.class())
            .select(self.p.spec_trans, 0.0);
        self.p.base_color * weight
    }

    /// Factor of the cosine in the diffuse transmission by `lobes`.
    #[inline(always)]
    fn diffuse_through(&self, lobes: Classes<S>) -> Color<S> {
        let weight = (1.0 - self.p.spec_trans) * self.diffuse_through * FRAC_1_PI;
        self.p.base_color * lobes.glossy.select(weight, 0.0)
    }

    /// Probabilities for a given direction of this cosine: estimates of the light that each lobe
    /// returns.
    #[inline(always)]
    fn strategies(&self, cos: Float<S>, lobes: Classes<S>) -> Strategies<S> {
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
}

impl<S: Width> ScatteringModel<S> for PrincipledThin<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        let has_diffuse = self.p.spec_trans.lt(1.0);
        let glossy = Classes::splat(has_diffuse.width(), Lobes::GLOSSY);
        let specular = self.facets.class().or(self.through.class());
        glossy
            .within(has_diffuse)
            .or(specular.within(self.has_specular()))
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        self.strategies(cos, lobes).total()
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let product = wi.z * wo.z;
        let (reflects, transmits) = (product.gt(0.0), product.lt(0.0));
        let pdf = self.pdf(wo, wi, lobes);
        let (wi, wo) = (upwards(wi), upwards(wo));
        let seen = self.facets.seen(wo);
        let front = self.front(lobes).parts::<true>(&self.facets, wi, wo, seen);
        let class = self.facets.class();
        let mut values = ByClass::of_microfacets(class, lobes, front.interface);
        values.glossy += front.diffuse;
        let mut values = values.map(|v| v.within(reflects));

        let half = wi + wo;
        let cos = 0.5 * half.length();
        let passed = 1.0 - fresnel::dielectric(cos, self.p.eta).reflectance;
        let density = self.through.visible_density(wi, half) * self.through.seen(wo);
        let specular = self.specular_through(lobes) * (passed * density);
        let class = self.through.class();
        let mut through = ByClass::of_microfacets(class, lobes, specular);
        through.glossy += self.diffuse_through(lobes) * wi.z;
        values.add(&through.map(|v| v.within(transmits)), wi.z.same(1.0));
        Response { values, pdf }
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let product = given.z * other.z;
        let reflects = product.gt(0.0);
        let s = self.strategies(given.z, lobes);
        let total = s.total();
        let (given, other) = (upwards(given), upwards(other));
        let m = (given + other).normalize();
        let diffuse = reflects.select(s.diffuse, s.diffuse_through);
        let near = s.specular * self.facets.reflected_pdf(given, m);
        let far = s.specular_through * self.through.reflected_pdf(given, m);
        let weight = reflects.select(s.specular, s.specular_through);
        let specular = weight.gt(0.0).select(reflects.select(near, far), 0.0);
        let pdf = diffuse * cosine_hemisphere_pdf(other.z) + specular;
        let valid = total.gt(0.0) & !product.equals(0.0);
        valid.select(pdf / total, 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        let side = given.z.sign();
        let valid = !given.z.equals(0.0);
        let given = upwards(given);
        let s = self.strategies(given.z, lobes);
        let total = s.total();
        let chosen = u.lobe * total;
        let diffuse = s.diffuse + s.diffuse_through;
        let of_base = chosen.lt(diffuse);
        let of_interface = chosen.lt(diffuse + s.specular);
        let reflects = (of_base & chosen.lt(s.diffuse)) | (of_interface & !of_base);
        let mut w = cosine_hemisphere(u.direction);
        if !of_base.all() {
            let near = self.facets.sample(given, u.direction);
            let far = self.through.sample(given, u.direction);
            let facet = reflect(given, Vector::select(reflects, near, far));
            w = Vector::select(of_base, w, facet);
        }
        let valid = valid & w.z.gt(0.0) & total.gt(0.0);
        ModelSample::finite(w.scale_z(reflects.select(side, -side)), valid)
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        let least = least_glossy([self.facets.min_alpha(), self.through.min_alpha()]);
        self.has_specular().select(least, 1.0)
    }

    #[inline(always)]
    fn transmits(&self) -> Mask<S> {
        Mask::splat(self.lobes().glossy.width(), true)
    }
}

impl PrincipledThin<One> {
    /// Upper bound of the transmission over a cone that has been mirrored to the side of `wo`,
    /// above the surface.
    fn bound_through(&self, mirrored: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = mirrored.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        let factor = self.diffuse_through(lobes.into()).max_channel().get();
        let specular = self.specular_through(lobes.into()).max_channel().get();
        let halves = mirrored.halves(wo);
        let density = self.through.projected_bound(halves.highest, mirrored)
            * self.through.seen(wo.into()).get();
        factor * mirrored.projection(cos) + specular * density
    }
}

impl ModelBound for PrincipledThin<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z == 0.0 {
            return 0.0;
        }
        let on_side = |w: Vec3, side: f32| Vec3::new(w.x, w.y, w.z * side);
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let near = incident.map(|w| on_side(w, side));
        let far = incident.map(|w| on_side(w, -side));
        let seen = self.facets.seen(wo.into()).get();
        let front = self.front(lobes.into());
        front.bound(&self.facets, &near, wo, seen) + self.bound_through(&far, wo, lobes)
    }
}
