//! Pearson's χ² test of samplers of directions against their densities.
//!
//! The sphere is divided into cells of equal solid angle. The number of samples in each cell is
//! compared with the integral of the density over the cell. Samples without a direction
//! (absorption, Dirac lobes) fall into an additional cell with the expected probability of one
//! minus the integral of the density, so that the test checks this integral too.

use crate::math::{Frame, Vec3};
use std::f64::consts::{PI, TAU};

/// Resolution of a test.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    /// Number of bands of equal height along the axis.
    pub bands: usize,
    /// Number of cells around the axis in each band.
    pub sectors: usize,
    /// Number of evaluations of the density per cell and dimension.
    pub points: usize,
    /// Number of samples.
    pub samples: u32,
}

impl Default for Resolution {
    fn default() -> Self {
        Resolution {
            bands: 24,
            sectors: 32,
            points: 8,
            samples: 20_000,
        }
    }
}

/// Result of a test.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquareResult {
    /// Pearson's statistic.
    pub chi_square: f64,
    /// Degrees of freedom.
    pub freedom: usize,
    /// Probability that a correct sampler gives a statistic at least as large.
    pub p_value: f64,
    /// Integral of the density over the sphere.
    pub mass: f64,
}

/// Smallest expected number of samples of a cell, the usual limit of the test's approximation;
/// cells below are merged.
const MIN_EXPECTED: f64 = 5.0;

/// Tests samples against their density. `sample(i)` is the i-th independent sample, `pdf` its
/// density per solid angle. The cells are arranged around the unit vector `axis`, which should be
/// an axis of symmetry of the density or the normal of its horizon.
pub fn test_directions(
    axis: Vec3,
    resolution: Resolution,
    mut sample: impl FnMut(u32) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> ChiSquareResult {
    let cells = Cells {
        frame: Frame::from_normal(axis),
        resolution,
    };
    let count = f64::from(resolution.samples);
    let mut expected: Vec<f64> = (0..cells.count())
        .map(|cell| cells.integrate(cell, &pdf) * count)
        .collect();
    let mass = expected.iter().sum::<f64>() / count;
    expected.push((count * (1.0 - mass)).max(0.0));

    let mut observed = vec![0.0; cells.count() + 1];
    for i in 0..resolution.samples {
        observed[sample(i).map_or(cells.count(), |w| cells.find(w))] += 1.0;
    }
    let (chi_square, freedom) = statistic(&observed, &expected);
    ChiSquareResult {
        chi_square,
        freedom,
        p_value: upper_gamma(0.5 * freedom as f64, 0.5 * chi_square),
        mass,
    }
}

/// Pearson's statistic and its degrees of freedom. Cells with an expected count below 5 are merged.
pub fn statistic(observed: &[f64], expected: &[f64]) -> (f64, usize) {
    let (mut sum, mut count) = (0.0, 0);
    let (mut rest_observed, mut rest_expected) = (0.0, 0.0);
    for (&o, &e) in observed.iter().zip(expected) {
        if e < MIN_EXPECTED {
            rest_observed += o;
            rest_expected += e;
        } else {
            sum += (o - e) * (o - e) / e;
            count += 1;
        }
    }
    // The expected count of the merged cell may still be below the limit: then the limit replaces
    // it.
    if rest_observed > 0.0 || rest_expected > 0.0 {
        sum += (rest_observed - rest_expected).powi(2) / rest_expected.max(MIN_EXPECTED);
        count += 1;
    }
    (sum, count.max(2) - 1)
}

/// Regularized upper incomplete gamma function Q(a, x).
///
/// Source: Press et al., "Numerical Recipes", section 6.2: the series below a + 1, Lentz's
/// continued fraction above.
pub fn upper_gamma(a: f64, x: f64) -> f64 {
    /// Relative size of a term at which the series and the fraction end.
    const CONVERGED: f64 = 1e-14;
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * CONVERGED {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * scale;
    }
    let mut b = x + 1.0 - a;
    let mut c = f64::MAX;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < CONVERGED {
            break;
        }
    }
    scale * h
}

/// Logarithm of the gamma function: Stirling's series, with the argument raised to at least 15 by
/// recurrence.
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 15.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let x2 = x * x;
    shift + (x - 0.5) * x.ln() - x
        + 0.5 * TAU.ln()
        + (1.0 / 12.0 - (1.0 / 360.0 - 1.0 / (1260.0 * x2)) / x2) / x
}

/// Cells of equal solid angle on the sphere.
struct Cells {
    frame: Frame,
    resolution: Resolution,
}

impl Cells {
    fn count(&self) -> usize {
        self.resolution.bands * self.resolution.sectors
    }

    fn find(&self, w: Vec3) -> usize {
        let Resolution { bands, sectors, .. } = self.resolution;
        let local = self.frame.to_local(w).as_dvec3();
        let part = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        let turn = local.y.atan2(local.x) / TAU;
        part(0.5 * (local.z + 1.0), bands) * sectors + part(turn.rem_euclid(1.0), sectors)
    }

    /// Integral of `pdf` over a cell by the midpoint rule.
    fn integrate(&self, cell: usize, pdf: &impl Fn(Vec3) -> f32) -> f64 {
        let Resolution {
            bands,
            sectors,
            points,
            ..
        } = self.resolution;
        let (band, sector) = (cell / sectors, cell % sectors);
        let at =
            |i: usize, k: usize, n: usize| (i as f64 + (k as f64 + 0.5) / points as f64) / n as f64;
        let mut sum = 0.0;
        for k in 0..points * points {
            let z = 2.0 * at(band, k / points, bands) - 1.0;
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (TAU * at(sector, k % points, sectors)).sin_cos();
            let w = Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32);
            sum += f64::from(pdf(self.frame.to_world(w)));
        }
        sum * 4.0 * PI / (self.count() * points * points) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Sampler, Stream, warp};

    #[test]
    fn the_gamma_function_matches_tables_of_chi_square() {
        // Quantiles of the χ² distribution: Abramowitz and Stegun, table 26.8.
        for (freedom, chi_square, p) in [
            (1.0, 3.841_459, 0.05),
            (10.0, 18.307_04, 0.05),
            (100.0, 135.806_7, 0.01),
        ] {
            let q: f64 = upper_gamma(0.5 * freedom, 0.5 * chi_square);
            assert!((q - p).abs() < 1e-6, "{freedom}: {q}");
        }
        assert!((upper_gamma(0.5, 1e-8) - 1.0).abs() < 2e-4);
    }

    #[test]
    fn a_right_density_passes_and_a_wrong_one_fails() {
        let sample = |i: u32| {
            let mut sampler = Sampler::new(1, 0, Stream::Test, u64::from(i));
            Some(warp::cosine_hemisphere(sampler.next_2d()))
        };
        let right = |w: Vec3| warp::cosine_hemisphere_pdf(w.z);
        let outcome = test_directions(Vec3::Z, Resolution::default(), sample, right);
        assert!(
            outcome.p_value > 0.01 && (outcome.mass - 1.0).abs() < 1e-3,
            "{outcome:?}"
        );
        // Densities that are wrong: tilted by eleven degrees, and two percent too small.
        let tilted =
            |w: Vec3| warp::cosine_hemisphere_pdf(w.dot(Vec3::new(0.2, 0.0, 1.0).normalize()));
        assert!(test_directions(Vec3::Z, Resolution::default(), sample, tilted).p_value < 1e-6);
        let weak = |w: Vec3| 0.98 * right(w);
        assert!(test_directions(Vec3::Z, Resolution::default(), sample, weak).p_value < 1e-6);
    }
}
