//! Parts of a render in files: shares of its passes, and checkpoints.

mod checkpoint;
mod identity;
mod merge;
mod run_state;
mod shard;

pub(crate) use checkpoint::{Resumed, open_checkpoint};
pub(crate) use merge::{blocks_of, merge_parts};
pub(crate) use shard::render_share;
