//! Parts of a render in files: shares of its passes, and checkpoints.

mod checkpoint;
mod identity;
mod run_state;
mod shard;

pub(crate) use checkpoint::{Checkpoints, Resumed};
pub(crate) use identity::check_identity;
pub(crate) use run_state::RunState;
pub(crate) use shard::{block_group, write_shard};
