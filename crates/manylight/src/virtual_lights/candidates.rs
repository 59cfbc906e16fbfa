//! The photons that may become virtual lights, with the weights that placement follows.

use super::curve::Curve;
use super::select::defensive_weights;
use crate::maps::KdTree;
use crate::maps::density::NearbyImportance;
use crate::particles::{Importon, Photon};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::scene::PathLimits;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Probability of including a photon that follows its flux alone, relative to that which follows
/// its weight. Bounds the flux of included photons where importance is underestimated. Measured
/// against flux alone: on veach-ajar, the spread of the mean over seeds falls from 0.45 to 0.2 % at
/// 16 passes.
const INCLUDED_BY_FLUX: f32 = 0.25;
/// Part of the lights that is divided evenly among light groups, whatever the importance of their
/// light. At 0.03 and 0.3 (128 lights at 96x54, 10 seeds; Kitchen, Glossy Room, Disco): variance of
/// the groups in the geometric mean 1.04, .93, 1.04 and .98, .92, .99 times as large, of the beauty
/// 1.01, .95, 1.00 and .96, .94, 1.03.
const EVENLY: f32 = 0.125;
/// Consecutive photons that share importance estimates. Fixed, so that results do not depend on the
/// number of threads.
const PHOTONS_PER_RUN: usize = 1024;

/// Photons that may become virtual lights.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// In the order of a curve around them, unless they were given in another order.
    pub photons: Vec<Photon>,
    /// Weight of each photon: luminance of the flux in W, or importance times that in W/m².
    pub weights: Vec<f32>,
    /// The space-filling curve around the photons.
    pub(super) curve: Curve,
}

impl Candidates {
    /// Photons in this order, with their weights.
    pub fn new(photons: Vec<Photon>, weights: Vec<f32>) -> Self {
        assert_eq!(photons.len(), weights.len(), "one weight per photon");
        Candidates {
            curve: Curve::around(&photons),
            photons,
            weights,
        }
    }

    /// The photons at which a virtual light makes a path within `limits`, by flux, in the order of
    /// the curve. A light at photon depth m makes paths of at least m + 2 segments.
    pub(crate) fn by_flux(limits: PathLimits, mut photons: Vec<Photon>) -> Self {
        photons.retain(|p| limits.allow(u32::from(p.depth) + 2));
        let curve = Curve::around(&photons);
        let photons = curve.sorted(&photons);
        Candidates {
            weights: luminances(&photons),
            photons,
            curve,
        }
    }

    /// The same photons by importance times flux: the weights of the paper's placement. Importance
    /// counts as independent of direction.
    pub(crate) fn by_importance(self, importons: &KdTree<Importon>) -> Self {
        // Photons that are neighbors on the curve are neighbors in space.
        let runs = self.photons.par_chunks(PHOTONS_PER_RUN);
        let weights = runs.flat_map_iter(|run| {
            let mut estimates = NearbyImportance::new(importons);
            run.iter()
                .map(move |photon| estimates.at(photon.p, photon.n) * photon.flux.luminance())
        });
        Candidates {
            weights: weights.collect(),
            ..self
        }
    }

    /// The weights mixed with flux: see [`defensive_weights`].
    pub(crate) fn defensive_weights(&self, by_flux: f32) -> Vec<f32> {
        defensive_weights(&self.weights, &luminances(&self.photons), by_flux)
    }

    /// `weights` of selection, changed so that a part of the lights is divided evenly among the light
    /// groups: a group that is dim in this picture has lights too, for pictures in which it is
    /// brighter.
    pub(crate) fn with_lights_for_all_groups(&self, weights: Vec<f32>) -> Vec<f32> {
        let groups = self.groups();
        if groups.len() < 2 {
            return weights;
        }
        let total = |weights: &[f32]| weights.iter().map(|&w| f64::from(w)).sum::<f64>();
        let all = total(&weights);
        let mut shared = weights;
        for group in &groups {
            let of_group = &mut shared[group.clone()];
            let share = total(of_group) / all;
            if share > 0.0 {
                let even = f64::from(EVENLY) / (groups.len() as f64 * share);
                let factor = (1.0 - EVENLY) + even as f32;
                of_group.iter_mut().for_each(|weight| *weight *= factor);
            }
        }
        shared
    }

