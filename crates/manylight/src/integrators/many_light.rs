//! The method: light from virtual lights.
//!
//! Lights are made in the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]); then every pixel is shaded
//! by them (`light_set.rs`). What can be chosen is in `axes.rs`, what has a name in `presets.rs`. Which path belongs to which term is said in [`super::partition`].

pub use super::axes::{ClampRule, EmissionKind, FluxRule, Placement, Resampling};
use super::candidates::{Candidates, fluxes, importance_times_flux, light_carriers};
pub use super::light_set::Compensation;
use super::light_set::{PreparedPasses, pixel_width};
use super::{PassContext, carried};
use crate::bsdf::Lobes;
use crate::film::{Film, TILE_SIZE};
pub use crate::gather::{CutLimits, Kernel, ShareOf, Strategy};
use crate::gather::{Gather, LightIndex, Subset};
use crate::maps::{IncidentMap, KdTree};
use crate::math::UVec2;
use crate::particles::{
    Importon, Photon, trace_importons, trace_photons, usable_by_virtual_lights,
};
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::virtual_lights::density::by_density;
use crate::virtual_lights::relax::relax;
pub use crate::virtual_lights::{GlossyForm, TableStorage};
use crate::virtual_lights::{NearestLights, PhotonClusters, VirtualLights, assign};
use std::ops::Range;

/// Indirect light from virtual lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManyLight {
    /// Virtual lights per pass.
    pub light_count: u32,
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Importon paths per pass.
    pub importon_paths: u32,
    /// Where lights stand.
    pub placement: Placement,
    /// How much flux each carries.
    pub flux: FluxRule,
    /// Photons around a light that say what it shines, under [`FluxRule::Density`].
    pub neighbors: u32,
    /// What each shines.
    pub emission: EmissionKind,
    /// How one is evaluated.
    pub kernel: Kernel,
    /// Which are evaluated.
    pub strategy: Strategy,
    /// What is done about the singularity.
    pub clamp: ClampRule,
    /// How the light that the clamp takes away is given back.
    pub compensation: Compensation,
    /// Which lights the passes have.
    pub resampling: Resampling,
}

/// Passes that share one set of lights, at most; each shades by its own part of them.
const MAX_PASSES_PER_SET: u32 = 8;
/// No set for more than one pass has more lights than this,
const MAX_SET_LIGHTS: u32 = 32_768;
/// or is made of more photon paths.
const MAX_SET_PHOTON_PATHS: u32 = 1 << 22;
/// Lights that become finer are as fine as at the start for so many passes.
const COARSE_PASSES: f32 = 16.0;
/// A set has no more lights than this just to make them finer.
const MAX_FINER_LIGHTS: u32 = 1 << 18;

