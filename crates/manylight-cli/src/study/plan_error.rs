//! What can be wrong with a plan, shown at its place in the file.

use miette::{Diagnostic, NamedSource, SourceSpan};
use std::path::Path;
use thiserror::Error;

/// Why a plan cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
#[diagnostic(code(manylight::plan))]
pub(crate) struct PlanError {
    message: String,
    #[source_code]
    text: NamedSource<String>,
    #[label("here")]
    place: SourceSpan,
    #[help]
    help: String,
}

/// The text of a plan, for messages that point into it.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlanText {
    name: String,
    text: String,
}

impl PlanText {
    /// The content of the file at `path`.
    pub(crate) fn new(path: &Path, text: String) -> Self {
        PlanText {
            name: path.display().to_string(),
            text,
        }
    }

    /// Another text under the same name.
    pub(super) fn with(self, text: String) -> Self {
        PlanText { text, ..self }
    }

    /// The JSON itself.
    pub(crate) fn as_str(&self) -> &str {
        &self.text
    }

    /// What the JSON parser found.
    pub(crate) fn malformed(&self, error: &serde_json::Error) -> PlanError {
        let whole = error.to_string();
        // The place is shown beside the excerpt.
        let message = match whole.rfind(" at line ") {
            Some(end) => &whole[..end],
            None => &whole,
        };
        let line_start: usize = (self.text.split_inclusive('\n'))
            .take(error.line().saturating_sub(1))
            .map(str::len)
            .sum();
        self.error(
            line_start + error.column().saturating_sub(1),
            1,
            message,
            "docs/study/README.md says what a plan consists of",
        )
    }

    /// A problem with the name or value `word`, which is shown where it was last written.
    pub(crate) fn problem(
        &self,
        word: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> PlanError {
        let quoted = format!("\"{word}\"");
        let (start, length) = match self.text.rfind(&quoted) {
            Some(start) => (start, quoted.len()),
            None => (0, 0),
        };
        self.error(start, length, message, help)
    }

    fn error(
        &self,
        start: usize,
        length: usize,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> PlanError {
        let start = start.min(self.text.len().saturating_sub(1));
        PlanError {
            message: message.into(),
            text: NamedSource::new(&self.name, self.text.clone()),
            place: (start, length.min(self.text.len() - start)).into(),
            help: help.into(),
        }
    }
}
