//! The method of the paper: indirect light from virtual lights. Start reading at [`ManyLight::prepare`].
//!
//! | stage | file |
//! |---|---|
//! | which passes share a set of lights, and how far it is refined | `schedule.rs` |
//! | 1. trace photons from the emitters and importons from the camera | `trace.rs` |
//! | 2. place: keep photons as sites of lights, by importance times flux | `place.rs` |
//! | 3. assign the flux of every photon to a light | `assign.rs` |
//! | 4. build the outgoing radiance distribution of every light | `build.rs` |
//! | 5. shade every pixel by the lights | `shade.rs`, see there for its stages |
//!
//! The settings are in `settings.rs`, their axes in `axes.rs`, the named methods in `presets.rs`.
//! [`super::partition`] defines which path belongs to which film layer.
//!
//! Source: Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light Methods", Eurographics 2015.

mod assign;
mod axes;
mod build;
mod camera_paths;
mod compensation;
mod compensation_photons;
mod cut_tolerance;
mod density_estimates;
mod gather_points;
mod gathering;
mod interim_maps;
mod next_event;
mod place;
mod prepared;
mod presets;
mod schedule;
mod settings;
mod shade;
mod specular_chains;
mod trace;

pub use crate::gather::{CutLimits, Kernel, ShareOf, Strategy};
pub use crate::virtual_lights::{GlossyForm, TableStorage};
pub use axes::{ClampRule, Compensation, EmissionKind, FluxRule, Placement, Resampling};
pub use cut_tolerance::DARKEST_PIXEL;
pub use interim_maps::{InterimMaps, PlacedLight};
pub use prepared::PreparedPasses;
pub use schedule::PassGroup;
pub use settings::ManyLight;

use super::context::PassContext;
use crate::film::Film;
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use prepared::PixelFootprint;
use schedule::LightSubsets;

impl ManyLight {
    /// Everything that the passes of `group` shade with: the method up to shading.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        group: &PassGroup,
        run: &PassContext,
    ) -> PreparedPasses<'s> {
        let run = &run.at_pass(group.passes.start);

        // 1. Trace photons. Some of them serve by themselves: those of the environment guide directions, those of caustics
        //    are looked up at gather points, and some that were reflected compensate clamping.
        let photons = trace::photons(scene, limits, group, run);
        let (incident, caustics) = trace::maps(scene, &photons, run);
        let reflected = compensation_photons::reflected(scene, &photons, self.compensation, run);

        // 2. Place lights on photons, by importance times flux.
        let candidates = place::candidates(self, scene, limits, group, photons, run);
        let sites = place::sites(self, scene, group, &candidates, run);

        // 3. Assign the flux of the photons to the lights.
        let (clusters, nearest) = assign::clusters(self, scene, group, &candidates, &sites, run);

        // 4. Build the emission of the lights that the passes divide among them.
        let u = run.pass.sampler(Stream::Selection, 1).next_1d();
        let subsets = LightSubsets::divide(self, group, clusters.len(), u);
        let made_of = (candidates.photons.as_slice(), &clusters);
        let lights = build::lights(self, scene, limits, made_of, &subsets, run);
        let gather = build::gather(self, group, &lights, &subsets);
        let lights = build::index(self, lights, run);

        // 5. Shade: see [`PreparedPasses::shade_tile`].
        let subset = subsets.of_pass(group.passes.start);
        let compensation_photons = run.stats.time("maps", || {
            compensation_photons::assign(scene, &gather, &lights, &nearest, subset, reflected)
        });
        PreparedPasses {
            tolerance: cut_tolerance::tolerance(scene, &gather, &lights, run.pass),
            pixel: PixelFootprint::of(scene),
            group: group.clone(),
            compensation: self.compensation,
            scene,
            limits,
            gather,
            lights,
            subsets,
            nearest,
            incident,
            caustics,
            compensation_photons,
        }
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
        run.shade(
            film,
            shade::tile_shift(self.strategy, run.pass),
            |samples| {
                prepared.shade_tile(run, &positions, samples);
            },
        )
    }
}
