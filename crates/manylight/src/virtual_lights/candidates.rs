//! The photons that may become virtual lights, with the weights that placement follows.

use super::curve::Curve;
use super::select::defensive_weights;
use crate::maps::KdTree;
use crate::maps::density::NearbyImportance;
use crate::particles::{Importon, Photon};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::scene::PathLimits;
use rayon::prelude::*;

/// Probability of keeping a photon that follows its flux alone, relative to that which follows its weight. Bounds the flux of
/// kept photons where importance is underestimated. Measured against keeping by flux alone: on veach-ajar, the spread of the
/// mean over seeds falls from 0.45 to 0.2 % at 16 passes.
const KEPT_BY_FLUX: f32 = 0.25;
/// Consecutive photons that share importance estimates. Fixed, so that results do not depend on the number of threads.
const PHOTONS_PER_RUN: usize = 1024;

/// The photons at which a virtual light makes a path within `limits`: a light at photon depth m makes paths of at least m + 2
/// segments. In the order of the space-filling curve.
pub(crate) fn light_carriers(limits: PathLimits, mut photons: Vec<Photon>) -> Vec<Photon> {
    photons.retain(|p| limits.allow(u32::from(p.depth) + 2));
    Curve::sorted(&photons)
}

/// Luminance of the flux of each photon, in W.
pub(crate) fn luminances(photons: &[Photon]) -> Vec<f32> {
    photons.iter().map(|p| p.flux.luminance()).collect()
}

/// Importance times flux of each photon, in W/m²: the weights of the paper's placement. Importance counts as independent of
/// direction.
pub(crate) fn importance_times_flux(importance: &KdTree<Importon>, photons: &[Photon]) -> Vec<f32> {
    // Photons that are neighbors on the curve are neighbors in space.
    let weights = photons.par_chunks(PHOTONS_PER_RUN).flat_map_iter(|run| {
        let mut estimates = NearbyImportance::new(importance);
        run.iter()
            .map(move |photon| estimates.at(photon.p, photon.n) * photon.flux.luminance())
    });
    weights.collect()
}

/// Probabilities with which about `most` of the photons are kept, all if there are fewer.
pub(crate) fn keeping_probabilities(photons: &[Photon], weights: &[f32], most: usize) -> Vec<f32> {
    if photons.len() <= most {
        return vec![1.0; photons.len()];
    }
    let mixed = defensive_weights(weights, &luminances(photons), KEPT_BY_FLUX);
    inclusion_probabilities(&mixed, most, 0.0)
}

/// Keeps about `most` of the photons, or all if there are fewer, with probability by weight. The flux and the weight of a
/// kept photon are divided by its probability. `u` in [0, 1) is the one random number. Returns the weights too.
pub(crate) fn thin_photons(
    photons: Vec<Photon>,
    weights: Vec<f32>,
    most: usize,
    u: f32,
) -> (Vec<Photon>, Vec<f32>) {
    if photons.len() <= most {
        return (photons, weights);
    }
    let probabilities = keeping_probabilities(&photons, &weights, most);
    let kept = systematic(&probabilities, u).into_par_iter().map(|j| {
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
            let (kept, its_weights) = thin_photons(photons.clone(), weights.clone(), 300, u);
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
        assert_eq!(thin_photons(photons, weights, 1000, 0.9).0.len(), 1000);
    }
}
