//! The estimated memory of a render, against a limit: that of `--memory-limit`, or what the machine has left.

use crate::failure::Failure;
use crate::output::human_bytes;
use crate::report::resident_bytes;
use manylight::integrators::StageMemory;
use manylight::render::RenderJob;
use sysinfo::{CGroupLimits, System};

/// Refuses a render with an estimated memory above `limit`, or above what the machine has left if there is no limit. It holds `sums` sums
/// over passes at once; without sums, it has no film. `others` is memory that the render does not know of.
pub(crate) fn check_memory(
    limit: Option<u64>,
    job: &RenderJob,
    sums: usize,
    others: Option<StageMemory>,
) -> Result<(), Failure> {
    let scene = StageMemory {
        stage: "scene",
        bytes: resident_bytes(),
    };
    let available = match limit {
        Some(_) => None,
        None => available_bytes().map(|left| left.saturating_add(scene.bytes)),
    };
    let Some(most) = limit.or(available) else {
        return Ok(());
    };
    let render = (job.method).memory(job.scene, job.budget.passes, sums, job.seed);
    let render = render
        .into_iter()
        .filter(|stage| sums > 0 || stage.stage != "film");
    let stages: Vec<StageMemory> = std::iter::once(scene).chain(render).chain(others).collect();
    let bytes = stages.iter().map(|stage| stage.bytes);
    let total = bytes.fold(0, u64::saturating_add);
    if total <= most {
        return Ok(());
    }
    let parts: Vec<String> = (stages.iter())
        .map(|stage| format!("{} {}", stage.stage, human_bytes(stage.bytes)))
        .collect();
    let against = match limit {
        Some(limit) => format!("--memory-limit is {}", human_bytes(limit)),
        None => format!("{} are available", human_bytes(most)),
    };
    let largest = stages.iter().max_by_key(|stage| stage.bytes);
    let mut help = largest.map_or("", remedy).to_owned();
    if limit.is_none() {
        help += "; a larger --memory-limit overrides what is available";
    }
    Err(Failure::usage(
        format!(
            "the render would take about {} ({}); {against}",
            human_bytes(total),
            parts.join(", "),
        ),
        help,
    ))
}

/// What makes a stage smaller.
fn remedy(stage: &StageMemory) -> &'static str {
    match stage.stage {
        "film" | "maps" => "reduce --size, or --aov",
        "photons" | "importons" | "radiance cache" => "reduce --photons, or --lights",
        "lights" => "reduce --lights or --table-size, or use --emission vmf",
        "scene" => "simplify the scene: fewer triangles, smaller textures",
        _ => "reduce --size",
    }
}

/// Memory that the process may still take, in bytes: the least of what the machine and the control group have left. `None` if the system
/// does not tell.
fn available_bytes() -> Option<u64> {
    let mut system = System::new();
    system.refresh_memory();
    if system.total_memory() == 0 {
        return None;
    }
    // Files in the cache of a group give way, as they do in `available_memory`.
    let left_to_group = |group: CGroupLimits| group.total_memory.saturating_sub(group.rss);
    let of_group = system.cgroup_limits().map(left_to_group);
    let of_machine = system.available_memory();
    Some(of_group.map_or(of_machine, |bytes| bytes.min(of_machine)))
}

/// The number of sums over passes that a render of `job` holds at once.
pub(crate) fn sums_of_render(job: &RenderJob) -> usize {
    let is_one_block = job.budget.passes.is_some_and(|n| n <= job.block.get());
    if is_one_block { 1 } else { 2 }
}
