//! Lookup of the files that a scene names.

use super::super::sink::{Problem, Sink};
use super::xml::Text;
use crate::resolve::{resolve, similar_file};
use std::path::PathBuf;

/// The file `name` in the first of `folders` that contains it. `what` describes it in messages.
///
/// Reports an error if there is none, and a warning if its name is spelled differently.
pub(super) fn find_file(
    sink: &Sink,
    folders: &[PathBuf],
    name: &Text,
    what: &str,
) -> Option<PathBuf> {
    let found = resolve(&name.value, folders).filter(|found| found.path.is_file());
    match found {
        Some(found) => {
            if let Some(remark) = found.remark {
                let message = format!(
                    "the name `{}` {remark}; using `{}`",
                    name.value,
                    found.path.display()
                );
                sink.warn_once(
                    format!("spelling of {}", name.value),
                    Problem::new("scene::file_name", name.span, message),
                );
            }
            Some(found.path)
        }
        // The undefined parameter has been reported.
        None if name.value.contains('$') => None,
        None => {
            let path = folders[0].join(&name.value);
            let help = match similar_file(&path) {
                Some(similar) => {
                    format!("looked for `{}`; did you mean `{similar}`?", path.display())
                }
                None => format!("looked for `{}`", path.display()),
            };
            let message = format!("the {what} `{}` does not exist", name.value);
            sink.error(
                Problem::new("scene::missing_file", name.span, message)
                    .label("not found")
                    .help(help),
            );
            None
        }
    }
}
