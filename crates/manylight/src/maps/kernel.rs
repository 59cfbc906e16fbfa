//! Kernels of density estimates on surfaces, normalized over a disc.

use std::f32::consts::FRAC_1_PI;

/// Weight of neighbors at distance `d` within the bandwidth `r`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityKernel {
    /// `1 / (π r²)`. If `r` is the distance of the K-th neighbor, the density is overestimated by the factor K/(K-1).
    Constant,
    /// `2 / (π r²) (1 - d²/r²)`. Unbiased for homogeneous particles, both for a fixed `r` and for the distance of the K-th neighbor.
    Epanechnikov,
}

impl DensityKernel {
    /// Weight in 1/m² at the squared distance `d2`, at most `r2 = r²`; 0 for an empty disc.
    #[inline]
    pub fn weight(self, d2: f32, r2: f32) -> f32 {
        if r2 <= 0.0 {
            return 0.0;
        }
        match self {
            DensityKernel::Constant => FRAC_1_PI / r2,
            DensityKernel::Epanechnikov => 2.0 * FRAC_1_PI / r2 * (1.0 - d2 / r2).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_integrate_to_one_over_the_disc() {
        let (r, steps) = (0.3f32, 10_000);
        for kernel in [DensityKernel::Constant, DensityKernel::Epanechnikov] {
            let sum: f64 = (0..steps)
                .map(|i| {
                    let d = r * (i as f32 + 0.5) / steps as f32;
                    let ring =
                        std::f64::consts::TAU * f64::from(d) * f64::from(r) / f64::from(steps);
                    ring * f64::from(kernel.weight(d * d, r * r))
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{kernel:?}: {sum}");
        }
    }
}
