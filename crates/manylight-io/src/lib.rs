//! Files in and out: scenes, meshes, images, spectra.

pub mod error;
pub mod file_error;
pub mod image;
pub mod mesh;
mod resolve;
pub mod scene;
pub mod sky;
pub mod spectra;
pub mod warning;

#[cfg(test)]
mod fuzz;

pub use error::{Diagnostic, LoadError, LoadErrorKind, Location, Severity};
pub use file_error::{FileError, FileErrorKind};
pub use scene::{LoadOptions, LoadedScene, SupportedFamily, check_scene, load_scene, supported};
pub use warning::Warning;
