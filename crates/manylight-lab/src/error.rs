//! Errors of the laboratory, with the place in a study plan where there is one.

use manylight_io::FileError;
use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

/// Why a comparison or a study cannot go on.
#[derive(Debug, Error, Diagnostic)]
pub enum LabError {
    /// A study plan is malformed, or names something that does not exist.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(Box<PlanError>),
    /// A file cannot be read or written, or has the wrong content.
    #[error("{0}")]
    #[diagnostic(code(manylight::file))]
    File(Box<FileError>),
    /// The arguments do not fit each other or the files.
    #[error("{message}")]
    #[diagnostic(code(manylight::usage))]
    Usage {
        /// What was found.
        message: String,
        /// What to do instead.
        #[help]
        help: String,
    },
}

impl LabError {
    /// [`LabError::Usage`] from its two texts.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        LabError::Usage {
            message: message.into(),
            help: help.into(),
        }
    }
}

impl From<FileError> for LabError {
    fn from(error: FileError) -> Self {
        LabError::File(Box::new(error))
    }
}

impl From<Box<PlanError>> for LabError {
    fn from(error: Box<PlanError>) -> Self {
        LabError::Plan(error)
    }
}

/// A problem in a study plan, with an excerpt of the file.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
#[diagnostic(code(manylight::plan))]
pub struct PlanError {
    /// What was found.
    pub(crate) message: String,
    /// Name and text of the plan.
    #[source_code]
    pub(crate) text: NamedSource<String>,
    /// Bytes of the text that are marked.
    #[label("here")]
    pub(crate) place: SourceSpan,
    /// What was expected.
    #[help]
    pub(crate) help: String,
}
