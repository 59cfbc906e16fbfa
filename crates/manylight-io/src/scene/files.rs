//! Lookup of the files that a scene names.

use super::sink::{Problem, Sink, Text};
use crate::resolve::{looked_for, resolve};
use std::path::{Path, PathBuf};

/// The path of a file without symbolic links, by which files that include themselves are found.
pub(super) fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The file `name` in the first of `folders` that contains it. `what` describes it in messages.
///
/// Reports an error of the scene if there is none, and a warning if its name is spelled
/// differently.
pub(super) fn find_file(
    sink: &Sink,
    folders: &[PathBuf],
    name: &Text,
    what: &str,
) -> Option<PathBuf> {
    let found = look_up(sink, folders, name);
    // An undefined parameter in a name has been reported.
    if found.is_none() && !name.value.contains('$') {
        sink.error(missing(folders, name, what));
    }
    found
}

/// Like [`find_file`], but an absent file is an error of the file system.
pub(super) fn find_external_file(
    sink: &Sink,
    folders: &[PathBuf],
    name: &Text,
    what: &str,
) -> Option<PathBuf> {
    let found = look_up(sink, folders, name);
    if found.is_none() {
        sink.error(missing(folders, name, what).file_system());
    }
    found
}

fn look_up(sink: &Sink, folders: &[PathBuf], name: &Text) -> Option<PathBuf> {
    let found = resolve(&name.value, folders).filter(|found| !found.path.is_dir())?;
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

fn missing(folders: &[PathBuf], name: &Text, what: &str) -> Problem {
    let message = format!("the {what} `{}` does not exist", name.value);
    Problem::new("scene::missing_file", name.span, message)
        .label("not found")
        .help(looked_for(&folders[0].join(&name.value)))
}