    /// The photons of each light group that has any, if they are in the order of the curve.
    pub(super) fn groups(&self) -> Vec<Range<usize>> {
        let mut start = 0;
        let runs = self.photons.chunk_by(|a, b| a.group == b.group);
        let ranges = runs.map(|run| {
            start += run.len();
            start - run.len()..start
        });
        ranges.collect()
    }

    /// Some of the photons, as candidates.
    pub(super) fn part(&self, photons: Range<usize>) -> Cow<'_, Self> {
        if photons.len() == self.photons.len() {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Candidates {
            weights: self.weights[photons.clone()].to_vec(),
            photons: self.photons[photons].to_vec(),
            curve: self.curve,
        })
    }

    /// Probabilities that include about `most` of the photons, all if there are fewer.
    pub(crate) fn inclusion_probabilities(&self, most: usize) -> Vec<f32> {
        if self.photons.len() <= most {
            return vec![1.0; self.photons.len()];
        }
        inclusion_probabilities(&self.defensive_weights(INCLUDED_BY_FLUX), most, 0.0)
    }

    /// About `most` of the photons, or all if there are fewer, with probability by weight. Flux and
    /// weight of a photon are divided by its probability. `u` in [0, 1) is the one random number.
    pub(crate) fn thinned(self, most: usize, u: f32) -> Self {
        if self.photons.len() <= most {
            return self;
        }
        let probabilities = self.inclusion_probabilities(most);
        let thinned = systematic(&probabilities, u).into_par_iter().map(|j| {
            let (photon, represented) = (self.photons[j], 1.0 / probabilities[j]);
            let photon = Photon {
                flux: photon.flux * represented,
                diffuse_flux: photon.diffuse_flux * represented,
                ..photon
            };
            (photon, self.weights[j] * represented)
        });
        let (photons, weights) = thinned.unzip();
        Candidates::new(photons, weights)
    }
}

/// Luminance of the flux of each photon, in W.
fn luminances(photons: &[Photon]) -> Vec<f32> {
    photons.iter().map(|p| p.flux.luminance()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::photons_on_square;
    use super::*;

    #[test]
    fn thinning_keeps_flux_and_weight_on_average() {
        let photons = photons_on_square(1000, 1);
        let flux = |photons: &[Photon]| photons.iter().map(|p| f64::from(p.flux.g)).sum::<f64>();
        let sum = |weights: &[f32]| weights.iter().map(|&w| f64::from(w)).sum::<f64>();
        // The importance of half of the photons is 0.
        let weights: Vec<f32> = photons
            .iter()
            .map(|p| p.flux.luminance() * (p.p.x - 0.5).max(0.0))
            .collect();
        let (mut mean_flux, mut mean_weight, trials) = (0.0, 0.0, 64);
        for t in 0..trials {
            let u = (t as f32 + 0.5) / trials as f32;
            let thinned = Candidates::new(photons.clone(), weights.clone()).thinned(300, u);
            let count = thinned.photons.len();
            assert!(count.abs_diff(300) <= 1 && count == thinned.weights.len());
            let seen = thinned.photons.iter().filter(|p| p.p.x > 0.5).count();
            assert!(seen > 200, "{seen} of {count} are seen");
            mean_flux += flux(&thinned.photons) / f64::from(trials);
            mean_weight += sum(&thinned.weights) / f64::from(trials);
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
        let all = Candidates::new(photons, weights).thinned(1000, 0.9);
        assert_eq!(all.photons.len(), 1000);
    }
}
