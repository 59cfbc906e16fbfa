//! Placement: which photons become lights.

use super::Site;
use crate::particles::Photon;
use crate::sampling::systematic::{inclusion_probabilities, systematic};

/// Weights below this share of their mean are raised to it: estimates of importance miss what matters now and then, and
/// the flux of a light is divided by its probability.
pub(super) const WEIGHT_FLOOR: f32 = 1e-3;

/// PhotonClusters of the sum of `weights`, plus `by_flux` times those of the sum of `fluxes`: what is kept by these has bounded flux, however
/// wrong the weights are. Source: Hesterberg, "Weighted Average Importance Sampling and Defensive Mixture Distributions", 1995.
pub(crate) fn defensive_weights(weights: &[f32], fluxes: &[f32], by_flux: f32) -> Vec<f32> {
    let sum = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>();
    let share = |part: f32, all: f64| {
        if all > 0.0 {
            (f64::from(part) / all) as f32
        } else {
            0.0
        }
    };
    let (all_weights, all_flux) = (sum(weights), sum(fluxes));
    weights
        .iter()
        .zip(fluxes)
        .map(|(&w, &flux)| share(w, all_weights) + by_flux * share(flux, all_flux))
        .collect()
}

/// Keeps `count` photons (or all, if fewer carry flux), each with probability proportional to its weight as far as that is
/// below 1, with the one random number `u` in [0, 1). Any photon with flux may be kept, whatever its weight.
/// The sites have the order of the photons: if that is the curve's ([`Curve::sorted`](super::curve::Curve::sorted)), they are spread evenly
/// over each surface.
///
/// `weights[j] >= 0` belongs to `photons[j]`: luminance of the flux, or that times importance.
pub fn select(photons: &[Photon], weights: &[f32], count: usize, u: f32) -> Vec<Site> {
    assert_eq!(photons.len(), weights.len(), "one weight per photon");
    let weight = |(photon, &weight): (&Photon, &f32)| match photon.flux.is_black() {
        true => 0.0,
        false => weight.max(f32::MIN_POSITIVE),
    };
    let weights: Vec<f32> = photons.iter().zip(weights).map(weight).collect();
    let probabilities = inclusion_probabilities(&weights, count, WEIGHT_FLOOR);
    systematic(&probabilities, u)
        .into_iter()
        .map(|i| Site {
            photon: i as u32,
            probability: probabilities[i],
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::curve::Curve;
    use super::super::testing::photons_on_square;
    use super::*;
    use crate::color::Rgb;

    #[test]
    fn the_count_is_fixed_and_flux_is_kept_on_average() {
        let photons = photons_on_square(4000, 1);
        let weights: Vec<f32> = photons
            .iter()
            .map(|p| p.flux.luminance() * p.p.x.max(0.05))
            .collect();
        let total: f64 = photons.iter().map(|p| f64::from(p.flux.g)).sum();
        let (mut mean, trials) = (0.0, 64);
        for t in 0..trials {
            let sites = select(&photons, &weights, 200, (t as f32 + 0.5) / trials as f32);
            assert!(sites.len().abs_diff(200) <= 1);
            for site in &sites {
                mean += f64::from(photons[site.photon as usize].flux.g / site.probability)
                    / f64::from(trials);
            }
        }
        assert!((mean / total - 1.0).abs() < 0.01, "{mean} of {total}");
    }

    #[test]
    fn sites_follow_the_curve_and_black_photons_are_no_lights() {
        let mut photons = Curve::sorted(&photons_on_square(3000, 2));
        for photon in photons.iter_mut().step_by(2) {
            photon.flux = Rgb::BLACK;
        }
        let weights = vec![0.0; photons.len()];
        let sites = select(&photons, &weights, 300, 0.5);
        assert!(sites.len().abs_diff(300) <= 1);
        assert!(
            sites
                .iter()
                .all(|s| !photons[s.photon as usize].flux.is_black())
        );
        let curve = Curve::around(&photons);
        let keys: Vec<u64> = sites
            .iter()
            .map(|s| curve.key(photons[s.photon as usize].p, photons[s.photon as usize].n))
            .collect();
        assert!(keys.is_sorted());
        // Consecutive lights are close: the mean step along the curve is of the order of the mean spacing, 1/sqrt(300).
        let path: f32 = sites
            .windows(2)
            .map(|s| {
                photons[s[0].photon as usize]
                    .p
                    .distance(photons[s[1].photon as usize].p)
            })
            .sum();
        assert!(path / 299.0 < 2.0 / 300f32.sqrt(), "{path}");
    }

    #[test]
    fn asking_for_more_than_there_is_keeps_everything() {
        let photons = photons_on_square(50, 3);
        let sites = select(&photons, &[1.0; 50], 100, 0.3);
        assert_eq!(sites.len(), 50);
        assert!(sites.iter().all(|s| s.probability == 1.0));
        assert!(select(&[], &[], 100, 0.3).is_empty());
    }
}
