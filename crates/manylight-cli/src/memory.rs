//! The estimated memory of a render, against a limit: that of `--memory-limit`, or what the machine
//! has left.

use crate::failure::Failure;
use crate::output::human_bytes;
use crate::picture;
use crate::report::resident_bytes;
use crate::request::{RenderRequest, have_layers};
use manylight::emitters::EmissionGuide;
use manylight::integrators::{LightSets, Stage, StageMemory, estimated_memory};
use manylight::render::RenderJob;
use std::ops::Range;
use sysinfo::{CGroupLimits, System};

/// Memory that a render takes beside that of its method.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OtherMemory {
    /// Number of sums over passes that it holds at once; 0 without a film.
    pub(crate) sums: usize,
    /// What lasts as long as the render.
    pub(crate) beside: Option<StageMemory>,
    /// What is taken when the render has ended, and its photons and lights are gone.
    pub(crate) at_end: Option<StageMemory>,
}

impl OtherMemory {
    /// That of the render of `blocks` of passes, with a sum for each.
    pub(crate) fn of_part(blocks: &Range<u32>) -> Self {
        OtherMemory {
            sums: blocks.len(),
            ..OtherMemory::default()
        }
    }
}

/// Refuses a render with an estimated memory above `limit`, or above what the machine has left if
/// there is no limit.
pub(crate) fn check_memory(
    limit: Option<u64>,
    job: &RenderJob,
    other: OtherMemory,
) -> Result<(), Failure> {
    let scene = StageMemory {
        stage: Stage::Scene,
        bytes: resident_bytes(),
    };
    let available = || available_bytes().map(|left| left.saturating_add(scene.bytes));
    let Some(most) = limit.or_else(available) else {
        return Ok(());
    };
    let stages = stages_at_once(scene, job, other);
    if sum(&stages) <= most {
        return Ok(());
    }
    Err(refusal(limit, most, job, &stages))
}

/// The stages that are in memory together when it is largest: during the passes, or at the end.
fn stages_at_once(scene: StageMemory, job: &RenderJob, other: OtherMemory) -> Vec<StageMemory> {
    let OtherMemory {
        sums,
        beside,
        at_end,
    } = other;
    let mut stages = vec![scene];
    let (unguided, passes) = (EmissionGuide::default(), job.budget.passes);
    let guide = job.guide.unwrap_or(&unguided);
    let sets = match job.lights {
        Some(_) => LightSets::Given,
        None if job.frame.is_some() => LightSets::All,
        None => LightSets::One,
    };
    let method = (&job.method, sets);
    let (film, of_passes): (Vec<_>, Vec<_>) =
        estimated_memory(method, job.scene, guide, passes, sums, job.seed)
            .into_iter()
            .partition(|memory| memory.stage == Stage::Film);
    stages.extend(film.into_iter().filter(|_| sums > 0));
    stages.extend(beside);
    let at_end: Vec<StageMemory> = at_end.into_iter().chain(kept(&of_passes)).collect();
    stages.extend(if sum(&at_end) > sum(&of_passes) {
        at_end
    } else {
        of_passes
    });
    stages
}

/// The message of a render that would take more than `most` bytes.
fn refusal(limit: Option<u64>, most: u64, job: &RenderJob, stages: &[StageMemory]) -> Failure {
    let size = job.scene.sensor.desc().film.crop_size;
    let part = |memory: &StageMemory| {
        let pixels = match memory.stage {
            Stage::Film => format!(" of {} x {} pixels", size.x, size.y),
            _ => String::new(),
        };
        let bytes = human_bytes(memory.bytes);
        format!("{}{pixels} {bytes}", memory.stage.name())
    };
    let parts: Vec<String> = stages.iter().map(part).collect();
    let against = match limit {
        Some(limit) => format!("--memory-limit is {}", human_bytes(limit)),
        None => format!("{} are available", human_bytes(most)),
    };
    let largest = stages.iter().max_by_key(|memory| memory.bytes);
    let mut help = largest.map_or("", |memory| remedy(memory.stage)).to_owned();
    if limit.is_none() {
        help += "; a larger --memory-limit overrides what is available";
    }
    Failure::usage(
        format!(
            "the render would take about {} ({}); {against}",
            human_bytes(sum(stages)),
            parts.join(", "),
        ),
        help,
    )
}

/// [`check_memory`] of the lights of all passes of `job`, before they are made.
pub(crate) fn check_memory_of_lights(limit: Option<u64>, job: &RenderJob) -> Result<(), Failure> {
    let job = RenderJob {
        frame: Some(0),
        ..job.clone()
    };
    check_memory(limit, &job, OtherMemory::default())
}

/// What the allocator keeps of the passes when they have ended: the lists of photons of tasks, one
/// of two copies.
fn kept(of_passes: &[StageMemory]) -> Option<StageMemory> {
    let photons = of_passes
        .iter()
        .find(|memory| memory.stage == Stage::Photons)?;
    Some(StageMemory {
        stage: photons.stage,
        bytes: photons.bytes / 2,
    })
}

/// Bytes of all stages.
fn sum(stages: &[StageMemory]) -> u64 {
    let bytes = stages.iter().map(|stage| stage.bytes);
    bytes.fold(0, u64::saturating_add)
}

/// What makes a stage smaller.
fn remedy(stage: Stage) -> &'static str {
    match stage {
        Stage::Film | Stage::Maps | Stage::Image => {
            "reduce --size, which the scene file gives by default, or --aov"
        }
        Stage::Preview => "reduce --size",
        Stage::Denoiser => "reduce --size, or omit --denoise",
        Stage::Photons | Stage::Importons | Stage::RadianceCache => "reduce --photons, or --lights",
        Stage::Lights => "reduce --lights or --table-size, or use --emission vmf",
        Stage::Scene => "simplify the scene: fewer triangles, smaller textures",
    }
}

/// Memory that the process may still take, in bytes: the least of what the machine and the control
/// group have left. `None` if the system does not tell.
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

/// Bytes per pixel of the denoiser: 1250 at 1280x720, 1350 at 640x360 (Open Image Denoise 2.5).
const DENOISER: u64 = 1300;
/// Bytes of an encoded channel over the bytes of its values: 0.1 to 0.9.
const ENCODED: f64 = 0.5;

/// Memory of the denoiser, or of the image of a render while its files are written.
pub(crate) fn image_memory(request: &RenderRequest, job: &RenderJob) -> StageMemory {
    let size = job.scene.sensor.desc().film.crop_size;
    let pixels = u64::from(size.x) * u64::from(size.y);
    if request.denoise.denoise.is_some() {
        return StageMemory {
            stage: Stage::Denoiser,
            bytes: pixels.saturating_mul(DENOISER),
        };
    }
    // The values, and those of the encoder.
    let copies = if have_layers(&request.outputs) {
        2.0 + ENCODED
    } else {
        1.0
    };
    let channels = picture::channel_count(&job.method.layers(), &job.method.extra.id_layers());
    let values = pixels.saturating_mul((channels * size_of::<f32>()) as u64);
    StageMemory {
        stage: Stage::Image,
        bytes: (copies * values as f64) as u64,
    }
}

/// The number of sums over passes that a render of `job` holds at once.
pub(crate) fn sums_of_render(job: &RenderJob) -> usize {
    let is_one_block = job.budget.passes.is_some_and(|n| n <= job.block.get());
    if is_one_block { 1 } else { 2 }
}
