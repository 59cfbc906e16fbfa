//! Collection of errors and warnings. Loading continues after an error, so that one run finds all
//! problems.

use crate::error::{Diagnostic, LoadErrorKind, Location, Severity};
use crate::file_error::{FileError, FileErrorKind};
use crate::source_text::SourceText;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A range of bytes in one of the files of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FileSpan {
    /// Index of the file in the [`Sink`].
    pub(super) file: u32,
    /// Offset of the first byte.
    pub(super) start: u32,
    /// Offset after the last byte.
    pub(super) end: u32,
}

/// A piece of text with its location.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text {
    pub(super) value: String,
    pub(super) span: FileSpan,
}

/// An error or warning at a location, before its file is looked up.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    code: &'static str,
    /// `None` if no text can be shown.
    span: Option<FileSpan>,
    message: String,
    label: String,
    second: Option<(FileSpan, String)>,
    help: Option<String>,
    kind: LoadErrorKind,
}

impl Problem {
    pub(super) fn new(code: &'static str, span: FileSpan, message: impl Into<String>) -> Self {
        Problem {
            span: Some(span),
            ..Problem::without_location(code, message)
        }
    }

    /// A problem whose message says where it is.
    pub(super) fn without_location(code: &'static str, message: impl Into<String>) -> Self {
        Problem {
            code,
            span: None,
            message: message.into(),
            label: String::new(),
            second: None,
            help: None,
            kind: LoadErrorKind::Scene,
        }
    }

    /// Sets the label of the location in the excerpt.
    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Sets a second location with its label.
    pub(super) fn second(mut self, span: FileSpan, label: impl Into<String>) -> Self {
        self.second = Some((span, label.into()));
        self
    }

    /// Sets what was expected, or a suggestion.
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Sets a suggestion if there is one.
    pub(super) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// Marks the problem as one of the file system.
    pub(super) fn file_system(mut self) -> Self {
        self.kind = LoadErrorKind::FileSystem;
        self
    }

    /// Marks the problem as one of the file system if a file cannot be read because of it.
    pub(super) fn caused_by(self, error: &FileError) -> Self {
        match error.kind {
            FileErrorKind::Unreadable(_) => self.file_system(),
            _ => self,
        }
    }
}

struct SourceFile {
    path: PathBuf,
    text: Arc<SourceText>,
}

/// Most problems of each severity that are kept. A file of another kind may have one on every line.
const MAX_PROBLEMS: usize = 1000;

/// The files of a scene, and the problems found so far.
#[derive(Default)]
pub(super) struct Sink {
    files: RefCell<Vec<SourceFile>>,
    found: RefCell<Vec<(Option<FileSpan>, Diagnostic)>>,
    /// Paths of all files that have been read.
    read: RefCell<BTreeSet<PathBuf>>,
    /// Subjects of [`Sink::warn_once`].
    warned: RefCell<HashSet<String>>,
    /// Numbers of errors and warnings, including those that are not kept.
    counts: [Cell<usize>; 2],
}

impl Sink {
    /// Adds a file and returns its index for [`FileSpan::file`].
    pub(super) fn add_file(&self, path: &Path, text: Arc<str>) -> u32 {
        let mut files = self.files.borrow_mut();
        files.push(SourceFile {
            path: path.to_owned(),
            text: Arc::new(SourceText::new(path, text)),
        });
        files.len() as u32 - 1
    }

    /// Notes that the content of a file belongs to the scene.
    pub(super) fn note_read(&self, path: &Path) {
        self.read.borrow_mut().insert(path.to_owned());
    }

    /// The noted files, sorted.
    pub(super) fn files_read(&self) -> Vec<PathBuf> {
        self.read.borrow().iter().cloned().collect()
    }

    /// Adds a problem without a location.
    pub(super) fn report(&self, diagnostic: Diagnostic) {
        let count = self.count(diagnostic.severity);
        count.set(count.get() + 1);
        self.found.borrow_mut().push((None, diagnostic));
    }

