//! Checks of messages.

use manylight_io::FileError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

/// Checks that the error of a file has a message, and a line wherever it has a column.
pub(crate) fn check_file_error(error: &FileError) {
    assert!(
        !error.message.trim().is_empty(),
        "an error without a message"
    );
    assert!(error.line != Some(0) && error.column != Some(0), "{error}");
    assert!(error.column.is_none() || error.line.is_some(), "{error}");
}

/// Checks that a problem has a message, and that it can be printed with its excerpt of the file.
pub(crate) fn check_diagnostic(problem: &dyn Diagnostic) {
    let message = problem.to_string();
    assert!(!message.trim().is_empty(), "a problem without a message");
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
    let mut text = String::new();
    let printed = handler.render_report(&mut text, problem);
    assert!(printed.is_ok(), "not printable: {message}");
}
