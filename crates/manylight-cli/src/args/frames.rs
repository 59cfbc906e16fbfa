//! Options of walkthroughs.

use super::picture::DerivedArgs;
use super::written;
use crate::values::{self, FrameRange};
use clap::{Args, ValueHint};
use serde::Serialize;
use std::path::PathBuf;

/// Options of single pictures.
const NOT_OF_FRAMES: [&str; 6] = [
    "time",
    "target_error",
    "shard",
    "checkpoint",
    "resume",
    "preview",
];

/// Options of walkthroughs.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Walkthroughs")]
pub(crate) struct FrameArgs {
    /// Render a picture for each camera of a JSON file, with the same photons and virtual lights: a
    /// list of matrices from the camera to the world, of four rows each. A camera looks along +z,
    /// with +y up and +x to the left.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = NOT_OF_FRAMES)]
    #[serde(serialize_with = "written::path")]
    pub(crate) cameras: Option<PathBuf>,

    /// Frames to render with the same photons and virtual lights, counted from 1, both included; A
    /// alone is one frame, and A.. goes to the end. Without --cameras, those of a camera that moves
    /// in the scene. The name of a picture has the number of its frame: in the place of #### in the
    /// name of -o, or before the extension. The lights serve all frames, also those that are not
    /// rendered. A method that is chosen is rich-vpl.
    #[arg(long, value_name = "A..B", value_parser = values::frames, conflicts_with_all = NOT_OF_FRAMES)]
    #[serde(serialize_with = "written::frames")]
    pub(crate) frames: Option<FrameRange>,

    /// Skip frames that have all of their image files.
    #[arg(long)]
    #[serde(skip)]
    pub(crate) skip_existing: bool,
}

impl FrameArgs {
    /// Whether frames are rendered, not one picture.
    pub(crate) fn is_walkthrough(&self) -> bool {
        self.cameras.is_some() || self.frames.is_some()
    }

    /// The index of the only frame that is asked for, counted from 0.
    pub(crate) fn only(&self) -> Option<u32> {
        let range = self.frames?;
        (range.last == Some(range.first)).then(|| range.first - 1)
    }
}

/// Options of `steady`.
#[derive(Debug, Args)]
pub(crate) struct SteadyArgs {
    /// Frames: what `render --cameras` or --frames had as its output, such as walk-####.exr, with
    /// the layer position (--aov position). All that are there are read. The output has the same
    /// numbers.
    #[arg(value_name = "FRAMES", value_hint = ValueHint::FilePath)]
    pub(crate) frames: PathBuf,

    /// Files of each frame, with its number in their names.
    #[command(flatten)]
    pub(crate) derived: DerivedArgs,
}
