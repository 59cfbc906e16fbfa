//! Lambertian reflection.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes, lanewise,
};
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// One-sided Lambertian reflection: `f = ρ / π`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Diffuse<S: Width> {
    pub reflectance: Color<S>,
}

in_lanes!(Diffuse { reflectance });

impl<S: Width> ScatteringModel<S> for Diffuse<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.reflectance.r.width(), Lobes::DIFFUSE)
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, _: Classes<S>) -> Float<S> {
        cos.gt(0.0).select(self.reflectance.max_channel(), 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let above = wi.z.gt(0.0) & wo.z.gt(0.0) & lobes.diffuse;
        let pdf = above.select(wi.z * FRAC_1_PI, 0.0);
        let values = ByClass {
            diffuse: self.reflectance * pdf,
            ..ByClass::black(pdf.width())
        };
        Response { values, pdf }
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
        self.reflectance.within(wi.z.gt(0.0))
    }
}

impl<S: Width> Diffuse<S> {
    /// The `DIFFUSE` lobe times `weight`, if it is in `lobes`, for any `wo` above the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn with_wo(&self, lobes: Classes<S>, weight: Float<S>) -> DiffuseToWo<S> {
        DiffuseToWo {
            f: (self.reflectance * (weight * FRAC_1_PI)).within(lobes.diffuse),
        }
    }
}

/// [`Diffuse`] with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct DiffuseToWo<S: Width> {
    f: Color<S>,
}

lanewise!(DiffuseToWo { f });

impl<S: Width> DiffuseToWo<S> {
    /// `f cosθ_i` at the cosine `cos` of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn f_cos_wi(&self, cos: Float<S>) -> Color<S> {
        self.f * cos.max(0.0)
    }
}

impl DiffuseToWo<One> {
    /// Upper bound of all channels of [`DiffuseToWo::f_cos_wi`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone) -> f32 {
        self.f.max_channel().get() * incident.projection_above()
    }
}

impl ModelBound for Diffuse<One> {
    #[inline]
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.with_wo(lobes.into(), 1.0.into()).bound(incident)
    }
}
