//! The text of a plan, problems at their place in it, and rules for the names in it.

use crate::error::PlanError;
use miette::NamedSource;
use std::path::Path;

/// The JSON text of a plan with the name of its file.
#[derive(Clone, Debug, Default)]
pub(super) struct PlanText {
    name: String,
    text: String,
}

impl PlanText {
    /// The content of the file at `path`.
    pub(super) fn new(path: &Path, text: String) -> Self {
        PlanText {
            name: path.display().to_string(),
            text,
        }
    }

    /// The same file with another text.
    pub(super) fn with(self, text: String) -> Self {
        PlanText { text, ..self }
    }

    /// The JSON text.
    pub(super) fn as_str(&self) -> &str {
        &self.text
    }

    /// An error of the JSON parser.
    pub(super) fn malformed(&self, error: &serde_json::Error) -> PlanError {
        let whole = error.to_string();
        // The excerpt displays the place; the message does not repeat it.
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
            "docs/studies.md describes the format of plans",
        )
    }

    /// A problem with the name or value `word`. Its last occurrence in the text is marked.
    pub(super) fn problem(
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

    /// A problem that marks `length` bytes from byte `start` on.
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

/// Help text: the characters of a name.
pub(super) const NAMES: &str = "letters, digits, - and _ can";

/// Whether a name has only the characters of [`NAMES`] and is not empty.
pub(super) fn is_file_name_part(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.chars().all(fits)
}

/// Help text with the known names, the most similar to `name` first.
pub(super) fn expected<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> String {
    let mut known: Vec<&str> = known.collect();
    let nearness = |other: &str| strsim::jaro_winkler(name, other);
    known.sort_by(|a, b| nearness(b).total_cmp(&nearness(a)));
    format!("expected one of {}", known.join(", "))
}
