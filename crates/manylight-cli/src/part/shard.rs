//! The part file of a share of a render.

use super::run_state::RunState;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::picture::PictureFacts;
use crate::session::Session;
use manylight::film::PassSums;
use manylight::film::arrays::arrays_of_sums;
use manylight::render::RenderJob;
use manylight_io::part::{PartHeader, write_part};
use serde_json::json;
use std::path::Path;

/// Key of the number of passes of the whole render. A render without this number has the passes of
/// all blocks that its parts have.
pub(crate) const PASSES: &str = "passes";

/// Prefix of the arrays of a block.
pub(crate) fn block_group(block: u32) -> String {
    format!("block.{block}.")
}

/// Writes blocks of passes of `job` to a part file.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_share(
    session: &Session,
    job: &RenderJob,
    path: &Path,
    blocks: &[PassSums],
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let (film, stats) = (job.film(0), &session.stats);
    let passes = job.budget.passes;
    let mut identity = session
        .settings(job)
        .identity(&session.digest, session.digest_of_lights());
    identity.insert(PASSES.into(), json!(passes));
    let report = session.report(job, passes.unwrap_or_default());
    let (scene, metadata) = (&session.scene, report.metadata());
    let facts = PictureFacts::new(scene, &scene.sensor, film.id_layers(), metadata);
    let seconds = stats.total_time();
    let state = json!(RunState::new(stats, seconds));
    let header = PartHeader::new(&film, identity, state, json!(facts));
    let group = |sums: &PassSums| block_group(sums.passes().start / film.block());
    let groups: Vec<_> = blocks
        .iter()
        .map(|sums| (group(sums), arrays_of_sums(&film, sums)))
        .collect();
    let _complete_file = interrupt.writing();
    Ok(stats.time("write", || write_part(path, &header, &groups))?)
}
