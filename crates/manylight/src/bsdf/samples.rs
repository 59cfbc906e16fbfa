//! Samples of a scattering function.

use super::Lobes;
use super::model_sample::Numbers;
use crate::color::Rgb;
use crate::lanes::{Color, Float, Mask, One, Vector, Width, Word};
use crate::math::{Vec2, Vec3};

/// The random numbers of one BSDF sample, each in [0, 1).
#[derive(Clone, Copy, Debug)]
pub struct BsdfNumbers {
    /// Choice of the lobe.
    pub lobe: f32,
    /// Choice of the direction.
    pub direction: Vec2,
}

impl From<BsdfNumbers> for Numbers<One> {
    #[inline(always)]
    fn from(u: BsdfNumbers) -> Self {
        Numbers {
            lobe: u.lobe.into(),
            direction: u.direction.into(),
        }
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The sampled unit direction: `wi` of [`Bsdf::sample_wi`](super::Bsdf::sample_wi), `wo` of
    /// [`Bsdf::sample_wo`](super::Bsdf::sample_wo).
    pub w: Vec3,
    /// `f |cos| / pdf`, with the geometric cosine of the sampled direction; for delta lobes the
    /// limit of that.
    pub weight: Rgb,
    /// Density per solid angle of all requested lobes ([`Bsdf::pdf_wi`](super::Bsdf::pdf_wi),
    /// [`Bsdf::pdf_wo`](super::Bsdf::pdf_wo)); 0 for delta lobes.
    pub pdf: f32,
    /// The class of the sampled lobe (one bit).
    pub lobe: Lobes,
    /// Index of refraction on the far side over that on the near side; 1 for reflection. For
    /// Russian roulette.
    pub eta: f32,
}

/// A [`BsdfSample`] per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BsdfSamples<S: Width> {
    pub(crate) w: Vector<S>,
    pub(crate) weight: Color<S>,
    pub(crate) pdf: Float<S>,
    /// The bits of [`Lobes`].
    pub(crate) lobe: Word<S>,
    pub(crate) eta: Float<S>,
    /// The lanes with a sample; in others the walk is absorbed, and the fields are unspecified.
    pub(crate) valid: Mask<S>,
}

impl BsdfSamples<One> {
    /// The sample of the only lane.
    #[inline(always)]
    pub(super) fn get(self) -> Option<BsdfSample> {
        self.valid.any().then(|| BsdfSample {
            w: self.w.into(),
            weight: self.weight.into(),
            pdf: self.pdf.get(),
            lobe: Lobes(self.lobe.store()[0] as u8),
            eta: self.eta.get(),
        })
    }
}
