//! `--memory-limit`: the estimated memory of a render.

use crate::failure::Failure;
use crate::output::human_bytes;
use crate::report::resident_bytes;
use manylight::integrators::StageMemory;
use manylight::render::RenderJob;

/// Refuses a render with an estimated memory above `limit`. It holds `sums` sums over passes at once. `others` is memory that the render
/// does not know of.
pub(crate) fn check_memory(
    limit: Option<u64>,
    job: &RenderJob,
    sums: usize,
    others: Option<StageMemory>,
) -> Result<(), Failure> {
    let Some(limit) = limit else {
        return Ok(());
    };
    let scene = StageMemory {
        stage: "scene",
        bytes: resident_bytes(),
    };
    let render = (job.method).memory(job.scene, job.budget.passes, sums, job.seed);
    let stages: Vec<StageMemory> = std::iter::once(scene).chain(render).chain(others).collect();
    let total = stages.iter().map(|stage| stage.bytes).sum();
    if total <= limit {
        return Ok(());
    }
    let parts: Vec<String> = (stages.iter())
        .map(|stage| format!("{} {}", stage.stage, human_bytes(stage.bytes)))
        .collect();
    Err(Failure::usage(
        format!(
            "the render would take about {} ({}); --memory-limit is {}",
            human_bytes(total),
            parts.join(", "),
            human_bytes(limit)
        ),
        "reduce --lights, --photons, --table-size or --size, or use --emission vmf",
    ))
}

/// The number of sums over passes that a render of `job` holds at once.
pub(crate) fn sums_of_render(job: &RenderJob) -> usize {
    let is_one_block = job.budget.passes.is_some_and(|n| n <= job.block.get());
    if is_one_block { 1 } else { 2 }
}
