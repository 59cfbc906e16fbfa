//! The large functions of a scattering function. They are compiled once for each instruction set, because every caller would otherwise
//! have a copy of every model.

use super::lobes::Lobes;
use super::model_sample::Numbers;
use super::{Bsdf, BsdfSamples, DirectResponses};
use crate::lanes::{Color, Float, Vector, Width};
use crate::simd::outlined;

outlined! {
    fn direct_responses<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, wo: Vector<S>,
    ) -> DirectResponses<S> { bsdf.width() => bsdf.direct_responses_inlined(wi, wo) }

    fn responses<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, wo: Vector<S>, lobes: Lobes,
    ) -> (Color<S>, Float<S>) { bsdf.width() => bsdf.responses_inlined(wi, wo, lobes) }

    fn sample_wi<S: Width>(
        bsdf: &Bsdf<'_, S>, wo: Vector<S>, u: Numbers<S>, lobes: Lobes,
    ) -> BsdfSamples<S> { bsdf.width() => bsdf.sample_each_wi_inlined(wo, u, lobes) }

    fn sample_wo<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, u: Numbers<S>, lobes: Lobes,
    ) -> BsdfSamples<S> { bsdf.width() => bsdf.sample_each_wo_inlined(wi, u, lobes) }
}

impl<S: Width> Bsdf<'_, S> {
    /// [`Bsdf::f_cos_wi`] of the `NON_SPECULAR` and of the `NEAR_DELTA` lobes, and [`Bsdf::pdf_wi`] of all lobes, at the cost of one
    /// evaluation.
    #[inline(always)]
    pub(crate) fn direct_responses(&self, wi: Vector<S>, wo: Vector<S>) -> DirectResponses<S> {
        direct_responses(self, wi, wo)
    }

    /// [`Bsdf::f_cos_wi`] and [`Bsdf::pdf_wi`] of `lobes` in each lane.
    #[inline(always)]
    pub(crate) fn responses(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Lobes,
    ) -> (Color<S>, Float<S>) {
        responses(self, wi, wo, lobes)
    }

    /// [`Bsdf::sample_wi`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wi(
        &self,
        wo: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        sample_wi(self, wo, u, lobes)
    }

    /// [`Bsdf::sample_wo`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wo(
        &self,
        wi: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        sample_wo(self, wi, u, lobes)
    }
}
