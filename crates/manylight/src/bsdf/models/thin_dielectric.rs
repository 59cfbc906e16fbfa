//! A thin dielectric pane: two interfaces without a visible offset by refraction.
//!
//! A rough pane reflects at microfacets, and transmits by the same lobe mirrored at the surface, as
//! KHR_materials_transmission of glTF has it. Both sides are alike.

use super::dielectric::{FACET_REFLECTANCES, InterfaceTints};
use super::fresnel::{self, reflect};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width, in_lanes};
use crate::math::Vec3;

/// Reflectance of a pane at the cosine `cos`. Its index of refraction is `eta`, relative to the
/// medium on both sides.
#[inline(always)]
fn pane_reflectance<S: Width>(cos: Float<S>, eta: f32) -> Float<S> {
    with_internal_reflections(interface_reflectance(cos, eta))
}

/// Reflectance of one of its two interfaces.
#[inline(always)]
fn interface_reflectance<S: Width>(cos: Float<S>, eta: f32) -> Float<S> {
    fresnel::dielectric(cos.abs(), cos.same(eta)).reflectance
}

/// Reflectance of two interfaces that reflect the fraction `r` each:
/// r + t r t + t r³ t + ... = 2r / (1 + r).
#[inline(always)]
fn with_internal_reflections<S: Width>(r: Float<S>) -> Float<S> {
    2.0 * r / (1.0 + r)
}

/// Mirror reflection on both sides, and straight-through transmission.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct ThinDielectric<S: Width> {
    pub eta: f32,
    pub tints: InterfaceTints<S>,
}

in_lanes!(ThinDielectric { tints; eta });

impl<S: Width> ThinDielectric<S> {
    /// Straight-through transmittance at the cosine `cos`.
    #[inline(always)]
    pub(in crate::bsdf) fn transmittance(&self, cos: Float<S>) -> Color<S> {
        self.tints.transmission * (1.0 - pane_reflectance(cos, self.eta))
    }
}

impl<S: Width> ScatteringModel<S> for ThinDielectric<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.tints.reflection.r.width(), Lobes::DELTA)
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        self.tints.reflection.max_channel() * pane_reflectance(cos, self.eta)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, _: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let fraction = self.tints.reflection * pane_reflectance(given.z, self.eta);
        let everywhere = Mask::splat(given.z.width(), true);
        ModelSample::mirror(given, fraction, given.z.same(1.0), everywhere)
    }
}

impl ModelBound for ThinDielectric<One> {}

/// Reflection at microfacets on both sides, and transmission by the mirrored lobe.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughThinDielectric<S: Width> {
    pub facets: Microfacets<S>,
    pub eta: f32,
    pub tints: InterfaceTints<S>,
}

in_lanes!(RoughThinDielectric { facets, tints; eta });

/// `w` mirrored at the surface if it is below.
#[inline(always)]
fn upwards<S: Width>(w: Vector<S>) -> Vector<S> {
    Vector { z: w.z.abs(), ..w }
}

impl<S: Width> RoughThinDielectric<S> {
    /// Probability of sampling reflection at a facet with the cosine `cos` to the given direction,
    /// and the lanes in which the pane returns any light.
    #[inline(always)]
    fn reflection_probability(&self, cos: Float<S>) -> (Float<S>, Mask<S>) {
        self.tints
            .reflection_probability(pane_reflectance(cos, self.eta))
    }
}

impl<S: Width> ScatteringModel<S> for RoughThinDielectric<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        self.facets.class()
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        let [least, most] = FACET_REFLECTANCES;
        let r = interface_reflectance(cos, self.eta).clamp(least, most);
        self.tints.albedo_estimate(with_internal_reflections(r))
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let product = wi.z * wo.z;
        let valid = !product.equals(0.0) & lobes.has(self.lobes());
        if valid.none() {
            return Response::none(wi.z.width());
        }
        let pdf = self.pdf(wo, wi, lobes);
        let (wi, wo) = (upwards(wi), upwards(wo));
        let half = wi + wo;
        // |wi + wo| = 2 wo·m for unit vectors.
        let r = pane_reflectance(0.5 * half.length(), self.eta);
        let density = self.facets.visible_density(wi, half) * self.facets.seen(wo);
        let reflected = self.tints.reflection * (r * density);
        let transmitted = self.tints.transmission * ((1.0 - r) * density);
        let value = Color::select(product.gt(0.0), reflected, transmitted);
        Response {
            values: ByClass::of_microfacets(self.lobes(), lobes, value),
            pdf,
        }
        .within(valid)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let product = given.z * other.z;
        let (given, other) = (upwards(given), upwards(other));
        let m = (given + other).normalize();
        let (reflection, returns_light) = self.reflection_probability(given.dot(m));
        let event = product.gt(0.0).select(reflection, 1.0 - reflection);
        let valid = returns_light & !product.equals(0.0) & lobes.has(self.lobes());
        valid.select(event * self.facets.reflected_pdf(given, m), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let side = given.z.sign();
        let valid = !given.z.equals(0.0);
        let given = upwards(given);
        let m = self.facets.sample(given, u.direction);
        let (reflection, returns_light) = self.reflection_probability(given.dot(m));
        let w = reflect(given, m);
        let valid = valid & w.z.gt(0.0) & returns_light;
        let reflects = u.lobe.lt(reflection);
        ModelSample::finite(w.scale_z(reflects.select(side, -side)), valid)
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        self.facets.min_alpha()
    }

    #[inline(always)]
    fn transmits(&self) -> Mask<S> {
        Mask::splat(self.lobes().glossy.width(), true)
    }
}

impl ModelBound for RoughThinDielectric<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes().get()) || wo.z == 0.0 {
            return 0.0;
        }
        let on_side = |w: Vec3, side: f32| Vec3::new(w.x, w.y, w.z * side);
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let seen = self.facets.seen(wo.into()).get();
        let reflectances = |cone: &IncidentCone| {
            let halves = cone.halves(wo);
            let density = self.facets.projected_bound(halves.highest, cone) * seen;
            // The reflectance falls with the cosine.
            let r = halves
                .cosines
                .map(|cos| pane_reflectance::<One>(cos.into(), self.eta).get());
            (density, r)
        };
        let (near, [most, _]) = reflectances(&incident.map(|w| on_side(w, side)));
        let (far, [_, least]) = reflectances(&incident.map(|w| on_side(w, -side)));
        self.tints.reflection.max_channel().get() * most * near
            + self.tints.transmission.max_channel().get() * (1.0 - least) * far
    }
}