impl ManyLight {
    /// One sample per pixel under the lights of one pass, which are part of the set that is `kept` from pass to pass.
    /// `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        kept: &mut Option<PreparedPasses<'s>>,
        film: &mut Film,
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let passes = self.passes_with(run.pass.index);
        if kept.as_ref().is_some_and(|set| set.passes != passes) {
            // Before the next set is made: two of them might not fit.
            *kept = None;
        }
        let set = kept.get_or_insert_with(|| self.prepare(scene, limits, passes, run));
        let positions = film.desc().sampler();
        run.shade(film, self.tile_shift(run.pass), |samples| {
            set.shade_tile(run, &positions, samples);
        })
    }

    /// The passes that share the lights of pass `index`: one, then one, 2, 4, and 8 from there on, or fewer if the set would
    /// become too large. A cut is through all lights: then each has its own.
    ///
    /// A set for many passes is better than a set for each: lights that stand for fewer photons each are more alike, so that
    /// every eighth of 4096 lights is a better choice than eight times 512.
    pub(super) fn passes_with(&self, index: u32) -> Range<u32> {
        if self.strategy != Strategy::All {
            return index..index + 1;
        }
        let most = MAX_PASSES_PER_SET
            .min(MAX_SET_LIGHTS / self.light_count.max(1))
            .min(MAX_SET_PHOTON_PATHS / self.photon_paths.max(1))
            .min(index);
        let count = most.checked_ilog2().map_or(1, |log| 1 << log);
        let start = index - index % count;
        start..start + count
    }

    /// By how much the tiles of a pass are moved: the points of a tile have one cut, whose error is theirs together, so that borders would remain if they
    /// were the same in all passes.
    fn tile_shift(&self, pass: Pass) -> UVec2 {
        match self.strategy {
            Strategy::All => UVec2::ZERO,
            Strategy::Cuts(_) => {
                let u = pass.spread_2d(Stream::Selection, 4);
                (u * TILE_SIZE as f32).as_uvec2()
            }
        }
    }

    /// How many times the lights of one pass a set for `passes` has.
    pub(super) fn set_size(&self, passes: &Range<u32>) -> u32 {
        passes.len() as u32
    }

    /// Everything that `passes` shade with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        passes: Range<u32>,
        run: &PassContext,
    ) -> PreparedPasses<'s> {
        let count = self.set_size(&passes);
        let finer = self.finer(passes.start);
        let placed_per_summed = self.placed_per_summed(&passes);
        let all = ManyLight {
            light_count: self.light_count * count * placed_per_summed,
            photon_paths: self.photon_paths * count,
            importon_paths: self.importon_paths * count,
            neighbors: (self.neighbors as f32 / finer) as u32,
            ..*self
        };
        let pass = Pass {
            index: passes.start,
            ..run.pass
        };
        let run = PassContext { pass, ..*run };
        let photons = all.trace_photons(scene, limits, &run);
        let (incident, caustics) = run.stats.time("maps", || {
            let caustics = photons.iter().filter(|p| p.event.has(Lobes::SPECULAR));
            (
                IncidentMap::of_environment(scene, &photons),
                KdTree::build_ordered(caustics.copied().collect()),
            )
        });
        let carried = (run.stats).time("maps", || {
            carried::carried(scene, &photons, self.compensation)
        });
        let placed = all.place_lights(scene, limits, &run, photons, finer);
        // Where few photons arrive there are fewer lights than asked for, and they are divided among fewer passes.
        let lights_per_part =
            |parts: &u32| placed.shares.len() <= (self.light_count * parts) as usize;
        let parts = (0..=count.ilog2())
            .map(|log| 1 << log)
            .find(lights_per_part);
        let most = placed.shares.len().div_ceil(self.light_count as usize) as u32;
        let parts = match self.strategy {
            Strategy::All => parts.unwrap_or(most.clamp(count, count * placed_per_summed)),
            Strategy::Cuts(_) => 1,
        };
        let first_part = (pass.sampler(Stream::Selection, 1).next_1d() * parts as f32) as u32;
        let is_used = |k: usize| (k as u32 + parts - first_part) % parts < count;
        let lights = all.make_lights(scene, limits, &run, &placed, is_used);
        // With the compensation, the sum is whole whatever the clamp takes; and a cut is through all lights, of which finer ones are more.
        let finer = match (self.compensation, self.strategy) {
            (Compensation::None, Strategy::All) => finer,
            _ => 1.0,
        };
        let gather = Gather {
            kernel: self.kernel,
            strategy: self.strategy,
            clamp: self
                .clamp
                .for_lights(&lights, parts, finer, self.compensation),
            finer,
        };
        let lights = self.ready(lights, &run);
        let selection = Subset::ALL.part(first_part, parts);
        let carried = run.stats.time("maps", || {
            carried::owned(scene, &gather, &lights, &placed.claims, selection, carried)
        });
        PreparedPasses {
            scene,
            limits,
            gather,
            compensation: self.compensation,
            lights,
            claims: placed.claims,
            caustics,
            carried,
            incident,
            pixel: pixel_width(scene),
            parts,
            first_part,
            passes,
            tolerance: 0.0,
        }
        .with_tolerance(pass)
    }

    fn ready<'s>(&self, lights: VirtualLights<'s>, run: &PassContext) -> LightIndex<'s> {
        let lights = LightIndex::new(lights);
        match self.strategy {
            Strategy::All => lights,
            Strategy::Cuts(_) => run.stats.time("tree", || lights.with_tree()),
        }
    }

    /// How many times finer the lights of a set that starts with pass `first` are: their number, and the inverse of the surface that each
    /// stands for. The squared radius of a pass falls with the square root of its index, so that the mean over `n` passes is off by
    /// less the square root of `n`, as is its noise.
    fn finer(&self, first: u32) -> f32 {
        match self.resampling {
            Resampling::New => 1.0,
            Resampling::Progressive => (1.0 + first as f32 / COARSE_PASSES).sqrt(),
        }
    }

    /// How many lights are placed for each that some pass of the set sums.
    pub(super) fn placed_per_summed(&self, passes: &Range<u32>) -> u32 {
        let summed = u64::from(self.light_count) * u64::from(self.set_size(passes));
        let most = (u64::from(MAX_FINER_LIGHTS) / summed.max(1)).max(1);
        (self.finer(passes.start).round() as u32).min(most as u32)
    }

    pub(super) fn trace_photons(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> Vec<Photon> {
        let stats = run.stats;
        let photons = stats.time("photons", || {
            trace_photons(
                scene,
                limits,
                self.photon_paths,
                run.pass,
                usable_by_virtual_lights,
            )
        });
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        photons
    }

    /// Importance, placement, and whose photons are.
    fn place_lights(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: Vec<Photon>,
        finer: f32,
    ) -> Placed {
        let photons = (run.stats).time("lights", || light_carriers(limits, photons));
        let weights: Vec<f32> = match self.placement {
            Placement::Uniform => fluxes(&photons),
            Placement::Importance | Placement::Relaxed => {
                let importance = self.importance_map(scene, limits, run);
                importance_times_flux(&importance, &photons, run.stats)
            }
        };
        run.stats.time("lights", || {
            let Candidates {
                photons,
                weights,
                u_sites,
                u_residual,
            } = self.candidates(run, photons, weights, finer);
            let chosen = self.choose(&photons, &weights, u_sites);
            let sites = match self.placement {
                Placement::Relaxed => relax(scene, &photons, &chosen),
                Placement::Uniform | Placement::Importance => chosen,
            };
            let neighbors = self.neighbors as usize;
            let (shares, claims) = match (self.flux, self.emission) {
                // What single photons shine needs no others, but the extent of a disc does.
                (FluxRule::Density, EmissionKind::Single) if self.kernel != Kernel::Disc => (
                    PhotonClusters::single_photons(&sites),
                    NearestLights::empty(),
                ),
                (FluxRule::Density, _) => (
                    by_density(scene, &photons, &sites, neighbors),
                    NearestLights::empty(),
                ),
                (FluxRule::Partition, _) => assign(scene, &photons, &sites, &weights, u_residual),
            };
            Placed {
                photons,
                shares,
                claims,
            }
        })
    }

    /// The lights, of which those that `is_used` says shine.
    fn make_lights<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        placed: &Placed,
        is_used: impl Fn(usize) -> bool + Sync,
    ) -> VirtualLights<'s> {
        let Placed {
            photons, shares, ..
        } = placed;
        let stats = run.stats;
        let form = match self.emission {
            EmissionKind::Single => None,
            EmissionKind::Rich(form) => Some(form),
        };
        let lights = stats.time("lights", || {
            VirtualLights::build(scene, limits, photons, shares, form, is_used)
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        Stats::count(&stats.light_bytes, lights.bytes() as u64);
        lights
    }

    /// What importance is estimated from.
    pub(super) fn importance_map(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> KdTree<Importon> {
        let stats = run.stats;
        let importons: Vec<Importon> = stats.time("importons", || {
            trace_importons(scene, limits, self.importon_paths, run.pass)
        });
        Stats::count(&stats.importons, importons.len() as u64);
        stats.time("maps", || KdTree::build_ordered(importons))
    }
}

/// Where lights stand and what they speak for.
struct Placed {
    photons: Vec<Photon>,
    shares: PhotonClusters,
    claims: NearestLights,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_whole_runs_of_passes() {
        let method = ManyLight::rich_vpl();
        let mut pass = 0;
        let mut lengths = Vec::new();
        while pass < 40 {
            let passes = method.passes_with(pass);
            assert_eq!(passes.start, pass, "sets follow each other");
            assert!(passes.clone().all(|p| method.passes_with(p) == passes));
            lengths.push(passes.len());
            pass = passes.end;
        }
        assert_eq!(lengths, [1, 1, 2, 4, 8, 8, 8, 8]);
        let large = ManyLight {
            light_count: 20_000,
            ..method
        };
        assert_eq!(large.passes_with(11), 11..12);
    }
}
