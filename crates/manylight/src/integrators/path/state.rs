//! What a path carries.

use crate::integrators::camera_round::{CameraPath, FirstPart};
use crate::integrators::partition::PathStage;
use crate::sampling::SobolSequences;

/// What a path carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub(super) first: FirstPart,
    pub(super) stage: PathStage,
    /// Of the pixel.
    pub(super) sequences: SobolSequences,
}

impl CameraPath for PathState {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        Some(self.first)
    }
}
