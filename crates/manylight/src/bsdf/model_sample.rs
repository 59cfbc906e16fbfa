//! Samples of scattering models.

use crate::lanes::{Color, Float, Mask, Pair, Vector, Width};

/// The random numbers of one sample per lane; see [`BsdfNumbers`](super::BsdfNumbers).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers<S: Width> {
    /// Choice of the lobe.
    pub lobe: Float<S>,
    /// Choice of the direction.
    pub direction: Pair<S>,
}

/// A direction sampled from a model in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModelSample<S: Width> {
    /// The unit direction in the frame of the model.
    pub w: Vector<S>,
    /// Index of refraction on the far side over that on the near side; 1 for reflection.
    pub eta: Float<S>,
    /// The lanes of delta lobes.
    pub is_delta: Mask<S>,
    /// Delta lobes: fraction of incident flux that the lobe scatters.
    pub fraction: Color<S>,
    /// Delta lobes: probability of choosing the lobe.
    pub probability: Float<S>,
    /// The lanes with a sample; others are unspecified.
    pub valid: Mask<S>,
}

impl<S: Width> ModelSample<S> {
    /// A direction of a finite lobe.
    #[inline(always)]
    pub(super) fn finite(w: Vector<S>, valid: Mask<S>) -> Self {
        ModelSample {
            w,
            eta: w.z.same(1.0),
            is_delta: Mask::splat(w.z.width(), false),
            fraction: Color::black(w.z.width()),
            probability: w.z.same(1.0),
            valid,
        }
    }

    /// Mirror reflection at the surface normal.
    #[inline(always)]
    pub(super) fn mirror(
        given: Vector<S>,
        fraction: Color<S>,
        probability: Float<S>,
        valid: Mask<S>,
    ) -> Self {
        let s = given.z.width();
        ModelSample {
            w: Vector::new(-given.x, -given.y, given.z),
            eta: given.z.same(1.0),
            is_delta: Mask::splat(s, true),
            fraction,
            probability,
            valid,
        }
    }

    /// `a` in the lanes of `m`, `b` elsewhere.
    #[inline(always)]
    pub(super) fn select(m: Mask<S>, a: &Self, b: &Self) -> Self {
        let pick = |a: Mask<S>, b: Mask<S>| (a & m) | (b & !m);
        ModelSample {
            w: Vector::select(m, a.w, b.w),
            eta: m.select(a.eta, b.eta),
            is_delta: pick(a.is_delta, b.is_delta),
            fraction: Color::select(m, a.fraction, b.fraction),
            probability: m.select(a.probability, b.probability),
            valid: pick(a.valid, b.valid),
        }
    }
}
