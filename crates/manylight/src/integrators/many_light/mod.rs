//! The method of the paper: indirect light from virtual lights. Start reading at
//! [`ManyLight::prepare`].
//!
//! | stage | file |
//! |---|---|
//! | how many lights and emitter samples suit the scene | `effort.rs` |
//! | which passes share a set of lights, and how far it is refined | `schedule.rs` |
//! | 1. trace photons from the emitters; importons from the camera, when placement needs them | `trace.rs` |
//! | 2. place: photons become sites of lights, by importance times flux | `lights.rs` |
//! | 3. assign the flux of every photon to a light | `lights.rs` |
//! | 4. build the radiant intensity of every light | `lights.rs` |
//! | 5. prepare the compensation of clamping: a radiance cache, and photons | `radiance_cache.rs`, `compensation_photons.rs` |
//! | 6. shade every pixel by the lights | `shade.rs`, see there for its stages |
//!
//! Stages 2 to 4 are made of the modules of [`crate::virtual_lights`]. The settings, their axes and
//! the named methods are in `settings.rs`. [`super::partition`] defines which path belongs to which
//! film layer.
//!
//! Source: Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light
//! Methods", Eurographics 2015.

mod chain;
mod chain_densities;
mod compensation;
mod compensation_photons;
mod density_estimates;
mod direction;
mod effort;
mod gather_point;
mod interim_maps;
mod kept;
mod lights;
mod passes;
mod paths;
mod prefix;
mod radiance_cache;
mod schedule;
mod settings;
mod shade;
mod trace;

pub use crate::gather::{CutLimits, Kernel, Strategy};
pub use crate::virtual_lights::{GlossyForm, TableStorage};
pub(super) use effort::{
    LAYERS as EFFORT_LAYERS, LightPictures, RELMSE_FLOOR, with_fixed_effort, with_most_photons,
};
pub use interim_maps::{InterimMaps, PlacedLight};
pub use kept::{KeptLights, LightsContext, NotKept};
pub use lights::DARKEST_PIXEL;
pub(super) use passes::PreparedGroups;
pub use passes::PreparedPasses;
pub(super) use radiance_cache::RadianceCache;
pub use schedule::PassGroup;
pub use settings::{
    ClampRule, Compensation, Contradiction, Effort, EmissionKind, FluxRule, MAX_CAMERA_PATHS,
    MAX_INTERLEAVING, ManyLight, PHOTON_PATHS_PER_LIGHT, Placement, Resampling,
};

use super::context::PassContext;
use crate::emitters::RayDensities;
use crate::film::{Film, TileSamples};
use crate::scene::{LimitedScene, PathLimits, Scene};
use radiance_cache::CacheParticles;
use schedule::{GroupContext, LightSubsets};
use trace::PhotonMaps;

impl ManyLight {
    /// The method up to shading: everything that the passes of `group` shade with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        group: &PassGroup,
        run: &PassContext,
    ) -> PreparedPasses<'s> {
        let cx = &GroupContext {
            method: self,
            scene,
            limits,
            group,
            run: run.of_lights(group.passes.start),
        };
        // 1. Trace photons from the emitters.
        let photons = trace::photons(cx);
        let maps = PhotonMaps::of(cx, &photons);
        // 2. Place lights on photons, by importance times flux. Importance comes from importons,
        //    traced from the camera.
        let candidates = lights::candidates(cx, photons);
        let cache_particles = CacheParticles::draw(cx, &candidates);
        let candidates = lights::thinned(cx, candidates);
        let sites = lights::sites(cx, &candidates);
        // 3. Assign the flux of all photons to the lights.
        let (clusters, nearest) = lights::clusters(cx, &candidates, &sites);
        // 4. Build the emission of the lights that the passes divide among them.
        let subsets = LightSubsets::divide(cx, clusters.len());
        let lights = lights::lights(cx, &candidates.photons, &clusters, &subsets);
        let gather = lights::gather(self, group, &lights, &subsets);
        let lights = lights::index(cx, lights);
        let tolerance = lights::cut_tolerance(cx, &gather, &lights);
        // 5. Compensate clamping: by directions that end at a radiance cache, and by photons.
        let cache = RadianceCache::new(cx, cache_particles, &nearest);
        let clamping = (&gather, &subsets);
        let compensation_photons =
            compensation_photons::assigned(cx, maps.reflected, clamping, &lights, &nearest);
        // 6. Shade: [`PreparedPasses::shade_tile`].
        PreparedPasses {
            scene,
            limits,
            group: group.clone(),
            light_groups: run.light_groups,
            compensation: self.compensation,
            emitter_samples: self.emitter_samples,
            camera_paths: self.started_paths(),
            gather,
            lights,
            subsets,
            tolerance,
            nearest,
            incident: maps.incident,
            caustics: maps.caustics,
            ray_densities: RayDensities::new(run.guide, &scene.emitters, group.photon_paths),
            cache,
            compensation_photons,
        }
    }

    /// The group of pass `index`. It depends on the settings and the index alone.
    pub fn pass_group(&self, index: u32) -> PassGroup {
        PassGroup::of_pass(self, index)
    }

    /// The maps of the pass that `run` names, in a group of that pass alone. `None` if cancelled.
    pub fn interim_maps(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> Option<InterimMaps> {
        interim_maps::interim_maps(self, scene, limits, run)
    }

    /// The camera paths of one pass, shaded by its lights, before and after which `begin` and `end`
    /// are called for each tile, with the lights of its group from `kept`. `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        LimitedScene { scene, limits }: LimitedScene<'s>,
        run: &PassContext,
        kept: &mut PreparedGroups<'s>,
        film: &mut Film,
        (begin, end): (
            impl Fn(&mut TileSamples) + Sync,
            impl Fn(&mut TileSamples) + Sync,
        ),
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let group = self.pass_group(run.pass.index);
        let prepared = kept.of_group(&group, || self.prepare(scene, limits, &group, run));
        let positions = film.desc().sampler();
        run.shade(film, shade::tiling(self, run.pass), |samples| {
            begin(samples);
            prepared.shade_tile(run, &positions, samples);
            end(samples);
        })
    }
}
