//! Russian roulette before shadow rays: a light that adds little to all points of a group is
//! connected rarely, with more weight.

use super::Gather;
use super::points::{BATCHES, Batch};
use crate::color::Rgb;
use crate::lanes::{Float, LANES, LaneMask, Lanes, Lanes3, Mask, Sixteen};
use crate::sampling::rng::Pcg;

/// Lights before roulette begins: a mean over fewer lights says little. At 4 and 16 (2 passes of
/// 128 lights at 72x40, 2 seeds; Kitchen): pictures differ by at most 0.3 % (RMS).
const FIRST_LIGHTS: f32 = 8.0;

/// Roulette for the connections of a group of points, in the order of the lights.
///
/// The probability that a light is connected is common to the points, because their shadow rays are
/// traced together. It is the largest ratio, over the points, of the unshadowed light to
/// [`Gather::roulette`] times the mean over the lights so far.
///
/// A part of a light takes a shadow ray as a whole one does, so that its own light is compared. With
/// the light of all parts instead, 2 passes of five scenes took 1.03 times the time at an equal
/// error, in pixels and in blocks.
///
/// Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section
/// 10.4.1. Deviation: one probability for up to 64 points.
#[derive(Debug)]
pub(super) struct Roulette {
    /// As [`Gather::roulette`].
    threshold: f32,
    rng: Pcg,
    /// Unshadowed luminance so far, by batch.
    sums: [Lanes; BATCHES],
    /// Number of lights so far; a point that stands for a part of a light counts as that part.
    lights: f32,
}

impl Roulette {
    /// Before the first light; `None` without roulette.
    pub(super) fn of(gather: &Gather, batches: &[Batch]) -> Option<Self> {
        (gather.roulette > 0.0).then(|| Roulette {
            threshold: gather.roulette,
            // The random numbers of the points differ from pass to pass.
            rng: Pcg::new(u64::from(batches[0].u[0].to_bits())),
            sums: [[0.0; LANES]; BATCHES],
            lights: 0.0,
        })
    }

    /// Whether the shadow rays of a light, or of a part `weight` of one, to the points `lit` are
    /// traced; `values` are then divided by the probability.
    #[inline(always)]
    pub(super) fn survives<S: Sixteen>(
        &mut self,
        s: S,
        weight: f32,
        lit: [LaneMask; BATCHES],
        values: &mut [Lanes3; BATCHES],
    ) -> bool {
        self.lights += weight;
        let mut largest = Float::splat(s, 0.0);
        for (b, lit) in lit.into_iter().enumerate() {
            if lit != 0 {
                let lit = Mask::of_lanes(s, lit);
                let value = lit.select(values[b].colors(s).weighted_sum(Rgb::LUMINANCE), 0.0);
                let sum = Float::load(s, &self.sums[b]) + value;
                self.sums[b] = sum.store();
                largest = largest.max(lit.select(value / sum, 0.0));
            }
        }
        let largest = largest.store().into_iter().fold(0.0, f32::max);
        let survival = largest * self.lights / self.threshold;
        if survival >= 1.0 || self.lights <= FIRST_LIGHTS {
            return true;
        }
        if self.rng.next_f32() >= survival {
            return false;
        }
        for values in values {
            *values = Lanes3::of_colors(values.colors(s) * (1.0 / survival));
        }
        true
    }
}
