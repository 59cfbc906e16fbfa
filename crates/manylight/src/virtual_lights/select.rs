//! Placement, step 1: the choice of the photons that become virtual lights.
//!
//! Source: Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light
//! Methods", Eurographics 2015: a photon is accepted with probability `min(1, W_j / (q W̄))`. Here
//! the number of lights is given instead of the ratio `q`.

use crate::particles::Photon;
use crate::sampling::systematic::{inclusion_probabilities, systematic};

/// Smallest weight in a selection, relative to the mean weight. A photon's flux is divided by its
/// probability, so that a photon of underestimated importance would become a very bright light. It
/// gets at most 1000 times the flux of one of mean weight, for 0.1 % of the lights at most; twice
/// the floor halves that flux and doubles these lights.
pub(super) const WEIGHT_FLOOR: f32 = 1e-3;

/// A photon that was chosen to become a virtual light.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Index of the photon.
    pub photon: u32,
    /// Probability of the choice, in (0, 1].
    pub probability: f32,
}

/// Mixture of two selection densities, `w_j / Σw + by_flux · Φ_j / ΣΦ`: the second term bounds the
/// flux over probability of every photon, whatever the errors of `weights`.
///
/// `weights[j] >= 0` and `fluxes[j] >= 0` belong to photon `j`; both have any unit. Source:
/// Hesterberg, "Weighted Average Importance Sampling and Defensive Mixture Distributions", 1995.
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

/// Selects `count` photons, or all photons with flux if these are fewer. Photon `j` is chosen with
/// probability `a_j = min(1, w_j / τ)`, with the `τ` for which `Σ a_j = count`; `Φ_j / a_j` is then
/// an unbiased estimate of all flux.
///
/// `weights[j] >= 0` is the luminance of the flux of `photons[j]`, optionally times importance;
/// photons with flux and weight 0 keep a small probability. `u` in [0, 1) is the only random number
/// (systematic sampling). Sites keep the order of the photons: in the order of the
/// [`Curve`](super::curve::Curve) they are spread evenly over each surface.
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
    fn the_count_is_fixed_and_flux_is_unbiased() {
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
    fn sites_follow_the_curve_and_black_photons_are_left_out() {
        let photons = photons_on_square(3000, 2);
        let mut photons = Curve::around(&photons).sorted(&photons);
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
        let keys: Vec<_> = sites
            .iter()
            .map(|s| curve.photon_key(&photons[s.photon as usize]))
            .collect();
        assert!(keys.is_sorted());
        // Consecutive lights are close: the mean step along the curve is of the order of the mean
        // spacing, 1/sqrt(300).
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
    fn more_lights_than_photons_select_every_photon() {
        let photons = photons_on_square(50, 3);
        let sites = select(&photons, &[1.0; 50], 100, 0.3);
        assert_eq!(sites.len(), 50);
        assert!(sites.iter().all(|s| s.probability == 1.0));
        assert!(select(&[], &[], 100, 0.3).is_empty());
    }
}
