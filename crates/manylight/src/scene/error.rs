//! The core's only error type.

use std::fmt;

/// Why a [`SceneDesc`](super::SceneDesc) is not a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// What was found and what was expected, in one sentence.
    pub message: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}
