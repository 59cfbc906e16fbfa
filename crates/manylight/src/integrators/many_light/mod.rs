//! The method of the paper: indirect light from virtual lights. Start reading at [`ManyLight::prepare`].
//!
//! | stage | file |
//! |---|---|
//! | how many lights and emitter samples suit the scene | `effort.rs` |
//! | which passes share a set of lights, and how far it is refined | `schedule.rs` |
//! | 1. trace photons from the emitters; importons from the camera, when placement needs them | `trace.rs` |
//! | 2. place: keep photons as sites of lights, by importance times flux | `place.rs` |
//! | 3. assign the flux of every photon to a light | `assign.rs` |
//! | 4. build the radiant intensity of every light, and the radiance cache | `build.rs`, `radiance_cache.rs` |
//! | 5. shade every pixel by the lights | `shade.rs`, see there for its stages |
//!
//! The settings, their axes and the named methods are in `settings.rs`.
//! [`super::partition`] defines which path belongs to which film layer.
//!
//! Source: Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light Methods", Eurographics 2015.

mod arriving;
mod assign;
mod build;
mod camera_paths;
mod caustic_shares;
mod compensation;
mod compensation_photons;
mod cut_tolerance;
mod density_estimates;
mod effort;
mod gather_points;
mod gather_vertices;
mod gathering;
mod interim_maps;
mod paths;
mod place;
mod pre_pass;
mod prepared;
mod radiance_cache;
mod sampling_lanes;
mod schedule;
mod settings;
mod shade;
mod specular_chains;
mod trace;

pub use crate::gather::{CutLimits, Kernel, Strategy};
pub use crate::virtual_lights::{GlossyForm, TableStorage};
pub use cut_tolerance::DARKEST_PIXEL;
pub use interim_maps::{InterimMaps, PlacedLight};
pub use prepared::PreparedPasses;
pub(super) use radiance_cache::RadianceCache;
pub use schedule::PassGroup;
pub use settings::{
    ClampRule, Compensation, Contradiction, Effort, EmissionKind, FluxRule, ManyLight,
    PHOTON_PATHS_PER_LIGHT, Placement, Resampling,
};

use super::context::PassContext;
use crate::film::Film;
use crate::scene::{PathLimits, Scene};
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
            run: run.at_pass(group.passes.start),
        };
        // 1. Trace photons from the emitters.
        let photons = trace::photons(cx);
        let maps = PhotonMaps::of(cx, &photons);
        // 2. Place lights on photons, by importance times flux. Importance comes from importons, traced from the camera.
        let (candidates, particles) = place::candidates(cx, photons);
        let sites = place::sites(cx, &candidates);
        // 3. Assign the flux of all photons to the lights.
        let (clusters, nearest) = assign::clusters(cx, &candidates, &sites);
        // 4. Build the emission of the lights that the passes divide among them.
        let subsets = LightSubsets::divide(cx, clusters.len());
        let lights = build::lights(cx, &candidates.photons, &clusters, &subsets);
        let gather = build::gather(cx, &lights, &subsets);
        let index = build::index(cx, lights);
        let cache = build::radiance_cache(cx, particles, &nearest);
        // 5. Shade: [`PreparedPasses::shade_tile`].
        PreparedPasses::new(cx, gather, index, subsets, nearest, maps, cache)
    }

    /// One sample per pixel with the lights of one pass. `prepared` holds those of its group and is made where it is
    /// missing or of another group. `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        prepared: &mut Option<PreparedPasses<'s>>,
        film: &mut Film,
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let group = self.pass_group(run.pass.index);
        if prepared.as_ref().is_some_and(|made| made.group != group) {
            // Dropped before the next is made: both might not fit into memory.
            *prepared = None;
        }
        let prepared = prepared.get_or_insert_with(|| self.prepare(scene, limits, &group, run));
        let positions = film.desc().sampler();
        run.shade(film, shade::tiling(self.strategy, run.pass), |samples| {
            prepared.shade_tile(run, &positions, samples);
        })
    }
}
