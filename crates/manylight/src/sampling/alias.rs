//! Discrete sampling in constant time: alias tables.

use crate::math::float::ONE_MINUS_EPSILON;
use crate::math::prefetch::prefetch;
use rayon::prelude::*;

/// An alias table, after Walker.
///
/// Source: Vose, "A Linear Algorithm for Generating Random Numbers with a Given Distribution",
/// 1991.
#[derive(Clone, Debug, Default)]
pub struct Alias {
    slots: Vec<Slot>,
    pmf: Vec<f32>,
}

/// One column of the table: item `i` below the fraction `keep`, item `other` above.
#[derive(Clone, Copy, Debug)]
struct Slot {
    keep: f32,
    other: u32,
}

impl Alias {
    /// A table that samples item `i` with probability proportional to `weights[i] >= 0`. `None` if
    /// the sum of the weights is not positive and finite.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let n = weights.len();
        let mut scaled: Vec<f64> = weights
            .iter()
            .map(|&w| f64::from(w) * n as f64 / total)
            .collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&i| scaled[i] < 1.0);
        let heaviest = (0..n)
            .max_by(|&a, &b| weights[a].total_cmp(&weights[b]))
            .unwrap_or(0);
        let mut slots = vec![
            Slot {
                keep: 1.0,
                other: heaviest as u32
            };
            n
        ];
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            slots[s] = Slot {
                keep: scaled[s] as f32,
                other: l as u32,
            };
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // Rounding may leave small items over: they keep their slots, unless their weight is 0.
        for s in small.into_iter().filter(|&s| weights[s] == 0.0) {
            slots[s].keep = 0.0;
        }
        Some(Alias {
            slots,
            pmf: weights
                .iter()
                .map(|&w| (f64::from(w) / total) as f32)
                .collect(),
        })
    }

    /// A sampled item and its probability, for `u` in [0, 1). The table must not be empty.
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let x = u * self.slots.len() as f32;
        let i = (x as usize).min(self.slots.len() - 1);
        let slot = self.slots[i];
        let chosen = if x - (i as f32) < slot.keep {
            i
        } else {
            slot.other as usize
        };
        (chosen, self.pmf[chosen])
    }

    /// A sampled item and a new uniform number, the part of `u` that the choice leaves. Reads one
    /// cache line. The table must not be empty.
    #[inline]
    pub fn sample_reusing(&self, u: f32) -> (usize, f32) {
        choose(&self.slots, u)
    }

    /// Probability of item `i`.
    #[inline]
    pub fn pmf(&self, i: usize) -> f32 {
        self.pmf[i]
    }
}

/// The item for `u`, and the position of `u` within the interval of that item, uniform in [0, 1).
#[inline]
fn choose(slots: &[Slot], u: f32) -> (usize, f32) {
    let x = u * slots.len() as f32;
    let i = (x as usize).min(slots.len() - 1);
    let (slot, rest) = (slots[i], x - i as f32);
    if rest < slot.keep {
        (i, (rest / slot.keep).min(ONE_MINUS_EPSILON))
    } else {
        (
            slot.other as usize,
            ((rest - slot.keep) / (1.0 - slot.keep)).min(ONE_MINUS_EPSILON),
        )
    }
}

/// Alias tables over the rows of a matrix, in contiguous memory.
#[derive(Clone, Debug)]
pub struct AliasRows {
    width: usize,
    slots: Vec<Slot>,
}

impl AliasRows {
    /// One table per row of `width` weights. A row without positive weights must not be sampled.
    pub fn new(weights: &[f32], width: usize) -> Self {
        /// Slot of a row without weight.
        const NOTHING: Slot = Slot {
            keep: 1.0,
            other: 0,
        };
        let slots = weights
            .par_chunks_exact(width)
            .flat_map_iter(|row| {
                Alias::new(row).map_or_else(|| vec![NOTHING; width], |alias| alias.slots)
            })
            .collect();
        AliasRows { width, slots }
    }

    /// [`Alias::sample_reusing`] with the table of a row.
    #[inline]
    pub fn sample_reusing(&self, row: usize, u: f32) -> (usize, f32) {
        choose(&self.slots[row * self.width..][..self.width], u)
    }

    /// Prefetches the memory that [`AliasRows::sample_reusing`] reads.
    #[inline]
    pub fn prefetch(&self, row: usize, u: f32) {
        let column = ((u * self.width as f32) as usize).min(self.width - 1);
        prefetch(&self.slots[row * self.width + column]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_match_the_weights() {
        let weights = [1.0, 0.0, 3.0, 0.5, 5.5];
        let alias = Alias::new(&weights).unwrap();
        let n = 100_000;
        let mut counts = [0usize; 5];
        let mut rests = [0.0; 5];
        for i in 0..n {
            let u = (i as f32 + 0.5) / n as f32;
            let (k, p) = alias.sample(u);
            assert!((p - weights[k] / 10.0).abs() < 1e-6);
            counts[k] += 1;
            let (same, rest) = alias.sample_reusing(u);
            assert_eq!(same, k);
            rests[k] += f64::from(rest);
        }
        for (sum, count) in rests.iter().zip(counts) {
            assert!(count == 0 || (sum / count as f64 - 0.5).abs() < 1e-2);
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((*count as f32 / n as f32 - weight / 10.0).abs() < 1e-3);
        }
        assert!(Alias::new(&[0.0, 0.0]).is_none());
    }

    #[test]
    fn rows_equal_single_tables() {
        let weights = [1.0, 2.0, 5.0, 0.0, 0.0, 0.0, 3.0, 0.0, 1.0];
        let rows = AliasRows::new(&weights, 3);
        for row in [0, 2] {
            let alone = Alias::new(&weights[3 * row..][..3]).unwrap();
            for i in 0..1000 {
                let u = (i as f32 + 0.5) / 1000.0;
                rows.prefetch(row, u);
                assert_eq!(rows.sample_reusing(row, u), alone.sample_reusing(u));
            }
        }
    }
}
