//! Conductors.

use super::fresnel::{ConductorFresnel, reflect};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::color::Rgb;
use crate::lanes::{Color, Float, One, Vector, Width, in_lanes, lanewise};
use crate::math::Vec3;

/// Lower bound of the reflectance of rough surfaces where it is estimated at the surface normal:
/// facets reflect at other angles.
const MIN_FACET_REFLECTANCE: f32 = 0.05;

/// A smooth, one-sided conductor.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct SmoothConductor<S: Width> {
    pub fresnel: ConductorFresnel<S>,
    pub tint: Color<S>,
}

in_lanes!(SmoothConductor { fresnel, tint });

impl<S: Width> ScatteringModel<S> for SmoothConductor<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.tint.r.width(), Lobes::DELTA)
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        let albedo = (self.fresnel.reflectance(cos) * self.tint).max_channel();
        cos.gt(0.0).select(albedo, 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, _: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let fraction = self.fresnel.reflectance(given.z) * self.tint;
        ModelSample::mirror(given, fraction, given.z.same(1.0), given.z.gt(0.0))
    }
}

impl ModelBound for SmoothConductor<One> {}

/// A rough, one-sided conductor: `f = F D G / (4 cosθ_i cosθ_o)`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughConductor<S: Width> {
    pub facets: Microfacets<S>,
    pub fresnel: ConductorFresnel<S>,
    pub tint: Color<S>,
}

in_lanes!(RoughConductor {
    facets,
    fresnel,
    tint
});

impl<S: Width> ScatteringModel<S> for RoughConductor<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        self.facets.class()
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        let f = self.fresnel.reflectance(cos);
        let albedo = (f.map(|f| f.max(MIN_FACET_REFLECTANCE)) * self.tint).max_channel();
        cos.gt(0.0).select(albedo, 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let above = lobes.has(self.lobes()) & wi.z.gt(0.0) & wo.z.gt(0.0);
        if above.none() {
            return Response::none(wi.z.width());
        }
        let m = (wi + wo).normalize();
        let pdf = self.facets.reflected_pdf(wo, m);
        let tint = self.fresnel.reflectance(wo.dot(m)) * self.tint;
        let value = tint * (pdf * self.facets.masking(wi, m));
        let values = ByClass::of_microfacets(self.lobes(), lobes, value);
        Response { values, pdf }.within(above)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let above = lobes.has(self.lobes()) & given.z.gt(0.0) & other.z.gt(0.0);
        let m = (given + other).normalize();
        above.select(self.facets.reflected_pdf(given, m), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, _: Classes<S>) -> ModelSample<S> {
        let w = reflect(given, self.facets.sample(given, u.direction));
        ModelSample::finite(w, given.z.gt(0.0) & w.z.gt(0.0))
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        self.facets.min_alpha()
    }
}

impl<S: Width> RoughConductor<S> {
    /// The lobe times `weight`, if it is in `lobes`, for a local `wo` above the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn with_wo(
        &self,
        wo: Vector<S>,
        lobes: Classes<S>,
        weight: Float<S>,
    ) -> RoughConductorToWo<S> {
        let factor = self.tint * (self.facets.seen(wo) * weight);
        RoughConductorToWo {
            facets: self.facets,
            fresnel: self.fresnel,
            factor: factor.within(lobes.has(self.facets.class())),
        }
    }
}

/// [`RoughConductor`] with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughConductorToWo<S: Width> {
    facets: Microfacets<S>,
    fresnel: ConductorFresnel<S>,
    /// The factor of `F D G1(wi)`: tint and [`Microfacets::seen`].
    factor: Color<S>,
}

lanewise!(RoughConductorToWo {
    facets,
    fresnel,
    factor
});

impl<S: Width> RoughConductorToWo<S> {
    /// `f cosθ_i` for local directions.
    #[inline(always)]
    pub(in crate::bsdf) fn f_cos_wi(&self, wi: Vector<S>, wo: Vector<S>) -> Color<S> {
        let at = self.facets.reflection(wi, wo);
        self.factor * self.fresnel.reflectance(at.cos) * at.density
    }
}

impl RoughConductorToWo<One> {
    /// Upper bound of all channels of [`RoughConductorToWo::f_cos_wi`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3) -> f32 {
        let at = self.facets.reflection_bound(incident, wo);
        (Rgb::from(self.factor) * self.fresnel.bound(at.cosines)).max_channel() * at.density
    }
}

impl ModelBound for RoughConductor<One> {
    #[inline]
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.with_wo(wo.into(), lobes.into(), 1.0.into())
            .bound(incident, wo)
    }
}
