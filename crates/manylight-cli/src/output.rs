//! Standard output for data, standard error for messages, and numbers as text for people.

use crate::failure::{Failure, Rendered};
use indicatif::ProgressBar;
use manylight_io::clean_text;
use miette::Diagnostic;
use std::fmt;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Writes `data` and a line end to standard output.
pub(crate) fn print_data(data: impl fmt::Display) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{data}").and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(Failure::ClosedPipe),
        Err(error) => Err(Failure::Stdout(error)),
    }
}

/// Writes `message` and a line end to standard error. It may have names from files.
pub(crate) fn print_message(message: impl fmt::Display) {
    let text = message.to_string();
    // A closed standard error does not stop a render.
    let _ = writeln!(io::stderr().lock(), "{}", clean_text(&text));
}

/// Writes a diagnostic and a line end to standard error.
pub(crate) fn print_diagnostic(diagnostic: &dyn Diagnostic) {
    let _ = writeln!(io::stderr().lock(), "{}", Rendered(diagnostic));
}

/// Writes text for people, which may have names from files, and a line end to standard output.
pub(crate) fn print_text(text: &str) -> Result<(), Failure> {
    print_data(clean_text(text))
}

/// Standard error for messages from any thread, also while a progress bar is drawn.
#[derive(Clone, Debug, Default)]
pub(crate) struct Console(Arc<Mutex<Option<ProgressBar>>>);

impl Console {
    /// The bar that is drawn from now on; `None` for none.
    pub(crate) fn set_bar(&self, bar: Option<ProgressBar>) {
        *self.bar() = bar;
    }

    /// Prints a message and a line end.
    pub(crate) fn print(&self, message: impl fmt::Display) {
        match &*self.bar() {
            Some(bar) => bar.suspend(|| print_message(message)),
            None => print_message(message),
        }
    }

    fn bar(&self) -> MutexGuard<'_, Option<ProgressBar>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Prints warnings to standard error.
pub(crate) fn print_warnings(warnings: &[String]) {
    for warning in warnings {
        print_message(format_args!("warning: {warning}"));
    }
}

/// A duration as text: `0.25 s`, `12.3 s`, `4 min 05 s`, `1 h 02 min`.
pub(crate) fn human_time(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match seconds {
        s if s < 10.0 => format!("{s:.2} s"),
        s if s < 99.95 => format!("{s:.1} s"),
        s if s < 3599.5 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// A number of bytes as text, with a decimal unit: `1.2 MB`.
pub(crate) fn human_bytes(bytes: u64) -> String {
    if bytes == u64::MAX {
        return "18 EB or more".to_owned();
    }
    const UNITS: [&str; 4] = ["kB", "MB", "GB", "TB"];
    let mut value = bytes as f64 / 1000.0;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    format!("{value:.1} {}", UNITS[unit])
}

/// A number with groups of three digits: `12 345 678`.
pub(crate) fn human_count(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_text() {
        assert_eq!(human_time(0.254), "0.25 s");
        assert_eq!(human_time(12.34), "12.3 s");
        assert_eq!(human_time(245.2), "4 min 05 s");
        assert_eq!(human_time(3725.0), "1 h 02 min");
        assert_eq!(human_bytes(1_234_000), "1.2 MB");
        assert_eq!(human_bytes(500), "0.5 kB");
        assert_eq!(human_count(12_345_678), "12 345 678");
        assert_eq!(human_count(7), "7");
    }
}
