//! Options of kept virtual lights.

use super::written;
use clap::{Args, ValueHint};
use serde::Serialize;
use std::path::PathBuf;

/// Options of kept virtual lights.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Kept lights")]
pub(crate) struct KeptLightArgs {
    /// Make the photons and virtual lights of all passes first, keep them in this file, and shade by
    /// them. A method that is chosen is rich-vpl.
    #[arg(
        long,
        value_name = "FILE",
        value_hint = ValueHint::FilePath,
        conflicts_with_all = ["lights_in", "time", "target_error", "shard", "checkpoint", "resume"]
    )]
    #[serde(serialize_with = "written::path")]
    pub(crate) lights_out: Option<PathBuf>,

    /// Shade by the lights in this file, of the same scene and any camera. Method, options of virtual
    /// lights and the number of passes are those of the file; fewer passes may be asked for.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "written::path")]
    pub(crate) lights_in: Option<PathBuf>,
}

impl KeptLightArgs {
    /// Whether lights are made before the first pass.
    pub(crate) fn is_given(&self) -> bool {
        self.lights_out.is_some() || self.lights_in.is_some()
    }
}
