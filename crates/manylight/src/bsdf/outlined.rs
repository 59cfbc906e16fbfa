//! The large functions of a scattering function. They are compiled once for each instruction set, because every caller would otherwise
//! have a copy of every model.

use super::leaf::Given;
use super::lobes::Lobes;
use super::model_sample::Numbers;
use super::{Bsdf, BsdfSamples, DirectResponses};
use crate::lanes::{Color, Float, Vector, Width};
use crate::simd::Outlined;

struct DirectResponsesOf<'a, 's, S: Width> {
    bsdf: &'a Bsdf<'s, S>,
    wi: Vector<S>,
    wo: Vector<S>,
}

struct ResponsesOf<'a, 's, S: Width> {
    bsdf: &'a Bsdf<'s, S>,
    wi: Vector<S>,
    wo: Vector<S>,
    lobes: Lobes,
}

struct SampleEach<'a, 's, S: Width> {
    bsdf: &'a Bsdf<'s, S>,
    end: Given,
    given: Vector<S>,
    u: Numbers<S>,
    lobes: Lobes,
}

impl<S: Width> Outlined for DirectResponsesOf<'_, '_, S> {
    type Output = DirectResponses<S>;

    #[inline(always)]
    fn run(self) -> DirectResponses<S> {
        self.bsdf.direct_responses_inlined(self.wi, self.wo)
    }
}

impl<S: Width> Outlined for ResponsesOf<'_, '_, S> {
    type Output = (Color<S>, Float<S>);

    #[inline(always)]
    fn run(self) -> (Color<S>, Float<S>) {
        self.bsdf.responses_inlined(self.wi, self.wo, self.lobes)
    }
}

impl<S: Width> Outlined for SampleEach<'_, '_, S> {
    type Output = BsdfSamples<S>;

    #[inline(always)]
    fn run(self) -> BsdfSamples<S> {
        match self.end {
            Given::Wo => self
                .bsdf
                .sample_each_wi_inlined(self.given, self.u, self.lobes),
            Given::Wi => self
                .bsdf
                .sample_each_wo_inlined(self.given, self.u, self.lobes),
        }
    }
}

impl<S: Width> Bsdf<'_, S> {
    /// [`Bsdf::f_cos_wi`] of the `NON_SPECULAR` and of the `NEAR_DELTA` lobes, and [`Bsdf::pdf_wi`] of all lobes, at the cost of one
    /// evaluation.
    #[inline(always)]
    pub(crate) fn direct_responses(&self, wi: Vector<S>, wo: Vector<S>) -> DirectResponses<S> {
        self.width()
            .outline(DirectResponsesOf { bsdf: self, wi, wo })
    }

    /// [`Bsdf::f_cos_wi`] and [`Bsdf::pdf_wi`] of `lobes` in each lane.
    #[inline(always)]
    pub(crate) fn responses(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Lobes,
    ) -> (Color<S>, Float<S>) {
        self.width().outline(ResponsesOf {
            bsdf: self,
            wi,
            wo,
            lobes,
        })
    }

    /// [`Bsdf::sample_wi`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wi(
        &self,
        wo: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        self.width().outline(SampleEach {
            bsdf: self,
            end: Given::Wo,
            given: wo,
            u,
            lobes,
        })
    }

    /// [`Bsdf::sample_wo`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wo(
        &self,
        wi: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        self.width().outline(SampleEach {
            bsdf: self,
            end: Given::Wi,
            given: wi,
            u,
            lobes,
        })
    }
}
