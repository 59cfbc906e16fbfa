//! The camera paths of the photon-map methods, and what those of a tile share.

use super::{Estimate, PhotonMap};
use crate::bsdf::Lobes;
use crate::film::TileSamples;
use crate::integrators::camera_round::{CameraPath, FirstPart, SeenEmission};
use crate::integrators::connections::Connections;
use crate::integrators::partition::PathStage;
use crate::maps::{IncidentMap, KdTree, Neighbors};
use crate::particles::Photon;
use crate::scene::{PathLimits, Scene};

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

/// What a camera path carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub(super) first: FirstPart,
    pub(super) stage: PathStage,
    /// It ends at the next surface or in the environment, with the light of emitters.
    pub(super) ends: bool,
    /// Whether it accounts for light of emitters that it meets.
    pub(super) meets_emitters: bool,
}

impl PathState {
    /// After a scattering event of class `event`. After a non-specular event, photons estimate what
    /// emitters send by specular events.
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
        Some(self.first)
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
    /// Adds radiance of an emitter that a path meets.
    pub(super) fn add_emitted(&self, path: &PathState, seen: SeenEmission, out: &mut TileSamples) {
        if path.meets_emitters {
            let value = seen.at_camera() / self.camera_paths as f32;
            let to = (path.first.pixel, path.stage.layer());
            seen.add_to(self.scene, to, value, |_| 1.0, out);
        }
    }

    /// Whether photons estimate the light of emitters on lobes that gather.
    pub(super) fn gathers_emitters(&self) -> bool {
        self.method.estimate == Estimate::Direct
    }
}
