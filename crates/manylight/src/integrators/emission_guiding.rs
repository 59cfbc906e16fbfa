//! The choice of emitters for photons, guided by the importance that their photons reach.
//!
//! Photons of lamps that light nothing in the picture, as those of a closed room next door, are
//! lost, and chosen by power they may be nearly all. A pre-pass emits the same number of photon
//! paths from each of some cells of neighboring emitters. For photons with fluxes `Φ_j` of a cell
//! that reach the importances `Ŵ_j`, the noise of the picture is least where the probability of the
//! cell is in proportion to
//!
//! ```text
//! s = √(n Σ_j (Φ_j Ŵ_j)²)
//! ```
//!
//! over the photons of `n` paths, as for every sum of independent samples. Cells are chosen by a
//! mixture of these probabilities and those by power. Photons are divided by the probability of the
//! mixture, so that no expected value changes.
//!
//! The pre-pass also samples emitters from where gather points look, as directions do. Light of an
//! emitter that directions find and photons hardly carry is reported: [`MissedLight`].
//!
//! The guide depends on the scene, the limits of paths and the method alone: all passes, shards and
//! resumed renders have the same.
//!
//! Sources: Peter and Pietrek, "Importance Driven Construction of Photon Maps", EGWR 1998, for
//! photons guided by importance; Veach 1997, 9.2.2, for defensive mixtures.

use super::direct_light::DirectLight;
use super::method::{Method, MethodKind};
use super::photon_map::Estimate;
use crate::bsdf::Lobes;
use crate::emitters::{EmissionCells, EmissionGuide};
use crate::ids::EmitterId;
use crate::maps::density::{IMPORTANCE_NEIGHBORS, importance_within};
use crate::maps::{KdTree, Neighbors};
use crate::particles::{
    Importon, Photon, trace_gather_importons, trace_importons, trace_photons,
    usable_by_virtual_lights,
};
use crate::sampling::Pass;
use crate::scene::{PathLimits, Scene};
use rayon::prelude::*;

/// Photon paths of the pre-pass, divided among the cells: about 0.1 s of processor time. With half
/// and twice as many, the pixel variance of 128 lights in Disco is 1.00 times as large (16 seeds).
const PHOTON_PATHS: usize = 16_384;
/// Photon paths per cell, at most: more of them tell hardly more about two or three emitters.
const MAX_PATHS_PER_CELL: usize = 2048;
/// Camera paths of the pre-pass: more of them resolve smaller regions. With half and twice as many,
/// the pixel variance in Disco is 1.01 and 1.00 times as large.
const IMPORTON_PATHS: u32 = 8192;
/// Probability of a choice by power in the mixture: a photon has at most `1 / 0.2` = 5 times the
/// flux that it has without a guide, where the pre-pass found no importance.
const UNGUIDED_PROBABILITY: f32 = 0.2;
/// Ratio of the variances without and with the guide below which photons are chosen by power: the
/// gain of a few percent is less than the pre-pass can tell. At 1.6 the guide is not used in Disco
/// and Garage: pixel variance 1.09 and .90 times as large, block variance 1.6 and .7. At 1.05 it is
/// used in Kitchen: .95 and .9 (16 seeds).
const MIN_GAIN: f64 = 1.25;
/// Largest importance that counts, relative to the mean of all photons that reach any: a photon
/// beside the camera must not decide. At 4 the guide is not used in Disco (pixel variance 1.09 times
/// as large); at 16 it is .99 times there, and the same in Kitchen.
const MAX_RELATIVE_IMPORTANCE: f64 = 8.0;
/// Importons that are sampled for the largest bandwidth.
const BANDWIDTH_SAMPLES: usize = 512;
/// Fraction of these bandwidths that are smaller than the largest one: photons farther away have
/// reached no surface that matters.
const BANDWIDTH_QUANTILE: f32 = 0.9;
/// Seed of the pre-pass: no random number of a render decides how it emits.
const SEED: u64 = 0x7068_6f74_6f6e_7321;

/// Photons miss an emitter if they carry less than this fraction of its direct light. The fraction
/// is .54 to 1.15 in eleven scenes where photons find every emitter.
const MISSED: f64 = 0.1;
/// Fraction of all direct light from which on the light of an emitter is missed. Below it, the
/// fraction of an emitter that is found is as low as .54 by the noise of the pre-pass (Garage, .08).
const MIN_SHARE: f64 = 0.1;

/// Direct light of an emitter, where gather points look, that photons hardly carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissedLight {
    /// The emitter.
    pub emitter: EmitterId,
    /// Its part of all direct light there.
    pub share: f64,
    /// The fraction of it that photons carry.
    pub carried: f64,
}

