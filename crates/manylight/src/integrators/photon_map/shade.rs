//! Shading of a tile. All its camera paths advance together, in rounds.

use super::arriving::Arriving;
use super::camera_paths::{PathState, PhotonMapPass, TilePaths};
use crate::emitters::MAX_ENVIRONMENT_LOBES;
use crate::film::{FilmSampler, TileSamples};
use crate::integrators::camera_round::{FirstPart, SeenEmission, follow_paths};
use crate::integrators::camera_starts::{CameraView, StartNumbers};
use crate::integrators::connections::Connections;
use crate::integrators::context::PassContext;
use crate::integrators::first_event::SampleShare;
use crate::integrators::partition::PathStage;
use crate::maps::Neighbors;
use crate::sampling::{Pass, Stream};
use crate::stats::Stats;
use crate::transport::stream::{WalkStream, Walks, shade_packets};

impl PhotonMapPass<'_> {
    pub(super) fn shade_tile(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &mut TileSamples,
    ) {
        let scene = self.scene;
        let walks = self.start_paths(run, positions, out);
        Stats::count(&run.stats.camera_paths, walks.rays.len() as u64);
        let mut tile = TilePaths {
            pass: self,
            connections: Connections::of(out),
            out,
            found: Neighbors::new(self.method.neighbors.max(1) as usize),
            found_incident: Neighbors::new(MAX_ENVIRONMENT_LOBES),
        };
        let mut shadow_rays = 0;
        let stream = &mut WalkStream::new(walks);
        follow_paths(scene, self.limits, stream, |round, next| {
            let add = |path: &PathState, seen: SeenEmission, out: &mut TileSamples| {
                self.add_emitted(path, seen, out);
            };
            round.leave(|_| None, add, tile.out);
            let mut arriving = Arriving {
                round,
                next,
                tile: &mut tile,
            };
            shade_packets(round.arrivals.runs(), &mut arriving);
            shadow_rays += tile.connections.add_all(scene, tile.out);
        });
        Stats::count(&run.stats.shadow_rays, shadow_rays);
    }

    /// The camera paths of a tile, at the camera.
    fn start_paths(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &TileSamples,
    ) -> Walks<PathState> {
        let window = out.tile();
        let view = CameraView {
            scene: self.scene,
            limits: self.limits,
            camera: run.camera,
            positions,
        };
        let mut walks = Walks::with_capacity(window.count() * self.camera_paths as usize);
        for sample in 0..self.camera_paths {
            // Samples are numbered through all passes.
            let pass = Pass {
                index: run.pass.index.wrapping_mul(self.camera_paths) + sample,
                ..run.pass
            };
            let starts = window.pixels().map(|pixel| {
                let number = positions.index(pixel);
                let mut sampler = pass.sampler(Stream::Pixel, number);
                let numbers = StartNumbers {
                    pixel,
                    film: pass.low_discrepancy_2d(Stream::Pixel, number),
                    lens: sampler.next_2d(),
                };
                (numbers, sampler)
            });
            let (numbers, samplers): (Vec<_>, Vec<_>) = starts.unzip();
            view.each_start(numbers.into_iter(), |i, start| {
                let path = PathState {
                    first: FirstPart {
                        pixel: i as u32,
                        hidden: start.hidden,
                        event: SampleShare {
                            filter_weight: start.filter_weight,
                            share: 1.0 / self.camera_paths as f32,
                        },
                        // The first of the paths fills the layers that describe first surfaces.
                        surface_share: f32::from(u8::from(sample == 0)),
                    },
                    stage: PathStage::BeforeX,
                    ends: false,
                    meets_emitters: true,
                };
                walks.push(start.walk(1, samplers[i].clone(), path));
            });
        }
        walks
    }
}
