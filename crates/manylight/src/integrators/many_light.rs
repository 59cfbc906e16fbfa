//! The method: light from virtual lights.
//!
//! Lights are made in the paper's order: particles, maps, placement, creation ([`ManyLight::prepare`]); then every pixel is shaded
//! by them (`light_set.rs`). Which path belongs to which term is said in [`super::partition`].

pub use super::light_set::Complement;
use super::light_set::{LightSet, pixel_width};
use super::{PassContext, carried};
use crate::bsdf::Lobes;
use crate::film::Film;
use crate::gather::{Clamp, Gather, Lights};
pub use crate::gather::{CutLimits, Kernel, Strategy};
use crate::maps::density::{IMPORTANCE_NEIGHBORS, importance_at};
use crate::maps::{IncidentMap, KdTree, Neighbors};
use crate::particles::{Importon, Photon, for_lights, trace_importons, trace_photons};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::virtual_lights::curve::Curve;
use crate::virtual_lights::neighborhood::{by_area, by_density};
pub use crate::virtual_lights::relax::Snap;
use crate::virtual_lights::relax::relax;
use crate::virtual_lights::select::defensive_weights;
use crate::virtual_lights::{Claims, Division, LightField, Shares, Site, assign, select};
pub use crate::virtual_lights::{GlossyForm, TableStorage};
use rayon::prelude::*;
use std::ops::Range;

/// Where lights stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Photons kept with probability proportional to flux.
    Uniform,
    /// Proportional to importance x flux.
    Importance,
    /// As [`Placement::Importance`], and then pushed apart.
    Relaxed(Snap),
}

/// How much flux each light carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Its own photon's over the probability of having been kept: the paper's, as we read it.
    Density,
    /// The density of flux around it, times the surface per light.
    Area,
    /// That of all photons nearer to it than to any other light.
    Partition,
    /// That of all photons around it, each divided among the nearest lights.
    SoftPartition,
}

/// What each light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all its photons: diffuse part exact, glossy part in this form.
    Rich(GlossyForm),
}

/// What is done about the singularity of `1 / d²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampRule {
    /// Nothing.
    None,
    /// Scale-free, by what each light stands for: [`Clamp::Auto`].
    Auto,
    /// `G <= 1 / A` with one `A` for all lights: the median of what they stand for.
    Fixed,
    /// `G <= value`, in 1/m².
    Value(f32),
}

impl ClampRule {
    /// The clamp for `lights`, one in `parts` of which is summed, when they have become so many times finer.
    fn for_lights(
        self,
        lights: &LightField,
        parts: u32,
        finer: f32,
        complement: Complement,
    ) -> Clamp {
        match self {
            ClampRule::None => Clamp::None,
            ClampRule::Auto => Clamp::Auto(match complement {
                Complement::None | Complement::Photons => 1.0,
                Complement::KolligKeller => COMPLETED,
            }),
            ClampRule::Fixed => {
                let area = lights.median_area() * parts as f32;
                Clamp::Value(finer / area.max(f32::MIN_POSITIVE))
            }
            ClampRule::Value(limit) => Clamp::Value(limit * finer),
        }
    }
}

/// Which lights the passes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renewal {
    /// All have those of the first: what one set of lights gives, without the noise of pixels.
    Same,
    /// Each has its own, as fine as the first.
    New,
    /// Each has its own, and they become finer, so that the mean over passes goes to the right picture.
    Finer,
}

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
    /// Photons around a light that say what it shines, under [`FluxRule::Density`] and [`FluxRule::Area`].
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
    pub complement: Complement,
    /// Which lights the passes have.
    pub renewal: Renewal,
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
/// Lights count as so many times larger for the clamp if directions complete it: they bring what near lights send with less noise.
const COMPLETED: f32 = 4.0;
/// Lights per pass where a cut makes them cheap.
const MANY: u32 = 16_384;
/// Lights that become finer are as fine as at the start for so many passes.
const COARSE_PASSES: f32 = 16.0;
/// A set has no more lights than this just to make them finer.
const MAX_FINER_LIGHTS: u32 = 1 << 18;

