//! Failures as exceptions of the module `manylight.errors`.

use manylight_cli::Failure;
use manylight_io::{FileError, Location};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::Path;

/// What an exception says.
struct Report {
    /// Name of the exception's class.
    class: &'static str,
    message: String,
    suggestion: Option<String>,
    /// Stable identifier, such as `scene::unknown_plugin`.
    code: Option<String>,
    file: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
}

impl Report {
    fn new(class: &'static str, message: String) -> Self {
        Report {
            class,
            message,
            suggestion: None,
            code: None,
            file: None,
            line: None,
            column: None,
        }
    }

    fn of_file(class: &'static str, error: &FileError) -> Self {
        Report {
            file: Some(text(&error.path)),
            line: error.line,
            column: error.column,
            ..Report::new(class, error.message.clone())
        }
    }
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// The exception of a failure.
pub(crate) fn exception(py: Python<'_>, failure: &Failure) -> PyErr {
    let class = match failure.exit_code() {
        2 => "UsageError",
        3 | 6 => "SceneError",
        4 => "FileError",
        5 => "ComponentError",
        _ => "RenderError",
    };
    let report = match failure {
        Failure::Usage { message, help } => Report {
            suggestion: Some(keywords(help)),
            ..Report::new(class, keywords(message))
        },
        Failure::Load(error) => {
            let diagnostic = error.diagnostic();
            let place = diagnostic.location.as_ref();
            Report {
                suggestion: diagnostic.help.clone(),
                code: Some(diagnostic.code.to_owned()),
                file: place.map(|place| text(place.path())),
                line: place.map(Location::line),
                column: place.map(Location::column),
                ..Report::new(class, diagnostic.message.clone())
            }
        }
        Failure::Scene { scene, message } => Report {
            file: Some(text(scene)),
            ..Report::new(class, message.clone())
        },
        Failure::File(error) => Report::of_file(class, error),
        Failure::Denoiser(_) => Report {
            suggestion: Some(
                "install it by `pip install pyoidn`, or set OIDN_DIR to its folder, or name its file by oidn_lib".into(),
            ),
            ..Report::new(class, failure.to_string())
        },
        other => Report::new(class, other.to_string()),
    };
    raise(py, report)
}

/// The exception of an error about a file.
pub(crate) fn file_exception(py: Python<'_>, error: &FileError) -> PyErr {
    raise(py, Report::of_file("FileError", error))
}

/// The exception of wrong arguments.
pub(crate) fn usage(py: Python<'_>, message: &str, suggestion: &str) -> PyErr {
    let report = Report {
        suggestion: Some(suggestion.to_owned()),
        ..Report::new("UsageError", message.to_owned())
    };
    raise(py, report)
}

/// The exception of a panic of the renderer.
pub(crate) fn internal(py: Python<'_>) -> PyErr {
    let message = "internal error of the renderer; its message is on standard error";
    raise(py, Report::new("RenderError", message.to_owned()))
}

fn raise(py: Python<'_>, report: Report) -> PyErr {
    let exception = || -> PyResult<Bound<'_, PyAny>> {
        let class = py.import("manylight.errors")?.getattr(report.class)?;
        let fields = PyDict::new(py);
        fields.set_item("suggestion", &report.suggestion)?;
        fields.set_item("code", &report.code)?;
        fields.set_item("file", &report.file)?;
        fields.set_item("line", report.line)?;
        fields.set_item("column", report.column)?;
        class.call((&report.message,), Some(&fields))
    };
    exception().map_or_else(|error| error, PyErr::from_value)
}

/// Text with options of the command line as keywords: `--table-size` becomes `table_size`.
pub(crate) fn keywords(text: &str) -> String {
    let mut pieces = text.split("--");
    let mut result = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let end = piece.find(|c| !is_name(c)).unwrap_or(piece.len());
        let (name, rest) = piece.split_at(end);
        result.push_str(&name.replace('-', "_"));
        result.push_str(rest);
    }
    result
}
