//! Samples of scattering models.

use crate::color::Rgb;
use crate::math::Vec3;

/// A direction sampled from a model.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModelSample {
    /// The unit direction in the frame of the model.
    pub w: Vec3,
    /// Index of refraction on the far side over that on the near side; 1 for reflection.
    pub eta: f32,
    /// Set for delta lobes.
    pub delta: Option<DeltaEvent>,
}

/// A sampled delta lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeltaEvent {
    /// Fraction of incident flux that the lobe scatters.
    pub fraction: Rgb,
    /// Probability of choosing the lobe.
    pub probability: f32,
}

impl ModelSample {
    /// A direction of a finite lobe.
    pub(super) fn finite(w: Vec3) -> Self {
        ModelSample {
            w,
            eta: 1.0,
            delta: None,
        }
    }

    /// Mirror reflection at the surface normal.
    pub(super) fn mirror(given: Vec3, fraction: Rgb, probability: f32) -> Self {
        let w = Vec3::new(-given.x, -given.y, given.z);
        ModelSample {
            w,
            eta: 1.0,
            delta: Some(DeltaEvent {
                fraction,
                probability,
            }),
        }
    }
}
