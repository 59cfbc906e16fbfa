//! The settings of photon maps.

use crate::bsdf::Lobes;
use crate::lanes::{Float, Mask, Width};
use crate::math::UVec2;

/// The light that photons estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimate {
    /// Light that reaches high-roughness lobes from other surfaces, with a kernel that shrinks from
    /// pass to pass.
    Progressive,
    /// All light that non-specular lobes reflect, with the whole kernel in every pass.
    Direct,
}

/// Light from density estimates over photons. Each pass has its own photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonMap {
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Photons in an estimate, before its kernel shrinks.
    pub neighbors: u32,
    /// The light that they estimate.
    pub estimate: Estimate,
}

/// Least roughness of glossy lobes that gather before a non-specular event: lower ones would show
/// single photons. After such an event, which blurs what is seen, all glossy lobes gather. At 0.15
/// and 0.6 (2 passes of `photon-map` at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE -9.3 and +1.2
/// % (standard error 7 %), shadow rays -18 and +1 %.
const MIN_GATHERING_ROUGHNESS: f32 = 0.3;
/// Most camera paths per pixel and pass; see `PhotonMap::camera_paths`. With the default number of
/// photon paths it acts on pictures of less than 128x128 pixels. At 8 and 32 (2 passes of
/// `photon-map` at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE +40 and -16 % (standard error 9
/// %), shadow rays -50 and +44 %.
const MAX_CAMERA_PATHS: u32 = 16;

impl PhotonMap {
    /// Progressive photon mapping.
    pub fn progressive() -> Self {
        PhotonMap {
            photon_paths: 262_144,
            neighbors: 64,
            estimate: Estimate::Progressive,
        }
    }

    /// The photon map shown directly.
    pub fn direct() -> Self {
        PhotonMap {
            neighbors: 128,
            estimate: Estimate::Direct,
            ..PhotonMap::progressive()
        }
    }

    /// Camera paths per pixel in a pass: about as many in all as photon paths, so that neither
    /// dominates the time.
    pub(super) fn camera_paths(&self, size: UVec2) -> u32 {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let rounded = (u64::from(self.photon_paths) + pixels / 2) / pixels.max(1);
        rounded.clamp(1, u64::from(MAX_CAMERA_PATHS)) as u32
    }

    /// Whether photons from events of this class are part of estimates.
    pub(super) fn counts(&self, event: Lobes) -> bool {
        self.estimate == Estimate::Direct || event != Lobes::NONE
    }

    /// The lanes in which glossy lobes of this roughness gather before the first non-specular
    /// event; after it, all do.
    #[inline(always)]
    pub(super) fn glossy_gather<S: Width>(&self, roughness: Float<S>) -> Mask<S> {
        match self.estimate {
            Estimate::Progressive => roughness.ge(MIN_GATHERING_ROUGHNESS),
            Estimate::Direct => Mask::splat(roughness.width(), true),
        }
    }
}
