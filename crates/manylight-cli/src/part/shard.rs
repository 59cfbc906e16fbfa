//! The part file of a share of a render.

use super::run_state::RunState;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::memory::{OtherMemory, check_memory};
use crate::request::RenderRequest;
use crate::session::Session;
use manylight::film::PassSums;
use manylight::film::arrays::arrays_of_sums;
use manylight::render::{Observer, RenderJob, render_blocks};
use manylight_io::part::{PartHeader, write_part};
use serde_json::json;
use std::ops::Range;
use std::path::Path;

/// Key of the number of passes of the whole render. A render without this number has the passes of
/// all blocks that its parts have.
pub(crate) const PASSES: &str = "passes";

/// Prefix of the arrays of a block.
pub(crate) fn block_group(block: u32) -> String {
    format!("block.{block}.")
}

/// Renders blocks of passes of `job` to the part file `path`. `false` if it was interrupted: nothing
/// is written then.
///
/// # Errors
/// The memory limit is too small, or the file cannot be written.
pub(crate) fn render_share(
    session: &Session,
    job: &RenderJob,
    blocks: Range<u32>,
    path: &Path,
    interrupt: &Interrupt,
    observer: &mut (dyn Observer + Send),
) -> Result<bool, Failure> {
    let (limit, other) = (session.request.memory_limit, OtherMemory::of_part(&blocks));
    let rendered = session.pool.install(|| {
        check_memory(limit, job, other)?;
        let (stats, cancel) = (&session.stats, interrupt.cancel());
        Ok::<_, Failure>(render_blocks(job, blocks, stats, cancel, observer))
    })?;
    let Some(sums) = rendered else {
        return Ok(false);
    };
    write_share(session, job, path, &sums, interrupt)?;
    Ok(true)
}

/// Writes blocks of passes of `job` to a part file.
fn write_share(
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
    // The command of the picture that the parts are merged to.
    let request = RenderRequest {
        outputs: Vec::new(),
        ..session.request.clone()
    };
    let mut report = session.report(job, passes.unwrap_or_default());
    report.settings.request = &request;
    let facts = session.facts(&film, job, &report);
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