/// A guide for the emission of photons, and what its pre-pass found. The default one is that of
/// methods without photons.
#[derive(Debug, Default)]
pub struct GuidedEmission {
    /// The guide.
    pub guide: EmissionGuide,
    /// Light that photons miss.
    pub missed: Option<MissedLight>,
}

impl Method {
    /// The guide for the emission of photons. It takes a pre-pass to compute, so make it once per
    /// render: [`RenderJob::guide`](crate::render::RenderJob).
    pub fn emission_guide(&self, scene: &Scene) -> EmissionGuide {
        self.guided_emission(scene).guide
    }

    /// [`Method::emission_guide`] with what its pre-pass found.
    pub fn guided_emission(&self, scene: &Scene) -> GuidedEmission {
        if !self.emits_photons() {
            return GuidedEmission::default();
        }
        let guide = scene.infinite_light_guide();
        let counted = match &self.kind {
            // Every photon is connected with the camera.
            MethodKind::LightTracer => CountedPhotons::All,
            MethodKind::PhotonMap(map) if map.estimate == Estimate::Direct => CountedPhotons::All,
            _ => CountedPhotons::Indirect,
        };
        let cells = guide.cells(&scene.emitters);
        if cells.is_empty() {
            let missed = None;
            return GuidedEmission { guide, missed };
        }
        let pre_pass = PrePass::new(scene, self.limits, counted);
        let reached = pre_pass.reached(&guide, &cells);
        let missed = pre_pass.missed(&cells, &reached);
        let guide = match shares(&cells.probabilities(), &scores(&reached)) {
            None => guide,
            Some(shares) => guide.with_shares(&cells, &shares),
        };
        GuidedEmission { guide, missed }
    }
}

/// Photons at gather points that contribute to the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CountedPhotons {
    /// Those with a specular last event. Virtual lights, or photons that come from another surface,
    /// stand for the others: they count where gather points see them.
    Indirect,
    All,
}

/// The probabilities of the cells of the mixture; `None` where they gain little against
/// `unguided`.
fn shares(unguided: &[f32], scores: &[f64]) -> Option<Vec<f32>> {
    let total: f64 = scores.iter().sum();
    if !(total.is_finite() && total > 0.0) {
        return None;
    }
    let mixed = |(&unguided, &score): (&f32, &f64)| {
        let guided = (score / total) as f32;
        guided + UNGUIDED_PROBABILITY * (unguided - guided)
    };
    let shares: Vec<f32> = unguided.iter().zip(scores).map(mixed).collect();
    let variance = |shares: &[f32]| -> f64 {
        let of_cell = |(&score, &share): (&f64, &f32)| score * score / f64::from(share);
        scores.iter().zip(shares).map(of_cell).sum()
    };
    (variance(unguided) > MIN_GAIN * variance(&shares)).then_some(shares)
}

/// Importons, and what photons at them count for.
struct PrePass<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    counted: CountedPhotons,
    /// Where virtual lights are seen from gather points.
    seen: ImportanceMap,
    gather_points: ImportanceMap,
}

impl<'s> PrePass<'s> {
    fn new(scene: &'s Scene, limits: PathLimits, counted: CountedPhotons) -> Self {
        let pass = Pass {
            seed: SEED,
            index: 0,
        };
        let at_gather_points = trace_gather_importons(scene, limits, IMPORTON_PATHS, pass);
        PrePass {
            scene,
            limits,
            counted,
            seen: ImportanceMap::new(trace_importons(scene, limits, IMPORTON_PATHS, pass)),
            gather_points: ImportanceMap::new(at_gather_points),
        }
    }

    /// The photons of each cell.
    fn reached(&self, guide: &EmissionGuide, cells: &EmissionCells) -> Vec<Vec<Reached>> {
        let paths = (PHOTON_PATHS / cells.len()).clamp(1, MAX_PATHS_PER_CELL);
        (0..cells.len())
            .into_par_iter()
            .map(|cell| self.reached_from(guide, cells, cell, paths as u32))
            .collect()
    }

