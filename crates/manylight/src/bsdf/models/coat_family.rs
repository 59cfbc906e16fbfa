//! Tables of all rough coats of a scene. Few are integrated one by one; many are interpolated
//! between integrated ones.

use super::coat::{COSINES, Coat};
use super::microfacet::MIN_ALPHA;
use crate::bsdf::material::Distribution;
use rayon::prelude::*;

/// The parameters of a rough coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bsdf) struct CoatParameters {
    pub distribution: Distribution,
    pub alpha: f32,
    /// Index of refraction relative to the outside.
    pub eta: f32,
}

/// Most coats that are integrated one by one: as many as the family below integrates.
const MAX_INTEGRATED: usize = ALPHA_NODES * ETA_NODES;
/// Nodes over ln alpha. From alpha 10⁻⁴ to 1, GGX transmittances are off by at most 2·10⁻⁵ with 24
/// nodes and 4·10⁻⁴ with 16; with Beckmann's, by 10⁻⁴.
const ALPHA_NODES: usize = 24;
/// Nodes over ln |η - 1|. With η from 1.01 to 2.5, GGX transmittances are off by at most 10⁻⁶; from
/// 1.0001 to 4, by 3·10⁻⁴. No η below 1 was compared.
const ETA_NODES: usize = 12;
/// Smallest |η - 1| in a family; smaller values count as this one. Such coats hardly reflect.
const MIN_CONTRAST: f64 = 1e-4;

/// The table of each of the coats.
pub(in crate::bsdf) fn tabulate(coats: &[CoatParameters]) -> Vec<Coat> {
    if coats.len() <= MAX_INTEGRATED {
        return coats.par_iter().map(integrate).collect();
    }
    let families = [Distribution::Ggx, Distribution::Beckmann].map(|distribution| {
        [false, true].map(|is_denser| {
            let is_member = |c: &&CoatParameters| c.is_in(distribution, is_denser);
            Family::spanning(coats.iter().filter(is_member), is_denser)
        })
    });
    let table = |coat: &CoatParameters| {
        let [ggx, beckmann] = &families;
        let by_density = match coat.distribution {
            Distribution::Ggx => ggx,
            Distribution::Beckmann => beckmann,
        };
        by_density[usize::from(coat.is_denser())].interpolate(coat)
    };
    coats.par_iter().map(table).collect()
}

impl CoatParameters {
    fn is_denser(&self) -> bool {
        self.eta >= 1.0
    }

    fn is_in(&self, distribution: Distribution, is_denser: bool) -> bool {
        self.distribution == distribution && self.is_denser() == is_denser
    }

    /// ln α.
    fn alpha_position(&self) -> f64 {
        f64::from(self.alpha.max(MIN_ALPHA)).ln()
    }

    /// ln |η - 1|: the cosines at which light enters a coat follow it.
    fn eta_position(&self) -> f64 {
        (f64::from(self.eta) - 1.0).abs().max(MIN_CONTRAST).ln()
    }
}

fn integrate(coat: &CoatParameters) -> Coat {
    Coat::new(coat.distribution, coat.alpha, coat.eta)
}

/// Coats of one distribution on a grid, all denser or all thinner than the outside.
struct Family {
    /// Over ln α.
    alphas: Nodes,
    /// Over ln |η - 1|.
    etas: Nodes,
    /// By index of refraction, then by alpha.
    coats: Vec<Coat>,
}

impl Family {
    /// A grid that spans its members.
    fn spanning<'c>(
        members: impl Iterator<Item = &'c CoatParameters> + Clone,
        is_denser: bool,
    ) -> Self {
        let alphas = members.clone().map(CoatParameters::alpha_position);
        let alphas = Nodes::spanning(alphas, ALPHA_NODES);
        let etas = members.clone().map(CoatParameters::eta_position);
        let etas = Nodes::spanning(etas, ETA_NODES);
        let side = if is_denser { 1.0 } else { -1.0 };
        let place = |i: usize| CoatParameters {
            distribution: members
                .clone()
                .next()
                .map_or(Distribution::Ggx, |c| c.distribution),
            alpha: alphas.at[i % alphas.at.len()].exp() as f32,
            eta: (1.0 + side * etas.at[i / alphas.at.len()].exp()) as f32,
        };
        let places: Vec<CoatParameters> = (0..alphas.at.len() * etas.at.len()).map(place).collect();
        let coats = places.par_iter().map(integrate).collect();
        Family {
            alphas,
            etas,
            coats,
        }
    }

    /// The interpolating polynomial at a coat.
    fn interpolate(&self, coat: &CoatParameters) -> Coat {
        let alphas = self.alphas.coefficients(coat.alpha_position());
        let etas = self.etas.coefficients(coat.eta_position());
        let mut transmittance = [0.0f32; COSINES];
        let mut internal_reflectance = 0.0;
        for (row, &of_eta) in self.coats.chunks_exact(alphas.len()).zip(&etas) {
            for (node, &of_alpha) in row.iter().zip(&alphas) {
                let weight = (of_eta * of_alpha) as f32;
                if weight == 0.0 {
                    continue;
                }
                for (sum, t) in transmittance.iter_mut().zip(&node.transmittance) {
                    *sum += weight * t;
                }
                internal_reflectance += weight * node.internal_reflectance;
            }
        }
        Coat {
            transmittance: transmittance.map(|t| t.clamp(0.0, 1.0)),
            internal_reflectance: internal_reflectance.clamp(0.0, 1.0),
        }
    }
}

