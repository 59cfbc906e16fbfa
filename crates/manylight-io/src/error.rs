//! Why a scene file cannot be loaded, with the place in the file: what the command prints and a program can read.

use miette::{LabeledSpan, NamedSource, SourceCode, SourceSpan};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How much a [`Diagnostic`] matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The scene cannot be used.
    Error,
    /// The scene loads, but something of it is left out or replaced.
    Warning,
}

/// What a problem is about; it decides the exit code of the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadErrorKind {
    /// The content of the scene: exit code 3.
    Scene,
    /// The file system refuses: exit code 4.
    FileSystem,
    /// A warning that the caller asked to treat as an error: exit code 6.
    Strict,
}

/// Where in which file.
#[derive(Clone)]
pub struct Location {
    path: PathBuf,
    line: u32,
    column: u32,
    labels: Vec<(Range<usize>, String)>,
    source: NamedSource<Arc<str>>,
}

impl Location {
    /// The place of `span` in `text`, the content of `path`, with a remark on it.
    pub(crate) fn new(path: &Path, text: &Arc<str>, span: Range<usize>, label: String) -> Self {
        let before = &text[..span.start.min(text.len())];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.matches('\n').count() as u32 + 1;
        // A byte order mark is not shown, so it has no column.
        let shown = before[line_start..].trim_start_matches('\u{feff}');
        let column = shown.chars().count() as u32 + 1;
        let source = NamedSource::new(path.display().to_string(), Arc::clone(text));
        Location {
            path: path.to_owned(),
            line,
            column,
            labels: vec![(span, label)],
            source,
        }
    }

    /// A second remark in the same file.
    pub(crate) fn add_label(&mut self, span: Range<usize>, label: String) {
        self.labels.push((span, label));
    }

    /// The file.
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

    /// The bytes of the file that the problem is about.
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
        write!(f, "{}:{}:{}", self.path.display(), self.line, self.column)
    }
}

/// One problem of a scene file. As a [`miette::Diagnostic`] it prints itself with an excerpt of the file.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// How much it matters.
    pub severity: Severity,
    /// What it is about.
    pub kind: LoadErrorKind,
    /// A stable name, such as `scene::unknown_plugin`.
    pub code: &'static str,
    /// What was found.
    pub message: String,
    /// Where; `None` if the problem is the whole file or not in a file.
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
            .map(|location| &location.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let location = self.location.as_ref()?;
        Some(Box::new(location.labels.iter().map(|(span, label)| {
            let label = (!label.is_empty()).then(|| label.clone());
            LabeledSpan::new_with_span(label, SourceSpan::from((span.start, span.len())))
        })))
    }
}

/// Why a scene cannot be loaded. Its `Display` is the message alone; printing it as a [`miette::Diagnostic`]
/// adds place, excerpt and help.
#[derive(Clone, Debug)]
pub struct LoadError {
    diagnostic: Box<Diagnostic>,
}

impl LoadError {
    /// The problem.
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

crate::error::delegate_diagnostic!(LoadError, diagnostic);

/// Implements `miette::Diagnostic` for a type by its field that is one.
macro_rules! delegate_diagnostic {
    ($type:ty, $field:ident) => {
        impl miette::Diagnostic for $type {
            fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
                self.$field.code()
            }
            fn severity(&self) -> Option<miette::Severity> {
                miette::Diagnostic::severity(&*self.$field)
            }
            fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
                miette::Diagnostic::help(&*self.$field)
            }
            fn source_code(&self) -> Option<&dyn miette::SourceCode> {
                self.$field.source_code()
            }
            fn labels(&self) -> Option<Box<dyn Iterator<Item = miette::LabeledSpan> + '_>> {
                self.$field.labels()
            }
        }
    };
}
pub(crate) use delegate_diagnostic;
