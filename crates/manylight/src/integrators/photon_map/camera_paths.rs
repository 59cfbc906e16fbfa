//! The camera paths of the photon-map methods. All paths of a tile advance together, in rounds.

use super::arriving::Arriving;
use super::{Estimate, PhotonMap};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::MAX_ENVIRONMENT_LOBES;
use crate::film::{FilmSampler, TileSamples};
use crate::integrators::camera_round::{CameraPath, CameraRound, CameraStart, FirstPart};
use crate::integrators::connections::Connections;
use crate::integrators::context::PassContext;
use crate::integrators::first_event::SampleShare;
use crate::integrators::partition::PathStage;
use crate::maps::{IncidentMap, KdTree, Neighbors};
use crate::particles::Photon;
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::stream::{Walks, follow_all, shade_packets};

/// What a pass shades with.
pub(super) struct PhotonMapPass<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) method: PhotonMap,
    pub(super) photons: KdTree<Photon>,
    /// Photons that arrive straight from the environment.
    pub(super) incident: IncidentMap,
    /// See [`Bandwidth`](crate::maps::density::Bandwidth).
    pub(super) radius_scale: f32,
    /// Camera paths per pixel.
    pub(super) camera_paths: u32,
}

/// What is kept for a camera path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    /// Index of its pixel in the tile.
    pub(super) pixel: u32,
    pub(super) stage: PathStage,
    /// It ends at the next surface or in the environment, with the light of emitters.
    pub(super) ends: bool,
    /// Whether it accounts for light of emitters that it meets.
    meets_emitters: bool,
    /// Whether its first surface fills the layers that describe it.
    describes: bool,
    /// See [`FirstPart`].
    hidden: f32,
    event: SampleShare,
}

impl PathState {
    /// After a scattering event of class `event`. After a non-specular event, photons estimate what emitters send by specular events.
    #[inline(always)]
    pub(super) fn after(self, event: Lobes) -> Self {
        let stage = self.stage.after(event);
        PathState {
            stage,
            meets_emitters: stage == PathStage::BeforeX || !event.has(Lobes::SPECULAR),
            ..self
        }
    }

    /// Ends at the next surface.
    #[inline(always)]
    pub(super) fn ending(self) -> Self {
        PathState { ends: true, ..self }
    }
}

impl CameraPath for PathState {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        Some(FirstPart {
            pixel: self.pixel,
            hidden: self.hidden,
            event: self.event,
            surface_share: f32::from(u8::from(self.describes)),
        })
    }
}

/// The camera paths of a tile.
pub(super) struct TilePaths<'p, 's, 'o, 't> {
    pub(super) pass: &'p PhotonMapPass<'s>,
    pub(super) out: &'o mut TileSamples<'t>,
    pub(super) connections: Connections,
    /// Memory for queries of photons, and of the environment guide.
    pub(super) found: Neighbors,
    pub(super) found_incident: Neighbors,
}

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
            out,
            connections: Connections::default(),
            found: Neighbors::new(self.method.neighbors.max(1) as usize),
            found_incident: Neighbors::new(MAX_ENVIRONMENT_LOBES),
        };
        let mut shadow_rays = 0;
        follow_all(scene, walks, |walks, arrivals, next| {
            let round = CameraRound {
                scene,
                limits: self.limits,
                walks,
                arrivals,
            };
            let add = |path: &PathState, radiance, out: &mut TileSamples| {
                self.add_emitted(path, radiance, out);
            };
            round.leave(|_| None, add, tile.out);
            let mut arriving = Arriving {
                round,
                next,
                tile: &mut tile,
            };
            shade_packets(arrivals.runs(), &mut arriving);
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
        let mut walks = Walks::with_capacity(window.count() * self.camera_paths as usize);
        for sample in 0..self.camera_paths {
            // Samples are numbered through all passes.
            let pass = Pass {
                index: run.pass.index.wrapping_mul(self.camera_paths) + sample,
                ..run.pass
            };
            for (index, pixel) in window.pixels().enumerate() {
                let number = positions.index(pixel);
                let mut sampler = pass.sampler(Stream::Pixel, number);
                let u = pass.low_discrepancy_2d(Stream::Pixel, number);
                let scene = (self.scene, self.limits);
                let start = CameraStart::new(scene, positions, (pixel, u), sampler.next_2d());
                let path = PathState {
                    pixel: index as u32,
                    stage: PathStage::BeforeX,
                    ends: false,
                    meets_emitters: true,
                    describes: sample == 0,
                    hidden: start.hidden,
                    event: SampleShare {
                        filter_weight: start.filter_weight,
                        share: 1.0 / self.camera_paths as f32,
                    },
                };
                walks.push(start.walk(1, sampler, path));
            }
        }
        walks
    }

    /// Adds radiance of an emitter that a path meets, weighted by its throughput.
    pub(super) fn add_emitted(&self, path: &PathState, radiance: Rgb, out: &mut TileSamples) {
        if path.meets_emitters {
            let value = radiance / self.camera_paths as f32;
            out.add(path.pixel as usize, path.stage.layer(), value);
        }
    }

    /// Whether photons estimate the light of emitters on lobes that gather.
    pub(super) fn gathers_emitters(&self) -> bool {
        self.method.estimate == Estimate::Direct
    }
}
