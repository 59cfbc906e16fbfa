//! Memory that a render takes, estimated before it is taken.

use super::many_light::{Compensation, ManyLight, RadianceCache, Strategy, with_most_photons};
use super::method::{Method, MethodKind};
use super::mixed::Mixed;
use super::photon_map::PhotonMap;
use crate::bsdf::Lobes;
use crate::emitters::EmissionGuide;
use crate::film::Film;
use crate::light_tree::LightTree;
use crate::particles::{Importon, Photon, trace_photons, usable_by_virtual_lights};
use crate::sampling::Pass;
use crate::scene::{PathLimits, Scene};
use crate::virtual_lights::VirtualLights;
use rayon::prelude::*;

/// What a render needs memory for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The scene, and all that the process has before the render.
    Scene,
    /// Sums over passes.
    Film,
    /// Photons.
    Photons,
    /// Importons.
    Importons,
    /// The radiance cache.
    RadianceCache,
    /// Virtual lights, with their trees.
    Lights,
    /// Maps of importance and flux.
    Maps,
    /// The picture while it is written.
    Image,
    /// Pictures of a preview.
    Preview,
    /// The denoiser.
    Denoiser,
}

impl Stage {
    /// A word for messages.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Scene => "scene",
            Stage::Film => "film",
            Stage::Photons => "photons",
            Stage::Importons => "importons",
            Stage::RadianceCache => "radiance cache",
            Stage::Lights => "lights",
            Stage::Maps => "maps",
            Stage::Image => "image",
            Stage::Preview => "preview",
            Stage::Denoiser => "denoiser",
        }
    }
}

/// Most memory of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageMemory {
    /// The stage.
    pub stage: Stage,
    /// Bytes, as an estimate.
    pub bytes: u64,
}

/// How many sets of virtual lights are in memory at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSets {
    /// That of a group of passes.
    One,
    /// Those of all groups, made for many passes at once.
    All,
    /// Those that were made before, which are not counted.
    Given,
}

/// Photon paths traced to estimate the number of photons per path, and the fraction of them on
/// glossy surfaces.
const PROBES: u32 = 4096;
/// Index of a pass that no render reaches, for renders without a limit of passes.
const LATE_PASS: u32 = 1 << 24;
/// Copies of particles in memory: lists of tasks before one list of all, and sorted copies after.
const COPIES: f64 = 2.0;
/// Factor on the fraction of glossy photons: placement by importance may prefer glossy surfaces.
/// The fraction of glossy lights is 0.3 to 1.35 times that of photons in nine scenes; in veach-ajar
/// it is 0.12 instead of 0.012.
const GLOSSY_PREFERENCE: f64 = 1.5;

/// Memory of a render by `method` of `passes` passes, or of one without end, stage by stage. `sums`
/// is the number of sums over passes that are held at once: see [`Film::bytes_for`]. Traces some
/// photons by `guide`, which is that of the render.
pub fn estimated_memory(
    (method, sets): (&Method, LightSets),
    scene: &Scene,
    guide: &EmissionGuide,
    passes: Option<u32>,
    sums: usize,
    seed: u64,
) -> Vec<StageMemory> {
    let (size, layers) = (scene.sensor.desc().film.crop_size, method.layers());
    let mut film = Film::bytes_for(size, &layers, &method.extra.id_layers(), sums);
    if let MethodKind::Mixed(_) = method.kind {
        film = film.saturating_add(Mixed::bytes_for(size, &layers));
    }
    let mut stages = vec![StageMemory {
        stage: Stage::Film,
        bytes: film,
    }];
    let probes = Probes { scene, guide, seed };
    match &method.kind {
        MethodKind::ManyLight(_) | MethodKind::Mixed(_) if sets == LightSets::Given => {}
        MethodKind::ManyLight(lights) | MethodKind::Mixed(Mixed { lights, .. }) => {
            let last = passes.map_or(LATE_PASS, |n| n.saturating_sub(1));
            let (lights, kept) = match sets {
                LightSets::One | LightSets::Given => (with_most_photons(lights, scene), 1),
                LightSets::All => {
                    let lights = with_most_photons(&lights.of_frames(passes), scene);
                    (lights, passes.map_or(1, |n| lights.group_count(n)))
                }
            };
            let group = of_many_light(&lights, probes, method, last);
            stages.extend(group.map(|stage| StageMemory {
                bytes: stage.bytes.saturating_mul(u64::from(kept)),
                ..stage
            }));
        }
        MethodKind::PhotonMap(map) => {
            stages.push(of_photon_map(map, probes, method.limits));
        }
        _ => {}
    }
    stages
}

