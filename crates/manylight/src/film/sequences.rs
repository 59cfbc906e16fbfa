//! Variances of means over passes that continue two independent sequences, the even passes one and
//! the odd passes another.
//!
//! The points of a sequence are stratified over its passes, so that the spread over passes
//! overestimates the variance of their mean. The sums `A` and `B` over the even and the odd passes
//! are independent: `var (A + B) = var (A - B)`, and `(A - B)²` estimates it without bias, with one
//! degree of freedom. The spread over passes has many. The mean over a tile of the ratio of both
//! estimates, times the spread in a pixel, has the mean of the first and hardly more noise than the
//! second.

/// Pixels with a ratio of 1 that a mean of ratios contains beside those of the tile. Where few
/// pixels of a tile have noise, the factor stays close to 1, and the variance an upper bound. In a
/// tile of 64 pixels with noise they change the factor by at most 2 in 66, 3 %.
const PRIOR_PIXELS: f64 = 2.0;

/// Numbers of even and odd passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves {
    even: f64,
    odd: f64,
}

impl Halves {
    /// Those of the passes from `start` to `end`.
    pub(super) fn of(start: u32, end: u32) -> Self {
        let odd = end / 2 - start / 2;
        Halves {
            even: f64::from(end - start - odd),
            odd: f64::from(odd),
        }
    }

    /// Variance of the mean, from the sum over all passes and the difference of even and odd ones.
    /// Unbiased if passes are independent, or if both numbers are equal.
    pub(super) fn variance(self, sum: [f64; 3], difference: [f64; 3]) -> [f64; 3] {
        let n = self.even + self.odd;
        let correction = n * n / (4.0 * self.even * self.odd);
        std::array::from_fn(|c| {
            let expected = sum[c] * (self.even - self.odd) / n;
            correction * (difference[c] - expected).powi(2) / (n * n)
        })
    }
}

/// Mean over pixels of the ratio of two estimates, per channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanRatio {
    sum: [f64; 3],
    count: [f64; 3],
}

impl MeanRatio {
    /// Adds a pixel; channels without spread are left out.
    pub(super) fn add(&mut self, variance: [f64; 3], spread: [f64; 3]) {
        for c in 0..3 {
            if spread[c] > 0.0 {
                self.sum[c] += variance[c] / spread[c];
                self.count[c] += 1.0;
            }
        }
    }

    /// The mean, with [`PRIOR_PIXELS`].
    pub(super) fn mean(self) -> [f64; 3] {
        std::array::from_fn(|c| (self.sum[c] + PRIOR_PIXELS) / (self.count[c] + PRIOR_PIXELS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    /// For independent passes the ratio has mean 1, whatever the number of passes.
    #[test]
    fn independent_passes_have_a_ratio_of_one() {
        let mut rng = Pcg::new(5);
        for passes in [2, 3, 4, 7, 16] {
            let (mut ratios, mut estimated) = (MeanRatio::default(), 0.0);
            let trials = 20_000;
            for _ in 0..trials {
                let (mut sum, mut square, mut difference) = (0.0, 0.0, 0.0);
                for pass in 0..passes {
                    let x = f64::from(rng.next_f32());
                    sum += x;
                    square += x * x;
                    difference += if pass % 2 == 0 { x } else { -x };
                }
                let n = f64::from(passes);
                let spread = (square / n - (sum / n).powi(2)) / (n - 1.0);
                let variance = Halves::of(0, passes).variance([sum; 3], [difference; 3]);
                ratios.add(variance, [spread; 3]);
                estimated += variance[1];
            }
            let ratio = ratios.mean()[1];
            assert!((ratio - 1.0).abs() < 0.05, "{passes}: {ratio}");
            let expected = f64::from(trials) / (12.0 * f64::from(passes));
            let estimated = estimated / expected;
            assert!((estimated - 1.0).abs() < 0.06, "{passes}: {estimated}");
        }
    }

    /// Two sequences, each with a point in each of equal intervals: the variance is that of such
    /// means, far below the spread of passes.
    #[test]
    fn the_variance_of_stratified_passes_is_honest() {
        let mut rng = Pcg::new(8);
        let (trials, passes) = (4000, 16);
        let (mut estimated, mut spread, mut actual) = (0.0, 0.0, 0.0);
        for _ in 0..trials {
            let (mut sum, mut square, mut difference) = (0.0, 0.0, 0.0);
            for pass in 0..passes {
                let interval = f64::from(pass / 2);
                let x = (interval + f64::from(rng.next_f32())) / f64::from(passes / 2);
                sum += x;
                square += x * x;
                difference += if pass % 2 == 0 { x } else { -x };
            }
            let n = f64::from(passes);
            estimated += Halves::of(0, passes).variance([sum; 3], [difference; 3])[2];
            spread += (square / n - (sum / n).powi(2)) / (n - 1.0);
            actual += (sum / n - 0.5).powi(2);
        }
        assert!(
            (estimated / actual - 1.0).abs() < 0.1,
            "{estimated} for {actual}"
        );
        assert!(spread > 30.0 * actual, "{spread} for {actual}");
    }
}
