//! Variance of means over many pixels, from batches of passes.
//!
//! Passes of one batch may be correlated, batches are independent. `S_b` is the sum of a value over
//! the `n_b` passes of batch `b`. The mean over all passes is the ratio `Σ S_b / Σ n_b`; its
//! variance is that of ratio estimators (Cochran, "Sampling Techniques", 3rd ed., sections 6.4 and
//! 9A.1) with a correction that makes it unbiased for independent passes:
//!
//! ```text
//! var m ≈ Σ_b (S_b - n_b m)² / (n² - Σ_b n_b²),   m = Σ S_b / n,   n = Σ n_b
//! ```

use crate::simd::array;

/// Number and sizes of the completed batches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BatchCounts {
    count: u32,
    passes: u32,
    /// Σ n_b²
    squares: f64,
}

/// Sums over batches, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BatchMoments {
    /// Σ S_b
    sum: [f64; 3],
    /// Σ S_b²
    squares: [f64; 3],
    /// Σ n_b S_b
    weighted: [f64; 3],
}

impl BatchCounts {
    /// Number of batches.
    pub(super) fn count(self) -> u32 {
        self.count
    }

    /// Number of passes in all batches.
    pub(super) fn passes(self) -> u32 {
        self.passes
    }

    /// Whether every batch has one pass.
    pub(super) fn are_single_passes(self) -> bool {
        self.count == self.passes
    }

    /// Adds a batch of `passes` passes.
    pub(super) fn add(&mut self, passes: u32) {
        self.count += 1;
        self.passes += passes;
        self.squares += f64::from(passes).powi(2);
    }

    /// Count, passes, and sum of squared passes.
    pub(super) fn to_array(self) -> [f64; 3] {
        [f64::from(self.count), f64::from(self.passes), self.squares]
    }

    /// The inverse of [`BatchCounts::to_array`].
    pub(super) fn from_array([count, passes, squares]: [f64; 3]) -> Self {
        BatchCounts {
            count: count as u32,
            passes: passes as u32,
            squares,
        }
    }

    /// Adds the batches of later passes.
    pub(super) fn merge(&mut self, later: BatchCounts) {
        self.count += later.count;
        self.passes += later.passes;
        self.squares += later.squares;
    }

    /// Variance of the mean over passes; infinite with fewer than two batches.
    pub(super) fn variance_of_mean(self, moments: &BatchMoments) -> [f64; 3] {
        if self.count < 2 {
            return [f64::INFINITY; 3];
        }
        let n = f64::from(self.passes);
        std::array::from_fn(|c| {
            let m = moments.sum[c] / n;
            let spread = moments.squares[c] - 2.0 * m * moments.weighted[c] + m * m * self.squares;
            spread.max(0.0) / (n * n - self.squares)
        })
    }
}

impl BatchMoments {
    /// Adds a batch of `passes` passes; `sum` is the sum of the values over them.
    pub(super) fn add(&mut self, passes: u32, sum: [f64; 3]) {
        for (c, s) in sum.into_iter().enumerate() {
            self.sum[c] += s;
            self.squares[c] += s * s;
            self.weighted[c] += f64::from(passes) * s;
        }
    }

    /// Sums of `S`, `S²` and `n S`, per channel.
    pub(super) fn to_array(self) -> [f64; 9] {
        let rows = [self.sum, self.squares, self.weighted];
        std::array::from_fn(|i| rows[i / 3][i % 3])
    }

    /// The inverse of [`BatchMoments::to_array`], from nine values.
    pub(super) fn from_slice(values: &[f64]) -> Self {
        let row = |r: usize| std::array::from_fn(|c| values[3 * r + c]);
        BatchMoments {
            sum: row(0),
            squares: row(1),
            weighted: row(2),
        }
    }

    /// Adds the moments of later batches.
    pub(super) fn merge(&mut self, later: &BatchMoments) {
        self.sum = add(self.sum, later.sum);
        self.squares = add(self.squares, later.squares);
        self.weighted = add(self.weighted, later.weighted);
    }
}

/// Sum by channel.
#[inline]
pub(super) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    array(|c| a[c] + b[c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    /// The estimate is unbiased for independent passes in batches of growing size.
    #[test]
    fn exact_for_independent_passes_in_batches_of_any_size() {
        let sizes = [1, 1, 2, 4, 8, 8];
        let mut rng = Pcg::new(21);
        let trials = 40_000;
        let (mut estimated, mut actual) = (0.0, 0.0);
        for _ in 0..trials {
            let (mut counts, mut moments) = (BatchCounts::default(), BatchMoments::default());
            let mut total = 0.0;
            for passes in sizes {
                let sum: f64 = (0..passes).map(|_| f64::from(rng.next_f32())).sum();
                counts.add(passes);
                moments.add(passes, [sum; 3]);
                total += sum;
            }
            estimated += counts.variance_of_mean(&moments)[1];
            actual += (total / 24.0 - 0.5).powi(2);
        }
        assert!(
            (estimated / actual - 1.0).abs() < 0.03,
            "{estimated} for {actual}"
        );
        let expected = f64::from(trials) / (12.0 * 24.0);
        assert!(
            (estimated / expected - 1.0).abs() < 0.02,
            "{estimated} for {expected}"
        );
    }
}
