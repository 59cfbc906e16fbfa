//! The method: light from virtual lights.
//!
//! Lights are made in the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]); then every pixel is shaded
//! by them (`light_set.rs`). Which path belongs to which term is said in [`super::partition`].

use super::PassContext;
pub use super::light_set::Complement;
use super::light_set::{LightSet, pixel_width};
use crate::bsdf::Lobes;
use crate::film::Film;
pub use crate::gather::{Clamp, Kernel};
use crate::gather::{Gather, Lights};
use crate::maps::density::{IMPORTANCE_NEIGHBORS, importance_at};
use crate::maps::{IncidentMap, KdTree, Neighbors};
use crate::particles::{Importon, Photon, for_lights, trace_importons, trace_photons};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::virtual_lights::curve::Curve;
use crate::virtual_lights::select::defensive_weights;
use crate::virtual_lights::{Claims, LightField, Shares, Site, assign, select};
use rayon::prelude::*;
use std::ops::Range;

/// Where lights stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Photons kept with probability proportional to flux.
    Uniform,
    /// Proportional to importance x flux.
    Importance,
}

/// How much flux each light carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Its own photon's over the probability of having been kept.
    Density,
    /// That of all photons nearer to it than to any other light.
    Partition,
}

/// What each light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all its photons: diffuse part exact, glossy part in an octahedral table of this side.
    Table {
        /// Texels along an edge.
        side: u32,
    },
}

/// Indirect light from virtual lights. Each pass has its own lights and its own jitter.
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
    /// What each shines.
    pub emission: EmissionKind,
    /// How one is evaluated.
    pub kernel: Kernel,
    /// What is done about the singularity.
    pub clamp: Clamp,
    /// How the light that the clamp takes away is given back.
    pub complement: Complement,
}

/// More photons than this on average do not make lights better: theirs is the least of all noise.
const PHOTONS_PER_LIGHT: usize = 1024;
/// Which ones stay is said by their weight, and to this share by their flux alone.
const KEPT_BY_FLUX: f32 = 0.25;
/// Lights are placed by importance x flux, and by this much as often by flux alone: where importons have missed what matters, the
/// photons must not all belong to a few lights far off.
const PLACED_BY_FLUX: f32 = 0.1;
/// Passes that share one set of lights, at most; each shades by its own part of them.
const MAX_PASSES_PER_SET: u32 = 8;
/// No set for more than one pass has more lights than this,
const MAX_SET_LIGHTS: u32 = 32_768;
/// or is made of more photon paths.
const MAX_SET_PHOTON_PATHS: u32 = 1 << 22;