/// Of the largest group of passes of `lights` up to `last`, in a render by `method`.
fn of_many_light(
    lights: &ManyLight,
    probes: Probes,
    method: &Method,
    last: u32,
) -> [StageMemory; 4] {
    let (scene, limits) = (probes.scene, method.limits);
    let group = lights.pass_group(last);
    let unshaded = f64::from(group.placed_per_shaded - 1);
    let shaded = f64::from(lights.light_count) * f64::from(group.subsets);
    let probes = probes.photons(limits, usable_by_virtual_lights);
    let is_glossy = |photon: &&Photon| {
        let bsdf = scene.bsdf(&scene.surface_point(photon.at));
        bsdf.lobes().has(Lobes::GLOSSY)
    };
    let glossy = probes.par_iter().filter(is_glossy).count() as f64;
    let glossy = (GLOSSY_PREFERENCE * glossy / probes.len().max(1) as f64).min(1.0);
    let form = lights.emission.glossy_form();
    let glossy_nodes = form.map_or(1.0, |_| glossy);
    let tree = match lights.strategy {
        Strategy::All => 0.0,
        Strategy::Cuts(_) => LightTree::bytes_per_light(glossy_nodes),
        Strategy::Bidirectional(_) => LightTree::bytes_per_light(2.0 * glossy_nodes),
    };
    let light = VirtualLights::bytes_per_light(form, glossy, limits) + tree;
    let unshaded_light = VirtualLights::bytes_per_light(form, 0.0, limits);
    let importons = f64::from(group.importon_paths) * size_of::<Importon>() as f64;
    let photons = photons_of(&probes, f64::from(group.photon_paths));
    let cache = match lights.compensation {
        Compensation::None => 0.0,
        Compensation::KolligKeller => {
            let light_groups = method.extra.light_groups;
            RadianceCache::bytes_for(photons, group.passes.len(), light_groups) * COPIES
        }
    };
    let stage = |stage, bytes: f64| StageMemory {
        stage,
        bytes: bytes as u64,
    };
    [
        photon_memory(&probes, f64::from(group.photon_paths)),
        stage(Stage::Importons, importons * COPIES),
        stage(Stage::RadianceCache, cache),
        stage(Stage::Lights, shaded * (light + unshaded * unshaded_light)),
    ]
}

/// Of the photons of one pass.
fn of_photon_map(method: &PhotonMap, probes: Probes, limits: PathLimits) -> StageMemory {
    let photons = probes.photons(limits, |surface, event| {
        method.segments_added(probes.scene, surface, event)
    });
    photon_memory(&photons, f64::from(method.photon_paths))
}

/// Photon paths that are traced for an estimate.
#[derive(Clone, Copy)]
struct Probes<'a> {
    scene: &'a Scene,
    guide: &'a EmissionGuide,
    seed: u64,
}

impl Probes<'_> {
    /// The photons of [`PROBES`] paths; `segments_added` as in [`trace_photons`].
    fn photons(
        &self,
        limits: PathLimits,
        segments_added: impl Fn(Lobes, Lobes) -> Option<u32> + Sync,
    ) -> Vec<Photon> {
        let pass = Pass {
            seed: self.seed,
            index: 0,
        };
        trace_photons(self.scene, self.guide, limits, PROBES, pass, segments_added)
    }
}

/// Of the photons of `paths` photon paths, estimated by those of [`PROBES`] paths.
fn photon_memory(probes: &[Photon], paths: f64) -> StageMemory {
    let photons = photons_of(probes, paths);
    StageMemory {
        stage: Stage::Photons,
        bytes: (photons * size_of::<Photon>() as f64 * COPIES) as u64,
    }
}

/// Number of photons of `paths` photon paths.
fn photons_of(probes: &[Photon], paths: f64) -> f64 {
    probes.len() as f64 / f64::from(PROBES) * paths
}
