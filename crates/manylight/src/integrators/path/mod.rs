//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so that each of their terms can be checked by itself.
//!
//! The paths of a tile are a stream (`transport/stream`). In each round all follow their rays, the vertices are shaded in packets of one
//! material (`shade`), then all shadow rays are tested (`connections`).

mod shade;

use super::connections::Connections;
use super::context::PassContext;
use super::first_event::{FirstEvent, SampleShare, add_first_event};
use super::partition::PathStage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, TileSamples, Tiling};
use crate::math::UVec2;
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::stream::{WalkRow, Walks, follow_all, see_environment, shade_packets};
use crate::transport::walk::{Previous, visible_part};
use shade::Shading;

/// The tiles of a pass: large, so that most packets are full.
const TILING: Tiling = Tiling {
    edge: 64,
    shift: UVec2::ZERO,
};

/// What the path tracer keeps for each walk.
#[derive(Clone, Copy, Debug)]
struct PathState {
    /// Index of the pixel in the tile.
    pixel: u32,
    stage: PathStage,
    /// Weight by the reconstruction filter.
    filter_weight: f32,
    /// Length of the ray's part before its origin, which the camera must not see; in m.
    hidden: f32,
}

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, TILING, |samples| {
        let mut walks = Walks::with_capacity(samples.tile().count());
        for (index, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let at = positions.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let (ray, hidden) = visible_part(scene, limits.hide_emitters, camera.ray);
            walks.push(WalkRow {
                ray,
                throughput: [camera.weight * at.weight; 3],
                eta_squared: 1.0,
                segments: 0,
                previous: Previous::start(ray.o),
                sampler,
                kept: PathState {
                    pixel: index as u32,
                    stage: PathStage::BeforeX,
                    filter_weight: at.weight,
                    hidden,
                },
            });
        }
        Stats::count(&run.stats.camera_paths, walks.rays.len() as u64);
        let shadow_rays = trace(scene, limits, walks, samples);
        Stats::count(&run.stats.shadow_rays, shadow_rays);
    })
}

/// Follows all paths to their ends and returns the number of shadow rays.
fn trace(scene: &Scene, limits: PathLimits, walks: Walks<PathState>, out: &mut TileSamples) -> u64 {
    let mut connections = Connections::default();
    let mut shadow_rays = 0;
    follow_all(scene, walks, |walks, arrivals, next| {
        add_escapes(scene, limits, walks, &arrivals.escaped, out);
        let mut shading = Shading {
            scene,
            limits,
            walks,
            arrivals,
            next,
            connections: &mut connections,
            out,
        };
        shade_packets(arrivals.runs(), &mut shading);
        shadow_rays += connections.add_all(scene, out);
    });
    shadow_rays
}

/// Adds the environment to the walks that leave the scene.
fn add_escapes(
    scene: &Scene,
    limits: PathLimits,
    walks: &Walks<PathState>,
    escaped: &[u32],
    out: &mut TileSamples,
) {
    see_environment(
        scene,
        limits,
        walks,
        escaped,
        |_| None,
        |i, radiance| {
            add_emitted(walks, i, radiance, out);
        },
    );
    for &i in escaped {
        if walks.event(i) == Lobes::NONE {
            walks.kept[i as usize].add_event(scene, FirstEvent::escape(scene, limits), out);
        }
    }
}

/// Adds radiance emitted towards walk `i`.
#[inline(always)]
fn add_emitted(walks: &Walks<PathState>, i: u32, radiance: Rgb, out: &mut TileSamples) {
    if !radiance.is_black() {
        let path = walks.kept[i as usize];
        out.add(
            path.pixel as usize,
            path.stage.layer(),
            walks.throughput_of(i) * radiance,
        );
    }
}

impl PathState {
    /// Adds what the path has met first.
    fn add_event(&self, scene: &Scene, event: FirstEvent, out: &mut TileSamples) {
        let share = SampleShare {
            filter_weight: self.filter_weight,
            share: 1.0,
        };
        add_first_event(scene, event, share, self.pixel as usize, out);
    }
}
