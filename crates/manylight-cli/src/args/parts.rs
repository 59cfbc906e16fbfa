//! Options of long renders: blocks, shares, checkpoints, and the merging of parts.

use super::denoise::DenoiseArgs;
use super::picture::{DerivedArgs, FileArgs};
use crate::values::{self, GroupWeight, Shard};
use clap::{Args, ValueHint};
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight_lab::text::parse_duration;
use serde::Serialize;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

/// Options of long renders.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Long renders")]
pub(crate) struct PartArgs {
    /// Keep the state of the render in this file, at intervals and at the end, for --resume.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(skip)]
    pub(crate) checkpoint: Option<PathBuf>,

    /// Time between two checkpoints.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = CHECKPOINT_INTERVAL, requires = "checkpoint")]
    #[serde(skip)]
    pub(crate) checkpoint_every: Duration,

    /// Continue from a checkpoint. The image has the same bits as without a break. If FILE is also
    /// that of --checkpoint and does not exist yet, the render starts from the beginning.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(skip)]
    pub(crate) resume: Option<PathBuf>,

    /// Render the blocks of passes of share I of N (from 1), and write them to the part file -o,
    /// for `manylight merge`.
    #[arg(long, value_name = "I/N", value_parser = values::shard, conflicts_with_all = ["checkpoint", "resume", "denoise", "preview"])]
    #[serde(skip)]
    pub(crate) shard: Option<Shard>,

    /// Passes of a block, a multiple of 8. Shares consist of whole blocks; sums of blocks are added
    /// in their order, so that another number changes the rounding of the image. A part file holds
    /// all blocks of its share.
    #[arg(long, value_name = "N", value_parser = values::block, default_value_t = DEFAULT_BLOCK)]
    pub(crate) block: NonZeroU32,
}

/// Default time between two checkpoints.
const CHECKPOINT_INTERVAL: &str = "5m";

impl Default for PartArgs {
    fn default() -> Self {
        PartArgs {
            checkpoint: None,
            checkpoint_every: parse_duration(CHECKPOINT_INTERVAL)
                .expect("invariant: the default is a time"),
            resume: None,
            shard: None,
            block: DEFAULT_BLOCK,
        }
    }
}

/// Options of `relight`.
#[derive(Debug, Args)]
pub(crate) struct RelightArgs {
    /// Image with light groups: an exr file of a render with --light-groups.
    #[arg(value_name = "IMAGE", value_hint = ValueHint::FilePath)]
    pub(crate) image: PathBuf,

    /// Factors on the light of a group: R,G,B, or one number for all channels. May be repeated;
    /// other groups stay as they are.
    #[arg(short, long = "group", value_name = "NAME=R,G,B", required = true, value_parser = values::group_weight)]
    pub(crate) groups: Vec<GroupWeight>,

    /// Files of the picture.
    #[command(flatten)]
    pub(crate) derived: DerivedArgs,
}

/// Options of `merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Part files of all shares of a render, in any order.
    #[arg(value_name = "PART", required = true, num_args = 1.., value_hint = ValueHint::FilePath)]
    pub(crate) parts: Vec<PathBuf>,

    /// Image file; the extension selects the format: exr, png, jpg, hdr, pfm. May be repeated.
    #[arg(short, long = "output", value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Denoising of the image, by the albedo and normals of the parts.
    #[command(flatten)]
    pub(crate) denoise: DenoiseArgs,

    /// Colors of pictures and names of layers.
    #[command(flatten)]
    pub(crate) picture: FileArgs,

    /// Print a JSON object on standard output at the end.
    #[arg(long)]
    pub(crate) json: bool,

    /// Print errors only.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
