//! The part file of a share of a render.

use crate::failure::Failure;
use manylight::film::{Film, PassSums};
use manylight_io::part::{PartHeader, write_part};
use std::path::Path;

/// Prefix of the arrays of a block.
pub(crate) fn block_group(block: u32) -> String {
    format!("block.{block}.")
}

/// Writes blocks of the passes of `film`, a film with their layers.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_shard(
    path: &Path,
    header: &PartHeader,
    film: &Film,
    blocks: &[PassSums],
) -> Result<(), Failure> {
    let group = |sums: &PassSums| block_group(sums.passes().start / film.block());
    let groups: Vec<_> = blocks
        .iter()
        .map(|sums| (group(sums), film.arrays(sums)))
        .collect();
    Ok(write_part(path, header, &groups)?)
}
