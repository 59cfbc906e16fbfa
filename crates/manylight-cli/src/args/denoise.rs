//! Options of the denoiser.

use super::written;
use clap::{Args, ValueEnum, ValueHint};
use serde::Serialize;
use std::path::PathBuf;

/// Options of denoising.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Denoising")]
pub(crate) struct DenoiseArgs {
    /// Denoise the image at the end. In exr files, R, G, B are then denoised, and noisy.R, noisy.G,
    /// noisy.B are the image with its noise.
    #[arg(long, value_name = "NAME", value_enum)]
    pub(crate) denoise: Option<Denoiser>,

    /// Library file of Open Image Denoise. Default: searched in the folder OIDN_DIR, in the Python
    /// package pyoidn, and in the folders of the system.
    #[arg(long, value_name = "FILE", requires = "denoise", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "written::path")]
    pub(crate) oidn_lib: Option<PathBuf>,
}

/// A denoiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Denoiser {
    /// Open Image Denoise 2, if it is installed.
    Oidn,
}
