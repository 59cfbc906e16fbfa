//! Where loaders put what is wrong. Loading goes on after an error, so that one run finds everything.

use crate::error::{Diagnostic, LoadErrorKind, Location, Severity};
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A range of bytes in one of the files of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FileSpan {
    /// Index of the file in the [`Sink`].
    pub(super) file: u32,
    /// First byte.
    pub(super) start: u32,
    /// After the last byte.
    pub(super) end: u32,
}

/// A problem at a span.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    code: &'static str,
    span: FileSpan,
    message: String,
    label: String,
    second: Option<(FileSpan, String)>,
    help: Option<String>,
    kind: LoadErrorKind,
}

impl Problem {
    pub(super) fn new(code: &'static str, span: FileSpan, message: impl Into<String>) -> Self {
        Problem {
            code,
            span,
            message: message.into(),
            label: String::new(),
            second: None,
            help: None,
            kind: LoadErrorKind::Scene,
        }
    }

    /// A remark at the span.
    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Another span that matters.
    pub(super) fn second(mut self, span: FileSpan, label: impl Into<String>) -> Self {
        self.second = Some((span, label.into()));
        self
    }

    /// What was expected, and a suggestion.
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// A suggestion, if there is one.
    pub(super) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// The file system is to blame.
    pub(super) fn file_system(mut self) -> Self {
        self.kind = LoadErrorKind::FileSystem;
        self
    }
}

struct SourceFile {
    path: PathBuf,
    text: Arc<str>,
}

/// The files of a scene and what is wrong with them.
#[derive(Default)]
pub(super) struct Sink {
    files: RefCell<Vec<SourceFile>>,
    found: RefCell<Vec<(Option<FileSpan>, Diagnostic)>>,
    warned: RefCell<HashSet<String>>,
}

impl Sink {
    /// Adds a file, so that places can refer to it.
    pub(super) fn add_file(&self, path: &Path, text: Arc<str>) -> u32 {
        let mut files = self.files.borrow_mut();
        files.push(SourceFile {
            path: path.to_owned(),
            text,
        });
        files.len() as u32 - 1
    }

    /// A problem without a span.
    pub(super) fn report(&self, diagnostic: Diagnostic) {
        self.found.borrow_mut().push((None, diagnostic));
    }

    /// The scene cannot be used.
    pub(super) fn error(&self, report: Problem) {
        self.add(Severity::Error, report);
    }

    /// Something is left out or replaced.
    pub(super) fn warn(&self, report: Problem) {
        self.add(Severity::Warning, report);
    }

    /// As [`Sink::warn`], but only the first time for this `subject`.
    pub(super) fn warn_once(&self, subject: impl Into<String>, report: Problem) {
        if self.warned.borrow_mut().insert(subject.into()) {
            self.warn(report);
        }
    }

    fn add(&self, severity: Severity, report: Problem) {
        let location = self.locate(&report);
        let Problem {
            code,
            span,
            message,
            second,
            mut help,
            kind,
            ..
        } = report;
        if let Some((second, label)) = second.filter(|(second, _)| second.file != span.file) {
            let path = self.files.borrow()[second.file as usize].path.clone();
            help.get_or_insert(format!("{label}: `{}`", path.display()));
        }
        let diagnostic = Diagnostic {
            severity,
            kind,
            code,
            message,
            location: Some(location),
            help,
        };
        self.found.borrow_mut().push((Some(span), diagnostic));
    }

    fn locate(&self, report: &Problem) -> Location {
        let files = self.files.borrow();
        let range = |span: FileSpan| span.start as usize..span.end as usize;
        let file = &files[report.span.file as usize];
        let mut location = Location::new(
            &file.path,
            &file.text,
            range(report.span),
            report.label.clone(),
        );
        match &report.second {
            Some((span, label)) if span.file == report.span.file => {
                location.add_label(range(*span), label.clone())
            }
            _ => {}
        }
        location
    }

    /// Whether the scene cannot be used.
    pub(super) fn has_errors(&self) -> bool {
        self.found
            .borrow()
            .iter()
            .any(|(_, diagnostic)| diagnostic.severity == Severity::Error)
    }

    /// Everything found, by file and span; what has no span comes first.
    pub(super) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|(span, _)| *span);
        found
            .into_iter()
            .map(|(_, diagnostic)| diagnostic)
            .collect()
    }
}
