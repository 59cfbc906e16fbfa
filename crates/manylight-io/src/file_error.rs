//! What can be wrong with a file that a scene names: a mesh, an image, a spectrum.
//!
//! Parsers work on bytes and report a [`Fault`]; the public functions add the path and return a [`FileError`].

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// What is wrong with a file that a scene names.
#[derive(Debug)]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Line, counted from 1, for text files.
    pub line: Option<u32>,
    /// Column in bytes, counted from 1, for text files.
    pub column: Option<u32>,
    /// What was found and what was expected.
    pub message: String,
    /// The class of the problem.
    pub kind: FileErrorKind,
}

/// The classes of problems with files.
#[derive(Debug)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// There is no such file.
    NotFound,
    /// The file system refuses to read it.
    Unreadable(io::Error),
    /// The file system refuses to write it.
    Unwritable(io::Error),
    /// The content is damaged, or of a form that is not supported.
    Malformed,
    /// The extension names no format that can be written.
    UnknownFormat,
}

impl FileError {
    /// A problem with the content of `path` as a whole.
    pub fn malformed(path: &Path, message: impl Into<String>) -> Self {
        Fault::new(message).in_file(path)
    }

    /// The file system refused to read `path`.
    pub fn unreadable(path: &Path, error: io::Error) -> Self {
        let (message, kind) = match error.kind() {
            io::ErrorKind::NotFound => (
                "the file does not exist".to_owned(),
                FileErrorKind::NotFound,
            ),
            _ => (
                format!("cannot be read: {error}"),
                FileErrorKind::Unreadable(error),
            ),
        };
        FileError {
            path: path.to_owned(),
            line: None,
            column: None,
            message,
            kind,
        }
    }

    /// The file system refused to write `path`.
    pub fn unwritable(path: &Path, error: io::Error) -> Self {
        let message = match error.kind() {
            io::ErrorKind::NotFound => "cannot be written: the folder does not exist".to_owned(),
            _ => format!("cannot be written: {error}"),
        };
        FileError {
            path: path.to_owned(),
            line: None,
            column: None,
            message,
            kind: FileErrorKind::Unwritable(error),
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
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

/// A problem found in bytes whose file is not known here.
#[derive(Debug)]
pub(crate) struct Fault {
    line: Option<u32>,
    column: Option<u32>,
    message: String,
}

impl Fault {
    /// A problem without a place.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Fault {
            line: None,
            column: None,
            message: message.into(),
        }
    }

    /// A problem at a line and column, both counted from 1.
    pub(crate) fn at(line: u32, column: u32, message: impl Into<String>) -> Self {
        Fault {
            line: Some(line),
            column: Some(column),
            message: message.into(),
        }
    }

    /// The same problem with its file.
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

/// The whole file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(path).map_err(|error| FileError::unreadable(path, error))
}
