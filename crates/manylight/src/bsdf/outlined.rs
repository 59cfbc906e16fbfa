//! The large functions: those of a leaf that dispatch among all models, and those of a scattering function. They are compiled once
//! for each instruction set, because every caller would otherwise have a copy of every model.

use super::leaf::{Given, Leaf};
use super::lobes::{Classes, Lobes};
use super::model_sample::{ModelSample, Numbers};
use super::response::Response;
use super::{Bsdf, BsdfSamples, DirectResponses};
use crate::lanes::{Float, Vector, Width};
use crate::simd::Outlined;

struct Respond<'a, 's, S: Width> {
    leaf: &'a Leaf<'s, S>,
    wi: Vector<S>,
    wo: Vector<S>,
    lobes: Classes<S>,
}

struct Density<'a, 's, S: Width> {
    leaf: &'a Leaf<'s, S>,
    end: Given,
    given: Vector<S>,
    other: Vector<S>,
    lobes: Classes<S>,
}

struct Sample<'a, 's, S: Width> {
    leaf: &'a Leaf<'s, S>,
    end: Given,
    given: Vector<S>,
    u: Numbers<S>,
    lobes: Classes<S>,
}

struct SamplingWeight<'a, 's, S: Width> {
    leaf: &'a Leaf<'s, S>,
    given: Vector<S>,
    lobes: Classes<S>,
}

impl<S: Width> Outlined for Respond<'_, '_, S> {
    type Output = Response<S>;

    #[inline(always)]
    fn run(self) -> Response<S> {
        self.leaf.respond_inlined(self.wi, self.wo, self.lobes)
    }
}

impl<S: Width> Outlined for Density<'_, '_, S> {
    type Output = Float<S>;

    #[inline(always)]
    fn run(self) -> Float<S> {
        self.leaf
            .pdf_inlined(self.end, self.given, self.other, self.lobes)
    }
}

impl<S: Width> Outlined for Sample<'_, '_, S> {
    type Output = ModelSample<S>;

    #[inline(always)]
    fn run(self) -> ModelSample<S> {
        self.leaf
            .sample_inlined(self.end, self.given, self.u, self.lobes)
    }
}

impl<S: Width> Outlined for SamplingWeight<'_, '_, S> {
    type Output = Float<S>;

    #[inline(always)]
    fn run(self) -> Float<S> {
        self.leaf.sampling_weight_inlined(self.given, self.lobes)
    }
}

impl<S: Width> Leaf<'_, S> {
    /// `f(wi → wo) |cosθ_i|` by class without the leaf's weight, with the cosine to the normal of the model, and [`Leaf::pdf`] given `wo`.
    #[inline(always)]
    pub(super) fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        self.width().outline(Respond {
            leaf: self,
            wi,
            wo,
            lobes,
        })
    }

    /// Density of sampling `other` given `given` with [`Leaf::sample`].
    #[inline(always)]
    pub(super) fn pdf(
        &self,
        end: Given,
        given: Vector<S>,
        other: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        self.width().outline(Density {
            leaf: self,
            end,
            given,
            other,
            lobes,
        })
    }

    /// Samples the other direction. The leaf's weight is not in the fraction of delta events.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        end: Given,
        given: Vector<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
    ) -> ModelSample<S> {
        self.width().outline(Sample {
            leaf: self,
            end,
            given,
            u,
            lobes,
        })
    }

    /// The weight of the leaf in the choice among leaves: an estimate of the light that `lobes` return, given the direction `given`.
    #[inline(always)]
    pub(super) fn sampling_weight(&self, given: Vector<S>, lobes: Classes<S>) -> Float<S> {
        self.width().outline(SamplingWeight {
            leaf: self,
            given,
            lobes,
        })
    }
}

struct DirectResponsesOf<'a, 's, S: Width> {
    bsdf: &'a Bsdf<'s, S>,
    wi: Vector<S>,
    wo: Vector<S>,
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
    /// [`Bsdf::direct_response`] in each lane.
    #[inline(always)]
    pub(crate) fn direct_responses(&self, wi: Vector<S>, wo: Vector<S>) -> DirectResponses<S> {
        self.width()
            .outline(DirectResponsesOf { bsdf: self, wi, wo })
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