impl ManyLight {
    /// Rich-VPLs: importance placement, partition, 32 x 32 tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 512,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            emission: EmissionKind::Table { side: 32 },
            kernel: Kernel::Disc,
            clamp: Clamp::Auto,
            complement: Complement::KolligKeller,
        }
    }

    /// Classic VPLs: photons thinned at random.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            ..ManyLight::rich_vpl()
        }
    }

    /// VPLs placed by importance.
    pub fn vpl_importance() -> Self {
        ManyLight {
            placement: Placement::Importance,
            ..ManyLight::vpl()
        }
    }

    /// One sample per pixel under the lights of one pass, which are part of the set that is `kept` from pass to pass.
    /// `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        kept: &mut Option<LightSet<'s>>,
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
        run.shade(film, |samples| set.shade_tile(run, &positions, samples))
    }

    /// The passes that share the lights of pass `index`: one, then one, 2, 4, and 8 from there on, or fewer if the set would
    /// become too large.
    ///
    /// A set for many passes is better than a set for each: lights that stand for fewer photons each are more alike, so that
    /// every eighth of 4096 lights is a better choice than eight times 512.
    fn passes_with(&self, index: u32) -> Range<u32> {
        let most = MAX_PASSES_PER_SET
            .min(MAX_SET_LIGHTS / self.light_count.max(1))
            .min(MAX_SET_PHOTON_PATHS / self.photon_paths.max(1))
            .min(index);
        let count = most.checked_ilog2().map_or(1, |log| 1 << log);
        let start = index - index % count;
        start..start + count
    }

    /// The most passes that share lights, up to pass `last`.
    pub(super) fn largest_set(&self, last: u32) -> u32 {
        let passes = self.passes_with(last);
        passes.end - passes.start
    }

    /// Everything that `passes` shade with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        passes: Range<u32>,
        run: &PassContext,
    ) -> LightSet<'s> {
        let count = passes.len() as u32;
        let all = ManyLight {
            light_count: self.light_count * count,
            photon_paths: self.photon_paths * count,
            importon_paths: self.importon_paths * count,
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
                IncidentMap::from_afar(scene, &photons),
                KdTree::build_ordered(caustics.copied().collect()),
            )
        });
        let (lights, claims) = all.make_lights(scene, limits, &run, photons);
        // Where few photons arrive there are fewer lights than asked for, and they are divided among fewer passes.
        let parts = (0..=count.ilog2())
            .map(|log| 1 << log)
            .find(|parts| lights.field.lights().len() <= (self.light_count * parts) as usize)
            .unwrap_or(count);
        LightSet {
            scene,
            limits,
            gather: Gather {
                kernel: self.kernel,
                clamp: self.clamp,
            },
            complement: self.complement,
            lights,
            claims,
            caustics,
            incident,
            pixel: pixel_width(scene),
            parts,
            first_part: (pass.sampler(Stream::Selection, 1).next_1d() * parts as f32) as u32,
            passes,
        }
    }

    fn trace_photons(&self, scene: &Scene, limits: PathLimits, run: &PassContext) -> Vec<Photon> {
        let stats = run.stats;
        let photons = stats.time("photons", || {
            trace_photons(scene, limits, self.photon_paths, run.pass, for_lights)
        });
        Stats::count(&stats.photon_paths, u64::from(self.photon_paths));
        Stats::count(&stats.photons, photons.len() as u64);
        photons
    }

    /// Importance, placement, lights; and whose photons are.
    fn make_lights<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: Vec<Photon>,
    ) -> (Lights<'s>, Claims) {
        let (pass, stats) = (run.pass, run.stats);
        let mut sampler = pass.sampler(Stream::Selection, 0);
        // A light at depth m makes paths of at least m + 2 segments.
        let photons: Vec<Photon> = photons
            .into_iter()
            .filter(|p| limits.allow(u32::from(p.depth) + 2))
            .collect();
        let weights: Vec<f32> = match self.placement {
            Placement::Uniform => photons.iter().map(|p| p.flux.luminance()).collect(),
            Placement::Importance => self.importance_times_flux(scene, limits, run, &photons),
        };
        let (lights, claims) = stats.time("lights", || {
            let count = self.light_count as usize;
            let most = PHOTONS_PER_LIGHT.saturating_mul(count);
            let (photons, weights) = thinned(photons, weights, most, sampler.next_1d());
            let sites = self.sites(&photons, &weights, count, sampler.next_1d());
            let (shares, claims) = match self.flux {
                FluxRule::Density => (Shares::own(&sites), Claims::none()),
                FluxRule::Partition => assign(scene, &photons, &sites, &weights, sampler.next_1d()),
            };
            let lights = match self.emission {
                EmissionKind::Single => LightField::single(scene, limits, &photons, &shares),
                EmissionKind::Table { side } => {
                    LightField::rich(scene, limits, &photons, &shares, side as usize)
                }
            };
            (lights, claims)
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        Stats::count(&stats.light_bytes, lights.bytes() as u64);
        (Lights::new(lights), claims)
    }

    /// Chooses `count` photons to become lights.
    fn sites(&self, photons: &[Photon], weights: &[f32], count: usize, u: f32) -> Vec<Site> {
        match self.placement {
            Placement::Uniform => select(photons, weights, count, u),
            Placement::Importance => {
                let mixed = defensive_weights(weights, &fluxes(photons), PLACED_BY_FLUX);
                select(photons, &mixed, count, u)
            }
        }
    }

    /// What the paper's placement goes by: how much of each photon reaches the camera, if importance did not depend on direction.
    fn importance_times_flux(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        photons: &[Photon],
    ) -> Vec<f32> {
        let stats = run.stats;
        let importons: Vec<Importon> = stats.time("importons", || {
            trace_importons(scene, limits, self.importon_paths, run.pass)
        });
        Stats::count(&stats.importons, importons.len() as u64);
        let map = stats.time("maps", || KdTree::build_ordered(importons));
        stats.time("importance", || {
            // Along the curve, each search finds the nodes of the last one in the cache.
            let order = Curve::around(photons).order(photons);
            let ask = |found: &mut Neighbors, &j: &u32| {
                let photon = &photons[j as usize];
                importance_at(&map, photon.p, photon.n, found) * photon.flux.luminance()
            };
            let along_curve: Vec<f32> = order
                .par_iter()
                .with_min_len(256)
                .map_init(|| Neighbors::new(IMPORTANCE_NEIGHBORS), ask)
                .collect();
            let mut weights = vec![0.0; photons.len()];
            for (j, weight) in order.into_iter().zip(along_curve) {
                weights[j as usize] = weight;
            }
            weights
        })
    }
}

fn fluxes(photons: &[Photon]) -> Vec<f32> {
    photons.iter().map(|p| p.flux.luminance()).collect()
}

/// About `most` of the photons, or all, by their weights; each stands for as many as its probability says. Returns the weights too.
fn thinned(
    photons: Vec<Photon>,
    weights: Vec<f32>,
    most: usize,
    u: f32,
) -> (Vec<Photon>, Vec<f32>) {
    if photons.len() <= most {
        return (photons, weights);
    }
    let mixed = defensive_weights(&weights, &fluxes(&photons), KEPT_BY_FLUX);
    let probabilities = inclusion_probabilities(&mixed, most, 0.0);
    let kept = systematic(&probabilities, u).into_iter().map(|j| {
        let (photon, stands_for) = (photons[j], 1.0 / probabilities[j]);
        let kept = Photon {
            flux: photon.flux * stands_for,
            diffuse_flux: photon.diffuse_flux * stands_for,
            ..photon
        };
        (kept, weights[j] * stands_for)
    });
    kept.unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::virtual_lights::testing::photons_on_square;

    #[test]
    fn thinning_keeps_flux_and_weight_on_average() {
        let photons = photons_on_square(1000, 1);
        let flux = |photons: &[Photon]| photons.iter().map(|p| f64::from(p.flux.g)).sum::<f64>();
        let sum = |weights: &[f32]| weights.iter().map(|&w| f64::from(w)).sum::<f64>();
        // Of half of the photons the camera sees nothing.
        let weights: Vec<f32> = photons
            .iter()
            .map(|p| p.flux.luminance() * (p.p.x - 0.5).max(0.0))
            .collect();
        let (mut mean_flux, mut mean_weight, trials) = (0.0, 0.0, 64);
        for t in 0..trials {
            let u = (t as f32 + 0.5) / trials as f32;
            let (kept, its_weights) = thinned(photons.clone(), weights.clone(), 300, u);
            assert!(kept.len().abs_diff(300) <= 1 && kept.len() == its_weights.len());
            let seen = kept.iter().filter(|p| p.p.x > 0.5).count();
            assert!(seen > 200, "{seen} of {} are seen", kept.len());
            mean_flux += flux(&kept) / f64::from(trials);
            mean_weight += sum(&its_weights) / f64::from(trials);
        }
        let (total, weight) = (flux(&photons), sum(&weights));
        assert!(
            (mean_flux / total - 1.0).abs() < 0.01,
            "{mean_flux} of {total}"
        );
        assert!(
            (mean_weight / weight - 1.0).abs() < 0.01,
            "{mean_weight} of {weight}"
        );
        assert_eq!(thinned(photons, weights, 1000, 0.9).0.len(), 1000);
    }

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
