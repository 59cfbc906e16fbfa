//! Errors and warnings of scene files, with their locations. A program reads the fields; [`miette`]
//! prints them with an excerpt of the file.

use crate::shown::shown_path;
use crate::source_text::SourceText;
use miette::{LabeledSpan, SourceCode, SourceSpan};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How severe a [`Diagnostic`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The scene cannot be used.
    Error,
    /// The scene loads, but a part of it is ignored or replaced.
    Warning,
}

/// The class of a problem. It determines the exit code of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadErrorKind {
    /// The content of the scene is invalid: exit code 3.
    Scene,
    /// A file cannot be read: exit code 4.
    FileSystem,
    /// An option does not apply to the format of the scene: exit code 2.
    Option,
    /// A warning that [`LoadOptions::strict`](crate::LoadOptions::strict) turned into an error:
    /// exit code 6.
    Strict,
}

/// A location in a file.
#[derive(Clone)]
pub struct Location {
    path: PathBuf,
    line: u32,
    column: u32,
    labels: Vec<(Range<usize>, String)>,
    source: Arc<SourceText>,
}

impl Location {
    /// The location of the bytes `span` of `source`, which is the content of `path`; `label` is
    /// printed at the excerpt.
    pub(crate) fn new(
        path: &Path,
        source: &Arc<SourceText>,
        span: Range<usize>,
        label: String,
    ) -> Self {
        let (line, column) = source.line_and_column(span.start);
        Location {
            path: path.to_owned(),
            line,
            column,
            labels: vec![(source.label_span(span), label)],
            source: Arc::clone(source),
        }
    }

    /// Adds a label at another span of the same file.
    pub(crate) fn add_label(&mut self, span: Range<usize>, label: String) {
        self.labels.push((self.source.label_span(span), label));
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Line, counted from 1.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Column in characters, counted from 1.
    pub fn column(&self) -> u32 {
        self.column
    }

    /// Range of bytes in the file; of a long one, the start.
    pub fn span(&self) -> Range<usize> {
        self.labels[0].0.clone()
    }
}

impl fmt::Debug for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = shown_path(&self.path);
        write!(f, "{path}:{}:{}", self.line, self.column)
    }
}

/// One problem of a scene. Printed as a [`miette::Diagnostic`], it shows an excerpt of the file.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// How severe it is.
    pub severity: Severity,
    /// The class of the problem.
    pub kind: LoadErrorKind,
    /// Stable identifier, such as `scene::unknown_plugin`.
    pub code: &'static str,
    /// What was found.
    pub message: String,
    /// Where it was found; `None` if it concerns a file as a whole or no file.
    pub location: Option<Location>,
    /// What was expected, and a suggestion.
    pub help: Option<String>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Diagnostic {}

impl miette::Diagnostic for Diagnostic {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help
            .as_ref()
            .map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.location
            .as_ref()
            .map(|location| &*location.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let location = self.location.as_ref()?;
        Some(Box::new(location.labels.iter().map(|(span, label)| {
            let label = (!label.is_empty()).then(|| label.clone());
            LabeledSpan::new_with_span(label, SourceSpan::from((span.start, span.len())))
        })))
    }
}

/// The error that prevents loading a scene. `Display` gives the message alone; printed as a
/// [`miette::Diagnostic`], it also shows location, excerpt and help.
#[derive(Clone, Debug, miette::Diagnostic)]
#[diagnostic(transparent)]
pub struct LoadError {
    diagnostic: Box<Diagnostic>,
}

impl LoadError {
    /// Severity, class, message, location and help.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.diagnostic
    }

    /// The class of the problem.
    pub fn kind(&self) -> LoadErrorKind {
        self.diagnostic.kind
    }
}

impl From<Diagnostic> for LoadError {
    fn from(diagnostic: Diagnostic) -> Self {
        LoadError {
            diagnostic: Box::new(diagnostic),
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.diagnostic.fmt(f)
    }
}

impl std::error::Error for LoadError {}

/// A part of a scene file that is ignored or replaced. `Display` gives `path:line:column: message`.
#[derive(Clone, Debug, miette::Diagnostic)]
#[diagnostic(transparent)]
pub struct Warning {
    diagnostic: Box<Diagnostic>,
}

impl Warning {
    /// Severity, class, message, location and help.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.diagnostic
    }

    /// What was found and what is done instead.
    pub fn message(&self) -> &str {
        &self.diagnostic.message
    }

    /// Where it was found; `None` if it concerns no single place of a file.
    pub fn location(&self) -> Option<&Location> {
        self.diagnostic.location.as_ref()
    }
}

impl From<Diagnostic> for Warning {
    fn from(diagnostic: Diagnostic) -> Self {
        Warning {
            diagnostic: Box::new(diagnostic),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = self.location() {
            write!(f, "{location}: ")?;
        }
        f.write_str(self.message())
    }
}

impl std::error::Error for Warning {}
