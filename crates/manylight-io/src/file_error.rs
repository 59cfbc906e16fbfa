//! Errors of mesh, image and spectrum files.
//!
//! Parsers work on bytes and return a `Fault`; public functions add the path and return a
//! [`FileError`].

use crate::read::read_regular;
use crate::shown::shown_path;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// An error of a mesh, image, spectrum or output file.
#[derive(Debug)]
pub struct FileError {
    /// Path of the file.
    pub path: PathBuf,
    /// Line of a text file, counted from 1.
    pub line: Option<u32>,
    /// Column of a text file in bytes, counted from 1.
    pub column: Option<u32>,
    /// What was found and what was expected.
    pub message: String,
    /// The class of the problem.
    pub kind: FileErrorKind,
}

/// The class of a [`FileError`].
#[derive(Debug)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// The file does not exist.
    NotFound,
    /// The file exists but cannot be read.
    Unreadable(io::Error),
    /// The file cannot be written.
    Unwritable(io::Error),
    /// The content is damaged or not supported.
    Malformed,
    /// The extension is not that of a format that can be written.
    UnknownFormat,
}

impl FileError {
    /// An error about the content of `path` as a whole.
    pub fn malformed(path: &Path, message: impl Into<String>) -> Self {
        Fault::new(message).in_file(path)
    }

    /// Reading `path` failed with `error`.
    pub fn unreadable(path: &Path, error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::NotFound {
            let message = "the file does not exist".to_owned();
            return FileError::whole(path, message, FileErrorKind::NotFound);
        }
        let message = format!("cannot be read: {error}");
        FileError::whole(path, message, FileErrorKind::Unreadable(error))
    }

    /// Writing `path` failed with `error`.
    pub fn unwritable(path: &Path, error: io::Error) -> Self {
        let message = match error.kind() {
            io::ErrorKind::NotFound => "cannot be written: the folder does not exist".to_owned(),
            _ => format!("cannot be written: {error}"),
        };
        FileError::whole(path, message, FileErrorKind::Unwritable(error))
    }

    /// An error about a file as a whole.
    fn whole(path: &Path, message: String, kind: FileErrorKind) -> Self {
        FileError {
            path: path.to_owned(),
            line: None,
            column: None,
            message,
            kind,
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown_path(&self.path))?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.kind {
            FileErrorKind::Unreadable(error) | FileErrorKind::Unwritable(error) => Some(error),
            FileErrorKind::NotFound | FileErrorKind::Malformed | FileErrorKind::UnknownFormat => {
                None
            }
        }
    }
}

/// An error in the content of a file, before its path is added.
#[derive(Debug)]
pub(crate) struct Fault {
    line: Option<u32>,
    column: Option<u32>,
    message: String,
}

impl Fault {
    /// An error without a location.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Fault {
            line: None,
            column: None,
            message: message.into(),
        }
    }

    /// An error at a line and column, both counted from 1.
    pub(crate) fn at(line: u32, column: u32, message: impl Into<String>) -> Self {
        Fault {
            line: Some(line),
            column: Some(column),
            message: message.into(),
        }
    }

    /// The error with the path of its file.
    pub(crate) fn in_file(self, path: &Path) -> FileError {
        FileError {
            path: path.to_owned(),
            line: self.line,
            column: self.column,
            message: self.message,
            kind: FileErrorKind::Malformed,
        }
    }
}

/// The text of a regular file.
///
/// # Errors
/// The file cannot be read, is of another kind, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        FileError::malformed(
            path,
            format!("invalid byte at offset {offset}, expected UTF-8 text"),
        )
    })
}

/// The content of a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    read_regular(path).map_err(|error| FileError::unreadable(path, error))
}
