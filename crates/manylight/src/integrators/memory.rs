//! How much memory a render will take, told before it is taken.

use super::many_light::{EmissionKind, Strategy};
use super::{ManyLight, Method, MethodKind, PhotonMap};
use crate::bsdf::Lobes;
use crate::film::Film;
use crate::light_tree::LightTree;
use crate::particles::{Importon, Photon, trace_photons, usable_by_virtual_lights};
use crate::sampling::Pass;
use crate::scene::{PathLimits, Scene};
use crate::virtual_lights::VirtualLights;
use rayon::prelude::*;

/// What one stage holds at most, beside the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageMemory {
    /// Name of the stage.
    pub stage: &'static str,
    /// Bytes, as an estimate.
    pub bytes: u64,
}

/// Photon paths that tell how many photons a path leaves, and how many of them on glossy surfaces.
const PROBES: u32 = 4096;
/// A pass that no render gets to.
const LATE: u32 = 1 << 24;
/// Photons stand in memory by task before they stand in one list, and are sorted by keys.
const COPIES: f64 = 2.0;
/// Lights may be placed on glossy surfaces more often than photons arrive there, by so much.
const GLOSSY_PREFERENCE: f64 = 1.5;

impl Method {
    /// What a render of `passes` passes will take, or one that goes on without end; stage by stage. Traces some photons to find out.
    pub fn memory(&self, scene: &Scene, passes: Option<u32>, seed: u64) -> Vec<StageMemory> {
        let film = Film::bytes_for(scene.sensor.desc().film.crop_size, &self.layers());
        let mut stages = vec![StageMemory {
            stage: "film",
            bytes: film as u64,
        }];
        match &self.kind {
            MethodKind::ManyLight(method) => {
                let last = passes.map_or(LATE, |n| n.saturating_sub(1));
                stages.extend(method.memory(scene, self.limits, last, seed));
            }
            MethodKind::PhotonMap(method) => stages.push(method.memory(scene, self.limits, seed)),
            _ => {}
        }
        stages
    }
}

impl ManyLight {
    /// Of the largest set of lights for passes up to `last`.
    fn memory(&self, scene: &Scene, limits: PathLimits, last: u32, seed: u64) -> [StageMemory; 3] {
        let largest = self.passes_with(last);
        let dark = f64::from(self.placed_per_summed(&largest) - 1);
        let sets = f64::from(self.set_size(&largest));
        let probes = trace_photons(
            scene,
            limits,
            PROBES,
            Pass { seed, index: 0 },
            usable_by_virtual_lights,
        );
        let is_glossy = |photon: &&Photon| {
            let bsdf = scene.bsdf(&scene.surface_point(photon.at));
            bsdf.lobes().has(Lobes::GLOSSY)
        };
        let glossy = probes.par_iter().filter(is_glossy).count() as f64;
        let glossy = (GLOSSY_PREFERENCE * glossy / probes.len().max(1) as f64).min(1.0);
        let paths = f64::from(self.photon_paths) * sets;
        let importons = f64::from(self.importon_paths) * sets;
        let form = match self.emission {
            EmissionKind::Rich(form) => Some(form),
            EmissionKind::Single => None,
        };
        let tree = match self.strategy {
            Strategy::All => 0.0,
            Strategy::Cuts(_) => LightTree::bytes_per_light(form.map_or(1.0, |_| glossy)),
        };
        let light = VirtualLights::bytes_per_light(form, glossy, limits) + tree;
        let in_the_dark = VirtualLights::bytes_per_light(form, 0.0, limits);
        let stage = |stage, bytes: f64| StageMemory {
            stage,
            bytes: bytes as u64,
        };
        [
            photon_memory(&probes, paths),
            stage(
                "importons",
                importons * size_of::<Importon>() as f64 * COPIES,
            ),
            stage(
                "lights",
                f64::from(self.light_count) * sets * (light + dark * in_the_dark),
            ),
        ]
    }
}

impl PhotonMap {
    /// Of the photons of one pass.
    fn memory(&self, scene: &Scene, limits: PathLimits, seed: u64) -> StageMemory {
        let probes = self.trace_photons(scene, limits, PROBES, Pass { seed, index: 0 });
        photon_memory(&probes, f64::from(self.photon_paths))
    }
}

/// Of the photons of so many paths, told by those of [`PROBES`] paths.
fn photon_memory(probes: &[Photon], paths: f64) -> StageMemory {
    let photons = probes.len() as f64 / f64::from(PROBES) * paths;
    StageMemory {
        stage: "photons",
        bytes: (photons * size_of::<Photon>() as f64 * COPIES) as u64,
    }
}
