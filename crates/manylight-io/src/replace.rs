//! Files that are replaced as a whole: a file is complete or does not change.

use crate::file_error::FileError;
use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `bytes` to `path`: to a temporary file in the same folder, which is flushed to disk and
/// renamed.
///
/// # Errors
/// The file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let write = || match special_kind(path) {
        // A device or pipe must be written directly: renaming would replace it by a file.
        Some(_) => open_special(path)?.write_all(bytes),
        None => replace(path, |file| file.write_all(bytes)),
    };
    write().map_err(|error| FileError::unwritable(path, error))
}

/// Like [`check_replaceable`], for a file that must be a regular one: a part of a render is not
/// written from start to end. Checks before a long computation that such a part can be written.
///
/// # Errors
/// As for [`check_replaceable`]; a device or a pipe has this name.
pub fn check_regular(path: &Path) -> Result<(), FileError> {
    refuse_special(path).map_err(|error| FileError::unwritable(path, error))?;
    check_replaceable(path)
}

/// Checks before a long computation that [`write_file`] can write `path`.
///
/// # Errors
/// The folder or the file is not writable.
pub fn check_replaceable(path: &Path) -> Result<(), FileError> {
    let check = || {
        let target = target_of(path)?;
        if fs::metadata(&target).is_ok_and(|metadata| metadata.is_dir()) {
            return Err(io::Error::other("the path is a folder"));
        }
        match special_kind(path) {
            // The reader of a pipe would take its closing for the end of the file.
            Some(kind) if is_pipe(kind) => Ok(()),
            Some(_) => open_special(path).map(drop),
            None => temporary_beside(&target).map(drop),
        }
    };
    check().map_err(|error| FileError::unwritable(path, error))
}

/// Replaces `path` by what `write` writes to a temporary file in the same folder. The file and the
/// folder are flushed to disk: after a loss of power, the old or the new file is there.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    refuse_special(path)?;
    let target = target_of(path)?;
    let mut file = temporary_beside(&target)?;
    write(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    sync_folder(folder_of(&target))
}

/// Most symbolic links that are followed to a file that does not exist yet, as many as the system
/// follows to one that does.
const MAX_LINKS: usize = 40;

/// The file to write: where symbolic links lead, so that they are kept, even if that file does not
/// exist yet.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    match fs::metadata(path) {
        Ok(_) => return Ok(fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            Err(_) => break,
        }
    }
    Ok(target)
}

/// Whether `a` and `b` are the same existing file, or will be the same file once it is written.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| -> Option<PathBuf> {
        let target = target_of(path).ok()?;
        let folder = fs::canonicalize(folder_of(&target)).ok()?;
        Some(folder.join(target.file_name()?))
    };
    a == b || place(a).is_some_and(|a| place(b) == Some(a))
}

/// The kind of the file, if it is neither a regular one nor a folder.
fn special_kind(path: &Path) -> Option<FileType> {
    let kind = fs::metadata(path).ok()?.file_type();
    (!kind.is_file() && !kind.is_dir()).then_some(kind)
}

/// Refuses to replace a device or a pipe by a file.
fn refuse_special(path: &Path) -> io::Result<()> {
    match special_kind(path) {
        Some(_) => Err(io::Error::other(
            "found a device or a pipe, expected a regular file",
        )),
        None => Ok(()),
    }
}

fn open_special(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(path)
}

#[cfg(unix)]
fn is_pipe(kind: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
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
