//! What a path carries.

use crate::film::TileSamples;
use crate::integrators::camera_round::{CameraPath, FirstPart, SeenEmission};
use crate::integrators::partition::PathStage;
use crate::sampling::SobolSequences;
use crate::scene::Scene;

/// What a path carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub(super) first: FirstPart,
    pub(super) stage: PathStage,
    /// Of the pixel.
    pub(super) sequences: SobolSequences,
}

impl PathState {
    /// Adds emission that the path sees at its end.
    #[inline]
    pub(super) fn add_emitted(&self, scene: &Scene, seen: SeenEmission, out: &mut TileSamples) {
        let to = (self.first.pixel, self.stage.layer());
        seen.add_to(scene, to, seen.at_camera(), |_| 1.0, out);
    }
}

impl CameraPath for PathState {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        Some(self.first)
    }
}
