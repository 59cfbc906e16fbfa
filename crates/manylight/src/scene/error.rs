//! The core's only error type, and helpers for checks.

use crate::math::Affine3A;
use std::fmt;

/// A defect of a [`SceneDesc`](super::SceneDesc).
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// The found and the expected value, in one sentence.
    pub message: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}

/// The result of a check.
pub(super) type Checked = Result<(), SceneError>;

/// Fails if `index` is not below `count`.
pub(super) fn check_index(what: &str, index: usize, count: usize) -> Checked {
    ensure(index < count, || {
        format!("there is no {what} {index}, only {count}")
    })
}

/// Fails for a transform without an inverse.
pub(super) fn check_transform(transform: &Affine3A) -> Checked {
    ensure(transform.is_finite(), || {
        "the transform is not finite".to_owned()
    })?;
    let inverse = glam::Mat3::from(transform.matrix3).as_dmat3().inverse();
    ensure(inverse.is_finite(), || {
        "the transform is singular".to_owned()
    })
}

/// Puts the context of an error before its message.
pub(super) fn with_context(context: &str, error: &SceneError) -> SceneError {
    SceneError {
        message: format!("{context}: {}", error.message),
    }
}

/// Fails with `message` unless `holds`.
pub(super) fn ensure(holds: bool, message: impl FnOnce() -> String) -> Checked {
    if holds { Ok(()) } else { fail(message()) }
}

pub(super) fn fail(message: String) -> Checked {
    Err(SceneError { message })
}
