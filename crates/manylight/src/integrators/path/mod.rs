//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so that each of their terms can be checked
//! by itself.
//!
//! The paths of a tile are a stream (`transport/stream`). In each round all follow their rays, the
//! vertices are shaded in packets of one material (`shade`), then all shadow rays are tested
//! (`connections`).
//!
//! The numbers of film, lens and first vertices are low-discrepancy sequences over the passes
//! (`numbers`).

mod numbers;
mod shade;
mod state;

use super::camera_round::{SeenEmission, follow_paths};
use super::camera_starts::start_paths;
use super::connections::Connections;
use super::context::PassContext;
use super::partition::PathStage;
use crate::film::{
    Film, FilmSampler, IdLayer, Layer, ShadedPixels, TileSamples, Tiling, shaded_pixels,
};
use crate::sampling::Pass;
use crate::scene::{LimitedScene, PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::stream::{WalkStream, Walks, shade_packets};
use shade::Shading;
use state::PathState;
use std::cell::Cell;

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, Tiling::OF_STREAMS, |samples| {
        shade_tile(LimitedScene { scene, limits }, run, &positions, samples);
    })
}

/// Sums over samples of each pixel of `positions`, one by the numbers of each of `passes`. Terms
/// count in the layers of light groups by `group_weight`.
/// Unfinished if it is cancelled.
pub(super) fn sums_of_samples(
    scene: LimitedScene,
    run: &PassContext,
    (positions, tiling): (&FilmSampler, Tiling),
    layers: (&[Layer], &[IdLayer]),
    passes: impl Iterator<Item = Pass> + Clone + Sync,
    group_weight: impl Fn(Layer) -> f32 + Sync,
) -> ShadedPixels {
    shaded_pixels(positions.size(), tiling, layers, |tile| {
        tile.weigh_light_groups(&group_weight);
        for pass in passes.clone() {
            if run.cancelled() {
                return;
            }
            shade_tile(scene, &run.with_pass(pass), positions, tile);
        }
    })
}

thread_local! {
    /// What a thread takes from tile to tile. Without it the allocator gives the memory back after
    /// each tile, and the system clears it anew: 6 % of the time in the Cornell box, 2 % in the
    /// garage.
    static MEMORY: Cell<Option<TileMemory>> = const { Cell::new(None) };
}

/// The memory of the paths of a tile.
struct TileMemory {
    stream: WalkStream<PathState>,
    connections: Connections,
}

/// Adds one sample to each pixel of a tile.
pub(super) fn shade_tile(
    scene: LimitedScene,
    run: &PassContext,
    positions: &FilmSampler,
    samples: &mut TileSamples,
) {
    let stage = PathStage::BeforeX;
    let path = |first, sequences| PathState {
        first,
        stage,
        sequences,
    };
    let mut memory = MEMORY.take().unwrap_or_else(|| TileMemory {
        stream: WalkStream::new(Walks::with_capacity(samples.tile().count())),
        connections: Connections::of(samples),
    });
    memory.connections.begin(samples);
    let walks = &mut memory.stream.walks;
    start_paths(scene, run, positions, samples, path, walks);
    Stats::count(&run.stats.camera_paths, walks.rays.len() as u64);
    let shadow_rays = trace(scene.scene, scene.limits, &mut memory, samples);
    Stats::count(&run.stats.shadow_rays, shadow_rays);
    MEMORY.set(Some(memory));
}

/// Follows all paths to their ends and returns the number of shadow rays.
fn trace(scene: &Scene, limits: PathLimits, memory: &mut TileMemory, out: &mut TileSamples) -> u64 {
    let TileMemory {
        stream,
        connections,
    } = memory;
    let mut shadow_rays = 0;
    follow_paths(scene, limits, stream, |round, next| {
        let add = |path: &PathState, seen: SeenEmission, out: &mut TileSamples| {
            path.add_emitted(scene, seen, out);
        };
        round.leave(|_| None, add, out);
        let mut shading = Shading {
            round,
            next,
            connections: &mut *connections,
            out,
        };
        shade_packets(round.arrivals.runs(), &mut shading);
        shadow_rays += connections.add_all(scene, out);
    });
    shadow_rays
}