/// Nodes of a polynomial, with the weights of the second form of the barycentric formula. Source:
/// Berrut and Trefethen, "Barycentric Lagrange Interpolation", SIAM Review 46, 2004, section 5.
struct Nodes {
    at: Vec<f64>,
    weights: Vec<f64>,
}

impl Nodes {
    /// `count` Chebyshev points of the first kind over the range of the values; if there are fewer
    /// different values, these.
    fn spanning(values: impl Iterator<Item = f64>, count: usize) -> Self {
        let mut at: Vec<f64> = values.collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        if at.len() > count {
            let (low, high) = (at[0], at[at.len() - 1]);
            let point = |i| 0.5 * (low + high) - 0.5 * (high - low) * angle(i, count).cos();
            at = (0..count).map(point).collect();
        }
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let weights = (0..at.len()).map(|i| sign(i) * angle(i, at.len()).sin());
        Nodes {
            weights: weights.collect(),
            at,
        }
    }

    /// The factor of each node's value in the value at `x`.
    fn coefficients(&self, x: f64) -> Vec<f64> {
        if let Some(found) = self.at.iter().position(|&at| at == x) {
            return (0..self.at.len())
                .map(|i| f64::from(u8::from(i == found)))
                .collect();
        }
        let terms: Vec<f64> = self
            .at
            .iter()
            .zip(&self.weights)
            .map(|(at, weight)| weight / (x - at))
            .collect();
        let sum: f64 = terms.iter().sum();
        terms.iter().map(|term| term / sum).collect()
    }
}

/// The angle of a Chebyshev point of the first kind.
fn angle(i: usize, count: usize) -> f64 {
    (2 * i + 1) as f64 * std::f64::consts::PI / (2 * count) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `count` coats with different alphas from 10⁻⁴ to 1 and indices in the range.
    fn coats(count: usize, [low, high]: [f32; 2]) -> Vec<CoatParameters> {
        let coat = |i: usize| {
            let share = |k: f32| (0.5 + i as f32 * k) % 1.0;
            CoatParameters {
                distribution: if i.is_multiple_of(7) {
                    Distribution::Beckmann
                } else {
                    Distribution::Ggx
                },
                alpha: 10.0f32.powf(-4.0 * share(0.618_034)),
                eta: low + (high - low) * share(0.754_877_7),
            }
        };
        (0..count).map(coat).collect()
    }

    /// Largest errors of transmittance and of internal reflectance of some tables.
    fn largest_errors(coats: &[CoatParameters]) -> [f32; 2] {
        let mut largest = [0.0f32; 2];
        for (parameters, coat) in coats.iter().zip(tabulate(coats)).step_by(499) {
            let exact = integrate(parameters);
            for (a, b) in coat.transmittance.iter().zip(&exact.transmittance) {
                largest[0] = largest[0].max((a - b).abs());
            }
            let reflectances = [coat.internal_reflectance, exact.internal_reflectance];
            largest[1] = largest[1].max((reflectances[0] - reflectances[1]).abs());
        }
        largest
    }

    #[test]
    fn many_coats_are_close_to_integrated_ones() {
        // The integral of the internal reflectance is off by up to 10⁻³ itself.
        let ranges = [[1.49, 1.49], [1.01, 2.5]];
        let errors = ranges.map(|range| largest_errors(&coats(10_000, range)));
        for ([transmittance, internal], largest) in errors.into_iter().zip([3e-4, 1e-3]) {
            assert!(transmittance < largest, "{errors:?}");
            assert!(internal < 1e-2, "{errors:?}");
        }
    }

    #[test]
    fn few_coats_are_integrated_and_known_values_are_exact() {
        let few = coats(20, [1.2, 1.8]);
        assert_eq!(largest_errors(&few), [0.0; 2]);
        let nodes = Nodes::spanning([2.0, 1.0, 2.0].into_iter(), 5);
        assert_eq!(nodes.coefficients(1.0), [1.0, 0.0]);
        let nodes = Nodes::spanning((0..100).map(f64::from), 6);
        let cubic = |x: f64| x * x * x - 2.0 * x;
        let value: f64 = nodes
            .coefficients(31.7)
            .iter()
            .zip(&nodes.at)
            .map(|(c, at)| c * cubic(*at))
            .sum();
        assert!((value / cubic(31.7) - 1.0).abs() < 1e-12);
    }
}