    /// The emitter with the most direct light that photons miss, if there is any.
    fn missed(&self, cells: &EmissionCells, reached: &[Vec<Reached>]) -> Option<MissedLight> {
        let direct = DirectLight::around(self.scene, cells, self.seen.importons.items(), SEED);
        let total = direct.total();
        let carried = |cell: usize| -> f64 {
            let photons = reached[cell].iter().filter(|r| r.is_direct);
            photons.map(|r| r.flux * r.importance).sum()
        };
        let misses = direct.of_surfaces().filter_map(|(cell, found)| {
            let fraction = carried(cell) / found;
            let is_missed = found > MIN_SHARE * total && fraction < MISSED;
            is_missed.then(|| MissedLight {
                emitter: cells.emitter(cell),
                share: found / total,
                carried: fraction,
            })
        });
        misses.max_by(|a, b| a.share.total_cmp(&b.share))
    }

    /// Photons of `paths` paths from one cell.
    fn reached_from(
        &self,
        guide: &EmissionGuide,
        cells: &EmissionCells,
        cell: usize,
        paths: u32,
    ) -> Vec<Reached> {
        let Some(guide) = guide.of_cell(cells, cell) else {
            return Vec::new();
        };
        let pass = Pass {
            seed: SEED,
            index: cell as u32,
        };
        let useful = usable_by_virtual_lights;
        let photons = trace_photons(self.scene, &guide, self.limits, paths, pass, useful);
        let mut found = Neighbors::new(IMPORTANCE_NEIGHBORS);
        let reached = |photon: &Photon| Reached {
            flux: f64::from(photon.flux.selection_weight()),
            importance: f64::from(self.importance(photon, &mut found)),
            is_direct: photon.event == Lobes::NONE,
        };
        photons.iter().map(reached).collect()
    }

    /// Importance at a photon, in 1/m².
    fn importance(&self, photon: &Photon, found: &mut Neighbors) -> f32 {
        let is_counted = self.counted == CountedPhotons::All || photon.event.has(Lobes::SPECULAR);
        let at_gather_point = match is_counted {
            true => self.gather_points.at(photon, found),
            false => 0.0,
        };
        at_gather_point + self.seen.at(photon, found)
    }
}

/// A photon of the pre-pass.
struct Reached {
    /// In W.
    flux: f64,
    /// In 1/m².
    importance: f64,
    /// It came straight from the emitter.
    is_direct: bool,
}

/// The score of each cell, by its photons.
fn scores(reached: &[Vec<Reached>]) -> Vec<f64> {
    let all = || reached.iter().flatten().filter(|r| r.importance > 0.0);
    let flux: f64 = all().map(|r| r.flux).sum();
    let mean = all().map(|r| r.flux * r.importance).sum::<f64>() / flux;
    let most = MAX_RELATIVE_IMPORTANCE * mean;
    let score = |cell: &Vec<Reached>| {
        let squares = cell
            .iter()
            .map(|r| (r.flux * r.importance.min(most)).powi(2));
        squares.sum::<f64>().sqrt()
    };
    reached.iter().map(score).collect()
}

/// Importons with the largest bandwidth of their density estimates.
struct ImportanceMap {
    importons: KdTree<Importon>,
    /// In m.
    max_radius: f32,
}

impl ImportanceMap {
    fn new(importons: Vec<Importon>) -> Self {
        let importons = KdTree::build_ordered(importons);
        let step = importons.len().div_ceil(BANDWIDTH_SAMPLES).max(1);
        let mut found = Neighbors::new(IMPORTANCE_NEIGHBORS);
        let mut radii: Vec<f32> = (importons.items().iter().step_by(step))
            .map(|importon| {
                importons.nearest(importon.p, f32::INFINITY, &mut found);
                found.radius_squared()
            })
            .collect();
        radii.sort_unstable_by(f32::total_cmp);
        let largest = radii.get((radii.len() as f32 * BANDWIDTH_QUANTILE) as usize);
        let max_radius = largest.map_or(0.0, |r2| r2.sqrt());
        ImportanceMap {
            importons,
            max_radius,
        }
    }

    /// Importance at a photon, in 1/m².
    fn at(&self, photon: &Photon, found: &mut Neighbors) -> f32 {
        importance_within(
            &self.importons,
            (photon.p, photon.n),
            self.max_radius,
            found,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_importance_keep_the_unguided_part() {
        let unguided = [0.9, 0.1];
        let shares = shares(&unguided, &[0.0, 1.0]).unwrap();
        assert!((shares[0] - 0.18).abs() < 1e-6 && (shares[1] - 0.82).abs() < 1e-6);
        assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_changes_without_importance_or_with_little_gain() {
        assert!(shares(&[0.5, 0.5], &[0.0, 0.0]).is_none());
        assert!(shares(&[0.5, 0.5], &[1.0, 1.2]).is_none());
        assert!(shares(&[0.6, 0.4], &[1.0, 0.7]).is_none());
    }
}
