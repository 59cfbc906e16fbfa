//! Files that are replaced as a whole: a file is complete or does not change.

use crate::file_error::FileError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `bytes` to `path`: to a temporary file in the same folder, which is flushed to disk and renamed.
///
/// # Errors
/// The file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let write = || match special_file(&target_of(path)) {
        // A device or pipe must be written directly: renaming would replace it by a file.
        Some(mut file) => file
            .as_mut()
            .map_err(|error| io::Error::from(error.kind()))?
            .write_all(bytes),
        None => replace(path, |file| file.write_all(bytes)),
    };
    write().map_err(|error| FileError::unwritable(path, error))
}

/// Checks before a long computation that [`write_file`] can write `path`.
///
/// # Errors
/// The folder or the file is not writable.
pub fn check_replaceable(path: &Path) -> Result<(), FileError> {
    let target = target_of(path);
    let check = || {
        if fs::metadata(&target).is_ok_and(|metadata| metadata.is_dir()) {
            return Err(io::Error::other("the path is a folder"));
        }
        match special_file(&target) {
            Some(file) => file.map(drop),
            None => temporary_beside(&target).map(drop),
        }
    };
    check().map_err(|error| FileError::unwritable(path, error))
}

/// Replaces `path` by what `write` writes to a temporary file in the same folder. The file and the folder are flushed to disk:
/// after a loss of power, the old or the new file is there.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let target = target_of(path);
    let mut file = temporary_beside(&target)?;
    write(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    sync_folder(folder_of(&target))
}

/// The file to write: the target if `path` is a symbolic link, so that the link is kept.
fn target_of(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// The opened file, if it is neither a regular one nor a folder.
fn special_file(target: &Path) -> Option<io::Result<File>> {
    let metadata = fs::metadata(target).ok()?;
    let is_special = !metadata.is_file() && !metadata.is_dir();
    is_special.then(|| OpenOptions::new().write(true).open(target))
}

fn folder_of(target: &Path) -> &Path {
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// A temporary file in the folder of `target`, with the permissions of an ordinary new file.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".manylight-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // Only the kind of the error is kept, because its message names the temporary file.
    builder
        .tempfile_in(folder_of(target))
        .map_err(|error| io::Error::from(error.kind()))
}

/// Flushes the entries of a folder. Some file systems cannot; the file itself is safe there, too.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    let unsupported = |error: &io::Error| {
        matches!(
            error.kind(),
            io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported
        )
    };
    match File::open(folder).map(|folder| folder.sync_all()) {
        Ok(Err(error)) if !unsupported(&error) => Err(error),
        // A folder may be writable, but not readable.
        _ => Ok(()),
    }
}

/// Other systems have no such call.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
