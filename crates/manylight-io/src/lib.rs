//! io
pub mod file_error;
pub mod image;
pub mod mesh;
pub mod spectra;

#[cfg(test)]
mod fuzz;

pub use file_error::{FileError, FileErrorKind};
