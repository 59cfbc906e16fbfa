//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so that each of their terms can be checked by itself.
//!
//! The paths of a tile are a stream (`transport/stream`). In each round all follow their rays, the vertices are shaded in packets of one
//! material (`shade`), then all shadow rays are tested (`connections`).

mod shade;

use super::camera_round::{CameraPath, CameraRound, CameraStart, FirstPart};
use super::connections::Connections;
use super::context::PassContext;
use super::first_event::SampleShare;
use super::partition::PathStage;
use crate::film::{Film, TileSamples, Tiling};
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::stream::{Walks, follow_all, shade_packets};
use shade::Shading;

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
    run.shade(film, Tiling::OF_STREAMS, |samples| {
        let mut walks = Walks::with_capacity(samples.tile().count());
        for (index, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let u = sampler.next_2d();
            let start =
                CameraStart::new((scene, limits), &positions, (pixel, u), sampler.next_2d());
            let path = PathState {
                pixel: index as u32,
                stage: PathStage::BeforeX,
                filter_weight: start.filter_weight,
                hidden: start.hidden,
            };
            walks.push(start.walk(1, sampler, path));
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
        let round = CameraRound {
            scene,
            limits,
            walks,
            arrivals,
        };
        let add = |path: &PathState, radiance, out: &mut TileSamples| {
            out.add(path.pixel as usize, path.stage.layer(), radiance);
        };
        round.leave(|_| None, add, out);
        let mut shading = Shading {
            round,
            next,
            connections: &mut connections,
            out,
        };
        shade_packets(arrivals.runs(), &mut shading);
        shadow_rays += connections.add_all(scene, out);
    });
    shadow_rays
}

impl CameraPath for PathState {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        Some(FirstPart {
            pixel: self.pixel,
            hidden: self.hidden,
            event: SampleShare {
                filter_weight: self.filter_weight,
                share: 1.0,
            },
            surface_share: 1.0,
        })
    }
}
