//! The photons that may become lights, what placement goes by, and the choice.

use super::PassContext;
use super::axes::{FluxRule, Placement};
use super::many_light::ManyLight;
use crate::maps::KdTree;
use crate::maps::density::NearbyImportance;
use crate::particles::{Importon, Photon};
use crate::sampling::Stream;
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::scene::PathLimits;
use crate::stats::Stats;
use crate::virtual_lights::curve::Curve;
use crate::virtual_lights::select::defensive_weights;
use crate::virtual_lights::{Site, select};
use rayon::prelude::*;

/// More photons than this on average do not make lights better: theirs is the least of all noise.
const PHOTONS_PER_LIGHT: usize = 1024;
/// Which ones stay is said by their weight, and to this share by their flux alone.
const KEPT_BY_FLUX: f32 = 0.25;
/// Lights are placed by importance x flux, and by this much as often by flux alone: where importons have missed what matters, the
/// photons must not all belong to a few lights far off.
const PLACED_BY_FLUX: f32 = 0.1;

impl ManyLight {
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
        let thin = self.flux == FluxRule::Partition;
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
            Placement::Importance | Placement::Relaxed => {
                let mixed = defensive_weights(weights, &fluxes(photons), PLACED_BY_FLUX);
                select(photons, &mixed, count, u)
            }
        }
    }
}

/// The photons that may become lights: a light at depth m makes paths of at least m + 2 segments. In the order of the curve.
pub(super) fn light_carriers(limits: PathLimits, mut photons: Vec<Photon>) -> Vec<Photon> {
    photons.retain(|p| limits.allow(u32::from(p.depth) + 2));
    Curve::sorted(&photons)
}

/// What the paper's placement goes by: how much of each photon reaches the camera, if importance did not depend on direction.
pub(super) fn importance_times_flux(
    importance: &KdTree<Importon>,
    photons: &[Photon],
    stats: &Stats,
) -> Vec<f32> {
    stats.time("importance", || {
        // Photons that follow each other are near each other.
        let weights = photons.par_chunks(RUN).flat_map_iter(|run| {
            let mut estimates = NearbyImportance::new(importance);
            run.iter()
                .map(move |photon| estimates.at(photon.p, photon.n) * photon.flux.luminance())
        });
        weights.collect()
    })
}

/// Photons that share estimates of importance; as many whatever the number of threads.
const RUN: usize = 1024;

/// Photons that may become lights, with what placement goes by and its random numbers.
pub(super) struct Candidates {
    pub(super) photons: Vec<Photon>,
    pub(super) weights: Vec<f32>,
    pub(super) u_sites: f32,
    pub(super) u_residual: f32,
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
}
