//! Dielectric interfaces with refraction.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.

use super::fresnel::{self, reflect, refract};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width, in_lanes};
use crate::math::Vec3;

/// Bounds of the reflectance of a rough interface where it is estimated at the surface normal:
/// facets reflect and refract at other angles.
pub(super) const FACET_REFLECTANCES: [f32; 2] = [0.05, 0.95];

/// Factors of the reflected and of the transmitted light of an interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct InterfaceTints<S: Width> {
    pub reflection: Color<S>,
    pub transmission: Color<S>,
}

in_lanes!(InterfaceTints {
    reflection,
    transmission
});

impl<S: Width> InterfaceTints<S> {
    /// Estimated albedo, by the largest channels, where the interface reflects the fraction `r`.
    #[inline(always)]
    pub(super) fn albedo_estimate(&self, r: Float<S>) -> Float<S> {
        self.reflection.max_channel() * r + self.transmission.max_channel() * (1.0 - r)
    }

    /// Probability of sampling reflection, in proportion to the light that both events return, and
    /// the lanes in which they return any.
    #[inline(always)]
    pub(super) fn reflection_probability(&self, r: Float<S>) -> (Float<S>, Mask<S>) {
        let all = self.albedo_estimate(r);
        (self.reflection.max_channel() * r / all, all.gt(0.0))
    }
}

/// A smooth dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct SmoothDielectric<S: Width> {
    /// Interior over exterior index of refraction.
    pub eta: f32,
    pub tints: InterfaceTints<S>,
}

in_lanes!(SmoothDielectric { tints; eta });

impl<S: Width> ScatteringModel<S> for SmoothDielectric<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.tints.reflection.r.width(), Lobes::DELTA)
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        let interface = fresnel::dielectric(cos, cos.same(self.eta));
        self.tints.albedo_estimate(interface.reflectance)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let interface = fresnel::dielectric(given.z, given.z.same(self.eta));
        let r = interface.reflectance;
        let (reflection, returns_light) = self.tints.reflection_probability(r);
        let reflects = u.lobe.lt(reflection);
        let mirrored =
            ModelSample::mirror(given, self.tints.reflection * r, reflection, returns_light);
        let transmitted = ModelSample {
            w: Vector::new(
                -(interface.inv_eta * given.x),
                -(interface.inv_eta * given.y),
                interface.cos_t,
            ),
            eta: interface.eta,
            fraction: self.tints.transmission * (1.0 - r),
            probability: 1.0 - reflection,
            valid: returns_light & !interface.cos_t.equals(0.0),
            ..mirrored
        };
        ModelSample::select(reflects, &mirrored, &transmitted)
    }
}

impl ModelBound for SmoothDielectric<One> {}

/// A rough dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughDielectric<S: Width> {
    pub facets: Microfacets<S>,
    /// Interior over exterior index of refraction.
    pub eta: f32,
    pub tints: InterfaceTints<S>,
}

in_lanes!(RoughDielectric { facets, tints; eta });

impl<S: Width> RoughDielectric<S> {
    /// The density for two directions with this half vector.
    #[inline(always)]
    fn pdf_by(&self, half: &HalfVector<S>, given: Vector<S>, other: Vector<S>) -> Float<S> {
        let cos = given.dot(half.m);
        let r = fresnel::dielectric(cos, cos.same(self.eta)).reflectance;
        let (reflection, returns_light) = self.tints.reflection_probability(r);
        let event = half.reflects.select(reflection, 1.0 - reflection);
        returns_light.select(half.pdf(&self.facets, given, other) * event, 0.0)
    }
}