    /// Adds an error about a file as a whole.
    pub(super) fn file_error(
        &self,
        code: &'static str,
        message: String,
        help: Option<String>,
        kind: LoadErrorKind,
    ) {
        self.report(Diagnostic {
            severity: Severity::Error,
            kind,
            code,
            message,
            location: None,
            help,
        });
    }

    /// Adds an error: the scene cannot be used.
    pub(super) fn error(&self, problem: Problem) {
        self.add(Severity::Error, problem);
    }

    /// Adds an error that has neither a label nor a suggestion.
    pub(super) fn error_at(&self, code: &'static str, span: FileSpan, message: impl Into<String>) {
        self.error(Problem::new(code, span, message));
    }

    /// Adds a warning: a part of the scene is ignored or replaced.
    pub(super) fn warn(&self, problem: Problem) {
        self.add(Severity::Warning, problem);
    }

    /// Like [`Sink::warn`], but only for the first problem of a `subject`.
    pub(super) fn warn_once(&self, subject: impl Into<String>, problem: Problem) {
        if self.warned.borrow_mut().insert(subject.into()) {
            self.warn(problem);
        }
    }

    /// Warns about the first thing of a `subject` that is not supported.
    pub(super) fn unsupported(
        &self,
        subject: impl Into<String>,
        span: FileSpan,
        message: impl Into<String>,
    ) {
        self.warn_once(subject, Problem::new("scene::unsupported", span, message));
    }

    /// The number of problems of a severity, including those that are not kept.
    fn count(&self, severity: Severity) -> &Cell<usize> {
        &self.counts[severity as usize]
    }

    /// Whether further errors are counted, but not kept. Then no further files are included.
    pub(super) fn is_full(&self) -> bool {
        self.count(Severity::Error).get() >= MAX_PROBLEMS
    }

    fn add(&self, severity: Severity, problem: Problem) {
        let count = self.count(severity);
        count.set(count.get() + 1);
        if count.get() > MAX_PROBLEMS {
            return;
        }
        let location = problem.span.map(|span| self.locate(&problem, span));
        let Problem {
            code,
            span,
            message,
            second,
            mut help,
            kind,
            ..
        } = problem;
        let file = span.map(|span| span.file);
        if let Some((second, label)) = second.filter(|(second, _)| Some(second.file) != file) {
            let path = self.files.borrow()[second.file as usize].path.clone();
            help.get_or_insert(format!("{label}: `{}`", path.display()));
        }
        let diagnostic = Diagnostic {
            severity,
            kind,
            code,
            message,
            location,
            help,
        };
        self.found.borrow_mut().push((span, diagnostic));
    }

    fn locate(&self, problem: &Problem, at: FileSpan) -> Location {
        let files = self.files.borrow();
        let range = |span: FileSpan| span.start as usize..span.end as usize;
        let file = &files[at.file as usize];
        let mut location = Location::new(&file.path, &file.text, range(at), problem.label.clone());
        match &problem.second {
            Some((span, label)) if span.file == at.file => {
                location.add_label(range(*span), label.clone())
            }
            _ => {}
        }
        location
    }

    /// Whether an error has been added.
    pub(super) fn has_errors(&self) -> bool {
        self.count(Severity::Error).get() > 0
    }

    /// The problems, sorted by file and location; those without a location first. If there are too
    /// many, the last one says so.
    pub(super) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|(span, _)| *span);
        let further = [Severity::Error, Severity::Warning]
            .into_iter()
            .zip(&self.counts)
            .filter(|(_, count)| count.get() > MAX_PROBLEMS)
            .map(|(severity, count)| not_listed(severity, count.get()));
        found
            .into_iter()
            .map(|(_, diagnostic)| diagnostic)
            .chain(further)
            .collect()
    }
}

/// The problem that there are `count` problems, of which most are not listed.
fn not_listed(severity: Severity, count: usize) -> Diagnostic {
    let what = match severity {
        Severity::Error => "errors",
        Severity::Warning => "warnings",
    };
    Diagnostic {
        severity,
        kind: LoadErrorKind::Scene,
        code: "scene::too_many_problems",
        message: format!(
            "the scene has at least {count} {what}; the first {MAX_PROBLEMS} are listed"
        ),
        location: None,
        help: None,
    }
}
