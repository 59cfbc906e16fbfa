//! Errors and warnings of glTF files, with the JSON path of their cause.

use super::super::sink::{FileSpan, Problem, Sink};
use super::locate::locate;
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Longest line of JSON that is shown as an excerpt, in bytes. Longer ones are written by programs
/// without line breaks: the excerpt would fill the screen.
const LONGEST_EXCERPT: usize = 400;

/// Reports problems of one file.
pub(super) struct Reporter<'a> {
    sink: &'a Sink,
    /// Name of the file in messages without an excerpt.
    name: String,
    /// Index of the file in the sink, and its JSON text; `None` without excerpts.
    excerpts: Option<(u32, Arc<str>)>,
    /// Errors so far, with their paths: a value that is used several times is reported once.
    reported: RefCell<HashSet<(String, String)>>,
}

impl<'a> Reporter<'a> {
    /// For the file `path` with the JSON `text`. In a binary file, the text has no lines to point
    /// at.
    pub(super) fn new(path: &Path, text: &str, is_binary: bool, sink: &'a Sink) -> Self {
        let readable = !is_binary && text.lines().all(|line| line.len() <= LONGEST_EXCERPT);
        let excerpts = readable.then(|| {
            let text: Arc<str> = text.into();
            (sink.add_file(path, Arc::clone(&text)), text)
        });
        Reporter {
            sink,
            name: path.display().to_string(),
            excerpts,
            reported: RefCell::default(),
        }
    }

    /// Notes that the content of a file belongs to the scene.
    pub(super) fn note_read(&self, path: &Path) {
        self.sink.note_read(path);
    }

    /// A problem of the value at the JSON `path`.
    fn problem(&self, code: &'static str, path: &str, message: &str) -> Problem {
        let prefix = if path.is_empty() { "" } else { ": " };
        match &self.excerpts {
            Some((file, text)) => {
                let span = locate(text, path);
                let span = FileSpan {
                    file: *file,
                    start: span.start as u32,
                    end: span.end as u32,
                };
                Problem::new(code, span, format!("{path}{prefix}{message}"))
            }
            None => {
                let message = format!("{}: {path}{prefix}{message}", self.name);
                Problem::without_location(code, message)
            }
        }
    }

    /// Adds an error about the value at the JSON `path`.
    pub(super) fn error(&self, path: &str, message: impl AsRef<str>) {
        self.add_error("gltf::invalid", path, message.as_ref(), |problem| problem);
    }

    /// Adds an error with a suggestion.
    pub(super) fn error_with_help(&self, path: &str, message: &str, help: impl Into<String>) {
        self.add_error("gltf::invalid", path, message, |problem| problem.help(help));
    }

    /// Adds an error with a suggestion, the first one of its `subject` only: one cause has one
    /// error, wherever it is met.
    pub(super) fn error_once(&self, subject: &str, path: &str, message: &str, help: String) {
        let key = (String::new(), subject.to_owned());
        if self.reported.borrow_mut().insert(key) {
            self.error_with_help(path, message, help);
        }
    }

    /// Adds an error about a file that cannot be read.
    pub(super) fn file_error(&self, path: &str, message: &str, help: Option<String>) {
        self.add_error("gltf::missing_file", path, message, |problem| {
            problem.maybe_help(help).file_system()
        });
    }

    fn add_error(
        &self,
        code: &'static str,
        path: &str,
        message: &str,
        complete: impl FnOnce(Problem) -> Problem,
    ) {
        let key = (path.to_owned(), message.to_owned());
        if !self.sink.is_full() && self.reported.borrow_mut().insert(key) {
            self.sink.error(complete(self.problem(code, path, message)));
        }
    }

    /// Adds a warning, the first one of its `subject` only.
    pub(super) fn warn_once(&self, subject: &str, path: &str, message: impl AsRef<str>) {
        let problem = self.problem("gltf::unsupported", path, message.as_ref());
        self.sink.warn_once(format!("gltf {subject}"), problem);
    }

    /// Whether an error has been reported.
    pub(super) fn has_errors(&self) -> bool {
        self.sink.has_errors()
    }
}
