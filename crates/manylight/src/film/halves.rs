//! Two halves of the passes, independent of each other, and variances from their difference.
//!
//! Passes of one half may depend on each other: they share virtual lights, or continue one sequence
//! of samples, which is stratified over them. The spread over passes then under- or overestimates
//! the variance of their mean. The sums `A` and `B` over the halves are independent:
//! `var (A + B) = var (A - B)`, and `(A - B)²` estimates it without bias, with one degree of
//! freedom. The spread over passes has many. The mean over a tile and those around it of the ratio
//! of both estimates, times the spread in a pixel, has the mean of the first and hardly more noise
//! than the second.

use super::batches::add;

/// Pixels with a ratio of 1 that a mean of ratios contains beside those of the tiles. Where few
/// pixels have noise, the factor stays close to 1. With one tile of 64 pixels with noise they
/// change the factor by at most 2 in 66, 3 %.
const PRIOR_PIXELS: f64 = 2.0;

/// One of two halves of the passes. Passes of different halves are independent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Half {
    /// That of the first pass.
    #[default]
    First,
    /// The other one.
    Second,
}

impl Half {
    /// Both halves.
    pub const BOTH: [Half; 2] = [Half::First, Half::Second];

    /// The half of the `k`-th of sets of passes, which belong to both halves in turn.
    pub fn of_set(k: u32) -> Self {
        Half::BOTH[(k % 2) as usize]
    }

    /// 0 or 1.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The sign of its passes in differences of the halves: 1 or -1.
    pub(super) fn sign(self) -> f32 {
        match self {
            Half::First => 1.0,
            Half::Second => -1.0,
        }
    }
}

/// Numbers of passes of both halves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfCounts(pub(super) [u32; 2]);

impl HalfCounts {
    /// Passes of one half.
    pub fn of(self, half: Half) -> u32 {
        self.0[half.index()]
    }

    /// Whether both halves have passes.
    pub fn are_both(self) -> bool {
        self.0.iter().all(|&count| count > 0)
    }

    /// The parts of all passes that are in the halves.
    pub(super) fn shares(self) -> [f32; 2] {
        let passes = self.0.iter().sum::<u32>() as f32;
        self.0.map(|count| count as f32 / passes)
    }

    pub(super) fn add(&mut self, other: HalfCounts) {
        for (count, other) in self.0.iter_mut().zip(other.0) {
            *count += other;
        }
    }

    /// Variance of the mean over all passes, from their sum and the difference of the halves.
    /// Unbiased if passes are independent, or if both halves have as many.
    pub(super) fn variance(self, sum: [f64; 3], difference: [f64; 3]) -> [f64; 3] {
        let [first, second] = self.0.map(f64::from);
        let n = first + second;
        let correction = n * n / (4.0 * first * second);
        std::array::from_fn(|c| {
            let expected = sum[c] * (first - second) / n;
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

    /// Adds the pixels of another mean.
    pub(super) fn merge(&mut self, other: &MeanRatio) {
        self.sum = add(self.sum, other.sum);
        self.count = add(self.count, other.count);
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
        for passes in [2_u32, 3, 4, 7, 16] {
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
                let variance = HalfCounts([passes.div_ceil(2), passes / 2])
                    .variance([sum; 3], [difference; 3]);
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
        let (trials, passes) = (4000, 16_u32);
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
            estimated +=
                HalfCounts([passes.div_ceil(2), passes / 2]).variance([sum; 3], [difference; 3])[2];
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