impl ManyLight {
    /// Rich-VPLs: importance placement, partition, 32 x 32 tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 512,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            neighbors: 100,
            emission: EmissionKind::Rich(GlossyForm::Table {
                side: 32,
                storage: TableStorage::Shared,
            }),
            kernel: Kernel::Disc,
            strategy: Strategy::All,
            clamp: ClampRule::Auto,
            complement: Complement::KolligKeller,
            renewal: Renewal::Finer,
        }
    }

    /// The method of the talk, as we read it: importance placement, the density rule, 32 x 32 tables, points, one clamp for all.
    pub fn rich_vpl_paper() -> Self {
        ManyLight {
            flux: FluxRule::Density,
            kernel: Kernel::Point,
            clamp: ClampRule::Fixed,
            complement: Complement::None,
            renewal: Renewal::New,
            ..ManyLight::rich_vpl()
        }
    }

    /// Rich-VSLs: Rich-VPLs as spheres.
    pub fn rich_vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            complement: Complement::None,
            ..ManyLight::rich_vpl()
        }
    }

    /// Virtual spherical lights. Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of Glossy
    /// Scenes", 2009.
    pub fn vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            complement: Complement::None,
            renewal: Renewal::Finer,
            ..ManyLight::vpl()
        }
    }

    /// Classic VPLs: photons thinned at random.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            renewal: Renewal::New,
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

    /// Lightcuts of classic lights. Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005.
    pub fn lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: MANY,
            photon_paths: 64 * MANY,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of Rich-VPLs.
    pub fn rich_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: MANY,
            photon_paths: 64 * MANY,
            ..ManyLight::rich_vpl()
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
    /// become too large. A cut is through all lights: then each has its own.
    ///
    /// A set for many passes is better than a set for each: lights that stand for fewer photons each are more alike, so that
    /// every eighth of 4096 lights is a better choice than eight times 512.
    pub(super) fn passes_with(&self, index: u32) -> Range<u32> {
        if self.renewal == Renewal::Same {
            return 0..u32::MAX;
        }
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

    /// How many times the lights of one pass a set for `passes` has.
    pub(super) fn set_size(&self, passes: &Range<u32>) -> u32 {
        match self.renewal {
            Renewal::Same => 1,
            Renewal::New | Renewal::Finer => passes.len() as u32,
        }
    }

    /// Everything that `passes` shade with.
    pub fn prepare<'s>(
        &self,
        scene: &'s Scene,
        limits: PathLimits,
        passes: Range<u32>,
        run: &PassContext,
    ) -> LightSet<'s> {
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
                IncidentMap::from_afar(scene, &photons),
                KdTree::build_ordered(caustics.copied().collect()),
            )
        });
        let carried = match self.complement {
            Complement::Photons => run.stats.time("maps", || carried::carried(scene, &photons)),
            Complement::None | Complement::KolligKeller => Vec::new(),
        };
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
        // With the complement, the sum is whole whatever the clamp takes; and a cut is through all lights, of which finer ones are more.
        let finer = match (self.complement, self.strategy) {
            (Complement::None, Strategy::All) => finer,
            _ => 1.0,
        };
        let carried = run
            .stats
            .time("maps", || carried::owned(scene, &placed.claims, carried));
        let gather = Gather {
            kernel: self.kernel,
            strategy: self.strategy,
            clamp: self
                .clamp
                .for_lights(&lights, parts, finer, self.complement),
            finer,
        };
        LightSet {
            scene,
            limits,
            gather,
            complement: self.complement,
            lights: self.ready(lights, &run),
            claims: placed.claims,
            caustics,
            carried,
            incident,
            pixel: pixel_width(scene),
            parts,
            first_part,
            passes,
        }
    }

    fn ready<'s>(&self, lights: LightField<'s>, run: &PassContext) -> Lights<'s> {
        let lights = Lights::new(lights);
        match self.strategy {
            Strategy::All => lights,
            Strategy::Cuts(_) => {
                let key = run.pass.sampler(Stream::Selection, 2).next_1d();
                (run.stats).time("tree", || lights.with_tree(u64::from(key.to_bits())))
            }
        }
    }

    /// How many times finer the lights of a set that starts with pass `first` are: their number, and the inverse of the surface that each
    /// stands for. The squared radius of a pass falls with the square root of its index, so that the mean over `n` passes is off by
    /// less the square root of `n`, as is its noise.
    fn finer(&self, first: u32) -> f32 {
        match self.renewal {
            Renewal::Same | Renewal::New => 1.0,
            Renewal::Finer => (1.0 + first as f32 / COARSE_PASSES).sqrt(),
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
            trace_photons(scene, limits, self.photon_paths, run.pass, for_lights)
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
        let photons = light_carriers(limits, photons);
        let weights: Vec<f32> = match self.placement {
            Placement::Uniform => fluxes(&photons),
            Placement::Importance | Placement::Relaxed(_) => {
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
                Placement::Relaxed(snap) => relax(scene, &photons, &chosen, snap),
                Placement::Uniform | Placement::Importance => chosen,
            };
            let assigned =
                |division| assign(scene, &photons, &sites, &weights, division, u_residual);
            let neighbors = self.neighbors as usize;
            let (shares, claims) = match (self.flux, self.emission) {
                // What single photons shine needs no others, but the extent of a disc does.
                (FluxRule::Density, EmissionKind::Single) if self.kernel != Kernel::Disc => {
                    (Shares::own(&sites), Claims::none())
                }
                (FluxRule::Density, _) => (
                    by_density(scene, &photons, &sites, neighbors),
                    Claims::none(),
                ),
                (FluxRule::Area, _) => {
                    (by_area(scene, &photons, &sites, neighbors), Claims::none())
                }
                (FluxRule::Partition, _) => assigned(Division::Nearest),
                (FluxRule::SoftPartition, _) => assigned(Division::Soft),
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
    ) -> LightField<'s> {
        let Placed {
            photons, shares, ..
        } = placed;
        let stats = run.stats;
        let form = match self.emission {
            EmissionKind::Single => None,
            EmissionKind::Rich(form) => Some(form),
        };
        let lights = stats.time("lights", || {
            LightField::build(scene, limits, photons, shares, form, is_used)
        });
        Stats::count(&stats.lights, lights.lights().len() as u64);
        Stats::count(&stats.light_bytes, lights.bytes() as u64);
        lights
    }

    /// The photons that placement chooses from.
    pub(super) fn candidates(
        &self,
        run: &PassContext,
        photons: Vec<Photon>,
        weights: Vec<f32>,
        finer: f32,
    ) -> Candidates {
        let mut sampler = run.pass.sampler(Stream::Selection, 0);
        let (u_thinned, u_sites, u_residual) =
            (sampler.next_1d(), sampler.next_1d(), sampler.next_1d());
        let thin = matches!(self.flux, FluxRule::Partition | FluxRule::SoftPartition);
        let (photons, weights) = if thin {
            // Ever fewer, until every photon is a light.
            let per_light = (PHOTONS_PER_LIGHT as f32 / (finer * finer)).max(1.0);
            let most = (per_light * self.light_count as f32) as usize;
            thinned(photons, weights, most, u_thinned)
        } else {
            (photons, weights)
        };
        Candidates {
            photons,
            weights,
            u_sites,
            u_residual,
        }
    }

    /// Chooses photons to become lights; where they are to be relaxed, that comes next.
    pub(super) fn choose(&self, photons: &[Photon], weights: &[f32], u: f32) -> Vec<Site> {
        let count = self.light_count as usize;
        match self.placement {
            Placement::Uniform => select(photons, weights, count, u),
            Placement::Importance | Placement::Relaxed(_) => {
                let mixed = defensive_weights(weights, &fluxes(photons), PLACED_BY_FLUX);
                select(photons, &mixed, count, u)
            }
        }
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

/// The photons that may become lights: a light at depth m makes paths of at least m + 2 segments.
pub(super) fn light_carriers(limits: PathLimits, photons: Vec<Photon>) -> Vec<Photon> {
    let carries = |p: &Photon| limits.allow(u32::from(p.depth) + 2);
    photons.into_iter().filter(carries).collect()
}

/// What the paper's placement goes by: how much of each photon reaches the camera, if importance did not depend on direction.
pub(super) fn importance_times_flux(
    importance: &KdTree<Importon>,
    photons: &[Photon],
    stats: &Stats,
) -> Vec<f32> {
    stats.time("importance", || {
        // Along the curve, each search finds the nodes of the last one in the cache.
        let order = Curve::around(photons).order(photons);
        let ask = |found: &mut Neighbors, &j: &u32| {
            let photon = &photons[j as usize];
            importance_at(importance, photon.p, photon.n, found) * photon.flux.luminance()
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

/// Photons that may become lights, with what placement goes by and its random numbers.
pub(super) struct Candidates {
    pub(super) photons: Vec<Photon>,
    pub(super) weights: Vec<f32>,
    pub(super) u_sites: f32,
    u_residual: f32,
}

/// Where lights stand and what they speak for.
struct Placed {
    photons: Vec<Photon>,
    shares: Shares,
    claims: Claims,
}

pub(super) fn fluxes(photons: &[Photon]) -> Vec<f32> {
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
        let same = ManyLight {
            renewal: Renewal::Same,
            ..method
        };
        assert_eq!(same.passes_with(11), same.passes_with(0));
        assert_eq!(same.set_size(&same.passes_with(0)), 1);
    }
}