impl<S: Width> ScatteringModel<S> for RoughDielectric<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        self.facets.class()
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        let [least, most] = FACET_REFLECTANCES;
        let r = fresnel::dielectric(cos, cos.same(self.eta)).reflectance;
        self.tints.albedo_estimate(r.clamp(least, most))
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let half = HalfVector::new(wo, wi, self.eta);
        let valid = half.valid & lobes.has(self.lobes());
        if valid.none() {
            return Response::none(wi.z.width());
        }
        let (i, o) = (wi.dot(half.m), wo.dot(half.m));
        let f = fresnel::dielectric(o, o.same(self.eta)).reflectance;
        let masking = self.facets.masking(wi, half.m) * self.facets.masking(wo, half.m);
        let common = self.facets.density(half.m) * masking / wo.z.abs();
        let reflected = self.tints.reflection * (0.25 * f * common);
        // Walter et al., eq. (21), with the half vector of the medium of `wo`: this scales radiance
        // by η².
        let jacobian = (i * o).abs() / (o + half.eta * i).squared();
        let transmitted = self.tints.transmission * ((1.0 - f) * common * jacobian);
        let value = Color::select(half.reflects, reflected, transmitted);
        Response {
            values: ByClass::of_microfacets(self.lobes(), lobes, value),
            pdf: self.pdf_by(&half, wo, wi),
        }
        .within(valid)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let half = HalfVector::new(given, other, self.eta);
        let valid = half.valid & lobes.has(self.lobes());
        valid.select(self.pdf_by(&half, given, other), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let m = self.facets.sample(given * given.z.sign(), u.direction);
        let cos = given.dot(m);
        let interface = fresnel::dielectric(cos, cos.same(self.eta));
        let (reflection, returns_light) = self.tints.reflection_probability(interface.reflectance);
        let reflects = u.lobe.lt(reflection);
        facet_sample(given, m, &interface, reflects, returns_light)
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

/// The direction reflected or refracted at a facet with normal `m`; invalid if it is on the wrong
/// side of the surface.
#[inline(always)]
pub(in crate::bsdf) fn facet_sample<S: Width>(
    given: Vector<S>,
    m: Vector<S>,
    interface: &fresnel::Interface<S>,
    reflects: Mask<S>,
    valid: Mask<S>,
) -> ModelSample<S> {
    let w = Vector::select(reflects, reflect(given, m), refract(given, m, interface));
    let product = w.z * given.z;
    let agrees = (reflects & product.gt(0.0)) | (product.lt(0.0) & !reflects);
    ModelSample {
        eta: reflects.select(1.0, interface.eta),
        ..ModelSample::finite(w, valid & agrees)
    }
}

impl ModelBound for RoughDielectric<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes().get()) || wo.z == 0.0 {
            return 0.0;
        }
        let bounds = interface_bounds(&self.facets, self.eta, incident, wo);
        self.tints.reflection.max_channel().get() * bounds[0]
            + self.tints.transmission.max_channel().get() * bounds[1]
    }
}

/// Upper bounds of `f |cosθ_i|` of reflection and of transmission at a rough interface without
/// tints, over a cone of `wi`. For transmission it uses `|o·m + η i·m| >= |η - 1|`, which follows
/// from Snell's law.
pub(in crate::bsdf) fn interface_bounds(
    facets: &Microfacets<One>,
    eta: f32,
    incident: &IncidentCone,
    wo: Vec3,
) -> [f32; 2] {
    let side = 1.0f32.copysign(wo.z);
    let up = |w: Vec3| Vec3::new(w.x, w.y, w.z * side);
    let (incident, wo) = (incident.map(up), up(wo));
    let eta = if side > 0.0 { eta } else { eta.recip() };
    let [lowest, _] = incident.cosines();
    let halves = incident.halves(wo);
    let seen = 4.0 * facets.seen(wo.into()).get();
    let cos: Float<One> = halves.cosines[0].into();
    let reflected = fresnel::dielectric(cos, eta.into()).reflectance.get();
    let transmitted = if lowest < 0.0 {
        facets.visible_bound(1.0, 1.0) / (eta - 1.0).powi(2)
    } else {
        0.0
    };
    [
        0.25 * reflected * facets.projected_bound(halves.highest, &incident) * seen,
        transmitted * seen,
    ]
}

/// The microfacet that reflects or refracts one direction to another.
pub(in crate::bsdf) struct HalfVector<S: Width> {
    /// Its unit normal, on the outside.
    pub m: Vector<S>,
    /// Whether both directions are on the same side of the surface.
    pub reflects: Mask<S>,
    /// Index of refraction on the far side of `given` over that on its own side, also for
    /// reflection.
    pub eta: Float<S>,
    /// The lanes with such a microfacet.
    pub valid: Mask<S>,
}

impl<S: Width> HalfVector<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(given: Vector<S>, other: Vector<S>, eta: f32) -> Self {
        let product = given.z * other.z;
        let reflects = product.gt(0.0);
        let eta = given.z.gt(0.0).select(eta, 1.0 / eta);
        let (m, is_unit) = (given + other * reflects.select(1.0, eta)).try_normalize();
        let m = m * m.z.sign();
        // Each direction must be on the same side of the facet and of the surface.
        let agrees = (given.dot(m) * given.z).gt(0.0) & (other.dot(m) * other.z).gt(0.0);
        HalfVector {
            m,
            reflects,
            eta,
            valid: agrees & is_unit & !product.equals(0.0),
        }
    }

    /// Density of `other` if `m` is sampled from the normals visible from `given`. Jacobians:
    /// Walter et al., eqs. (14) and (17).
    #[inline(always)]
    pub(in crate::bsdf) fn pdf(
        &self,
        facets: &Microfacets<S>,
        given: Vector<S>,
        other: Vector<S>,
    ) -> Float<S> {
        let (g, o) = (given.dot(self.m), other.dot(self.m));
        let jacobian = self.eta * self.eta * o.abs() / (g + self.eta * o).squared();
        let factor = self.reflects.select(0.25, g.abs() * jacobian);
        facets.density(self.m) * facets.masking(given, self.m) * factor / given.z.abs()
    }
}
