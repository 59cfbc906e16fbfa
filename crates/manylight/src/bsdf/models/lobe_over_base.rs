//! A lobe of reflection over a diffuse base, of the models Phong and Ward.

use super::diffuse::Diffuse;
use crate::bsdf::lobes::Classes;
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::ScatteringModel;
use crate::lanes::{
    Color, Float, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes,
};

/// Sum of both albedos after scaling, if it was above 1; as in Mitsuba 0.x.
const SAFE_ALBEDO: f32 = 0.99;

/// A lobe over a diffuse base, and the choice between both.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeOverBase<S: Width> {
    pub(super) base: Diffuse<S>,
    pub(super) specular: Color<S>,
    /// The classes of the lobe.
    pub(super) class: Classes<S>,
    /// Probability of sampling the lobe, if both are requested.
    share: Float<S>,
}

in_lanes!(LobeOverBase {
    base,
    specular,
    class,
    share
});

impl<S: Width> LobeOverBase<S> {
    /// Scales the two albedos so that their sum stays below one in every channel.
    #[inline(always)]
    pub(super) fn new(diffuse: Color<S>, specular: Color<S>, class: Classes<S>) -> Self {
        let sum = (diffuse + specular).max_channel();
        let scale = sum.gt(1.0).select(SAFE_ALBEDO / sum, 1.0);
        let (diffuse, specular) = (diffuse * scale, specular * scale);
        let (d, s) = (diffuse.max_channel(), specular.max_channel());
        LobeOverBase {
            base: Diffuse {
                reflectance: diffuse,
            },
            specular,
            class,
            share: (d + s).gt(0.0).select(s / (d + s), 0.5),
        }
    }

    #[inline(always)]
    pub(super) fn lobes(&self) -> Classes<S> {
        self.base.lobes().or(self.class)
    }

    #[inline(always)]
    pub(super) fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let lobe = lobes
            .has(self.class)
            .select(self.specular.max_channel(), 0.0);
        let base = lobes
            .diffuse
            .select(self.base.reflectance.max_channel(), 0.0);
        cos.gt(0.0).select(lobe + base, 0.0)
    }

    /// Probability of sampling the lobe instead of the base.
    #[inline(always)]
    pub(super) fn probability(&self, lobes: Classes<S>) -> Float<S> {
        let with_lobe = lobes.diffuse.select(self.share, 1.0);
        lobes.has(self.class).select(with_lobe, 0.0)
    }

    /// The response for directions above the surface, where the lobe has `value` and is sampled
    /// with the density `lobe_pdf`.
    #[inline(always)]
    pub(super) fn respond(
        &self,
        (wi, wo): (Vector<S>, Vector<S>),
        lobes: Classes<S>,
        value: Float<S>,
        lobe_pdf: Float<S>,
    ) -> Response<S> {
        let above = wi.z.gt(0.0) & wo.z.gt(0.0);
        let base = self.base.respond(wi, wo, lobes);
        let values = ByClass {
            diffuse: base.values.diffuse,
            ..ByClass::of_microfacets(self.class, lobes, self.specular * value)
        };
        let pdf = self.pdf(wi.z, lobes, lobe_pdf);
        Response { values, pdf }.within(above)
    }

    /// Density of a direction of cosine `cos` above the surface.
    #[inline(always)]
    pub(super) fn pdf(&self, cos: Float<S>, lobes: Classes<S>, lobe_pdf: Float<S>) -> Float<S> {
        let share = self.probability(lobes);
        let pdf = share * lobe_pdf + (1.0 - share) * cosine_hemisphere_pdf(cos);
        lobes.has(self.lobes()).select(pdf, 0.0)
    }

    /// A sample given a direction of cosine `cos`, where `w` is a direction of the lobe.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        cos: Float<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
        w: Vector<S>,
    ) -> ModelSample<S> {
        let of_lobe = u.lobe.lt(self.probability(lobes));
        let valid = cos.gt(0.0) & (w.z.gt(0.0) | !of_lobe);
        ModelSample::finite(
            Vector::select(of_lobe, w, cosine_hemisphere(u.direction)),
            valid,
        )
    }
}
