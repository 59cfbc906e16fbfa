//! The contract of all scattering models, and its functions as code that is compiled once for each
//! model and instruction set.
//!
//! Models work in a local frame with the normal as z axis, and are written in lanes: for one point
//! or for sixteen. `respond` is `f(wi → wo) |cosθ_i|` with its density, `bound` an upper bound over
//! a cone of `wi`. `sample` and `pdf` take the given direction, `wi` or `wo`: sampling is the same
//! for both, because visible half vectors depend on one direction only. Models are reciprocal,
//! transmission up to the squared index: bounds over the directions that leave a light use it.

use super::incident_cone::IncidentCone;
use super::lobes::{Classes, Lobes};
use super::model_sample::{ModelSample, Numbers};
use super::response::Response;
use crate::lanes::{Color, Float, Mask, One, Vector, Width};
use crate::math::Vec3;
use crate::simd::outlined;

/// What every scattering model does.
pub(super) trait ScatteringModel<S: Width> {
    /// The classes of the lobes.
    fn lobes(&self) -> Classes<S>;

    /// Estimated albedo of `lobes` for a given direction with this cosine: the largest channel. It
    /// decides how often the model is sampled beside others. Positive wherever `sample` or
    /// `respond` give light, as far as one cosine tells.
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S>;

    /// `f(wi → wo) |cosθ_i|` of the finite lobes in `lobes` by class, and the density of sampling
    /// `wi` given `wo` from `lobes`. Delta lobes have neither.
    #[inline(always)]
    fn respond(&self, wi: Vector<S>, _: Vector<S>, _: Classes<S>) -> Response<S> {
        Response::none(wi.z.width())
    }

    /// Density of sampling `other` given `given` with [`ScatteringModel::sample`] from the finite
    /// lobes.
    #[inline(always)]
    fn pdf(&self, given: Vector<S>, _: Vector<S>, _: Classes<S>) -> Float<S> {
        given.z.same(0.0)
    }

    /// Samples the other direction. `lobes` and the lobes of the model have a class in common.
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S>;

    /// The lanes in which a finite lobe transmits light to the other side.
    #[inline(always)]
    fn transmits(&self) -> Mask<S> {
        Mask::splat(self.lobes().glossy.width(), false)
    }

    /// Smallest roughness alpha of the lobes that are `GLOSSY` or `NEAR_DELTA`; 1 without such
    /// lobes.
    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        Float::splat(self.lobes().glossy.width(), 1.0)
    }

    /// `a(wi)` of the `DIFFUSE` lobe, `f = a(wi) b(wo) / π`; black without such a lobe. A lobe with
    /// another `b(wo)` than Lambert's needs an arm in `Model::exit_transmittance`.
    #[inline(always)]
    fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        Color::black(wi.z.width())
    }
}

/// The upper bounds of a scattering model, for cuts through a tree of lights.
pub(super) trait ModelBound: ScatteringModel<One> {
    /// Upper bound of all channels of the values over a cone of `wi`. 0 for models with delta lobes
    /// alone.
    fn bound(&self, _: &IncidentCone, _: Vec3, _: Lobes) -> f32 {
        0.0
    }
}

outlined! {
    /// [`ScatteringModel::respond`].
    pub(super) fn respond<M: ScatteringModel<S>, S: Width>(
        model: &M, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>,
    ) -> Response<S> { wi.z.width() => model.respond(wi, wo, lobes) }

    /// [`ScatteringModel::pdf`].
    pub(super) fn pdf<M: ScatteringModel<S>, S: Width>(
        model: &M, given: Vector<S>, other: Vector<S>, lobes: Classes<S>,
    ) -> Float<S> { given.z.width() => model.pdf(given, other, lobes) }

    /// [`ScatteringModel::sample`].
    pub(super) fn sample<M: ScatteringModel<S>, S: Width>(
        model: &M, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>,
    ) -> ModelSample<S> { given.z.width() => model.sample(given, u, lobes) }

    /// [`ScatteringModel::albedo_estimate`].
    pub(super) fn albedo_estimate<M: ScatteringModel<S>, S: Width>(
        model: &M, cos: Float<S>, lobes: Classes<S>,
    ) -> Float<S> { cos.width() => model.albedo_estimate(cos, lobes) }
}
