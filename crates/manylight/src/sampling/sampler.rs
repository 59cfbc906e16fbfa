//! Random numbers of paths and passes, by seed, pass, stream and index.

use super::rng::{Pcg, mix};
use super::sobol;
use crate::lanes::{Float, LaneKernel, Width, Word};
use crate::math::Vec2;
use crate::simd::Isa;

/// Purpose of random numbers. Each purpose has a separate stream, so that a new purpose does not
/// change the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Camera paths. One index per pixel.
    Pixel = 1,
    /// Photon paths.
    Photon = 2,
    /// Importon paths.
    Importon = 3,
    /// Selection of virtual lights among the photons.
    Selection = 4,
    /// Other numbers that a pass draws once.
    Pass = 5,
    /// Tests.
    Test = 6,
    /// Division of the virtual lights among passes and pixels.
    Subsets = 7,
    /// The subset of the lights that gather points of low weight start with.
    SparseSubsets = 8,
    /// Photons that become points of the radiance cache. One index for all.
    CachePoints = 9,
    /// Shift of the tiles.
    Tiling = 10,
    /// Camera rays that estimate the mean sum over virtual lights. One index per ray.
    ToleranceProbe = 11,
    /// Pixels of the pre-pass of effort.
    EffortPixels = 12,
    /// Direct light at importons. One index per importon.
    DirectLight = 13,
}

/// One pass of a render: the key of its random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Seed of the render.
    pub seed: u64,
    /// Index of the pass, from 0.
    pub index: u32,
}

impl Pass {
    /// The sampler of item `index` of `stream` in this pass.
    #[inline]
    pub fn sampler(self, stream: Stream, index: u64) -> Sampler {
        Sampler::new(self.seed, self.index, stream, index)
    }

    /// The sequences of item `index` of `stream`: even passes continue some, odd passes others, so
    /// that the variance of means over passes can be estimated. After 2¹⁷ passes new ones begin.
    #[inline]
    pub(crate) fn sobol_sequences(self, stream: Stream, index: u64) -> SobolSequences {
        let (half, number) = (self.index & 1, self.index >> 1);
        let start = u32::MAX - (2 * (number >> sobol::SEQUENCE_BITS) + half);
        SobolSequences {
            key: Sampler::new(self.seed, start, stream, index).rng.next_u32(),
            index: number & ((1 << sobol::SEQUENCE_BITS) - 1),
        }
    }

    /// A point in [0, 1)² of item `index`: uniform over seeds, and over passes a low-discrepancy
    /// sequence. The sample variance over passes therefore overestimates the variance of their
    /// mean.
    pub fn low_discrepancy_2d(self, stream: Stream, index: u64) -> Vec2 {
        self.low_discrepancy_2d_in_parts(stream, index, 0, 1)
    }

    /// [`Pass::low_discrepancy_2d`] with `parts` points per pass: point `k` of the pass. The points
    /// of all passes form one sequence.
    pub fn low_discrepancy_2d_in_parts(
        self,
        stream: Stream,
        index: u64,
        k: u32,
        parts: u32,
    ) -> Vec2 {
        let start = Sampler::new(self.seed, u32::MAX, stream, index).next_2d();
        let step = u64::from(self.index) * u64::from(parts) + u64::from(k);
        Vec2::from(additive_recurrence(start.to_array(), R2, step as u32))
    }
}

/// Sequences of points in [0, 1)⁴ over the passes of an item: Owen-scrambled Sobol' points. Those
/// of different items, and different sequences of an item, are independent. The sample variance
/// over passes overestimates the variance of their mean; the difference of two halves of the passes
/// ([`Half`](crate::film::Half)), each with its own sequences, does not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SobolSequences {
    key: u32,
    index: u32,
}

impl SobolSequences {
    /// The points of this pass in sequence `sequence` of each lane: four numbers per lane.
    #[inline(always)]
    pub(crate) fn points<S: Width>(
        s: S,
        sequences: &S::Each<SobolSequences>,
        sequence: u32,
    ) -> [Float<S>; 4] {
        let key = Word::load(s, &s.each(|i| sequences.as_ref()[i].key));
        let index = Word::load(s, &s.each(|i| sequences.as_ref()[i].index));
        // An odd multiple of the golden ratio: the keys of an item differ in many bits.
        sobol::points(key ^ sequence.wrapping_mul(0x9e37_79b9), index)
    }

    /// The points of this pass in sequence `sequence` of each of `all`.
    pub(crate) fn each_point(all: &[SobolSequences], sequence: u32) -> Vec<[f32; 4]> {
        Isa::best().run_lanes(EachPoint { all, sequence })
    }
}

/// See [`SobolSequences::each_point`].
struct EachPoint<'a> {
    all: &'a [SobolSequences],
    sequence: u32,
}

impl LaneKernel for EachPoint<'_> {
    type Output = Vec<[f32; 4]>;

    #[inline(always)]
    fn run<S: Width>(self, s: S) -> Vec<[f32; 4]> {
        let mut points = Vec::with_capacity(self.all.len());
        for chunk in self.all.chunks(S::LANES) {
            let sequences = s.each(|i| chunk[i.min(chunk.len() - 1)]);
            let [x, y, z, w] = SobolSequences::points(s, &sequences, self.sequence);
            let (x, y, z, w) = (x.store(), y.store(), z.store(), w.store());
            for i in 0..chunk.len() {
                points.push([x.as_ref()[i], y.as_ref()[i], z.as_ref()[i], w.as_ref()[i]]);
            }
        }
        points
    }
}

/// Steps of the R₂ sequence: 1/g and 1/g² with g³ = g + 1.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// Steps of the R₃ sequence: 1/g, 1/g² and 1/g³ with g⁴ = g + 1.
const R3: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_3,
];

/// Point `index` of an additive recurrence, a low-discrepancy sequence. Each point is uniform if
/// the start is.
///
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
fn additive_recurrence<const D: usize>(start: [f32; D], steps: [f64; D], index: u32) -> [f32; D] {
    let at = |k: usize| (f64::from(start[k]) + steps[k] * f64::from(index)).fract() as f32;
    std::array::from_fn(|k| at(k).min(1.0 - f32::EPSILON))
}

/// A low-discrepancy sequence of points in [0, 1)³: the R₃ sequence. With a random start each point
/// is uniform; see [`Sampler::next_sequence`].
#[derive(Clone, Copy, Debug)]
pub struct LowDiscrepancySequence {
    start: [f32; 3],
}

impl LowDiscrepancySequence {
    /// The sequence with point 0 at `start`, in [0, 1)³.
    #[inline]
    pub fn new(start: [f32; 3]) -> Self {
        LowDiscrepancySequence { start }
    }

    /// Point `index` of the sequence, as one number and a pair.
    #[inline]
    pub fn triple(&self, index: u32) -> (f32, Vec2) {
        let [a, b, c] = additive_recurrence(self.start, R3, index);
        (a, Vec2::new(b, c))
    }
}

/// A generator of uniform numbers in [0, 1), keyed by (seed, pass, stream, index): independent of
/// threads and order.
#[derive(Clone, Debug)]
pub struct Sampler {
    rng: Pcg,
}

impl Sampler {
    /// The sampler with this key.
    #[inline]
    pub fn new(seed: u64, pass: u32, stream: Stream, index: u64) -> Self {
        let key = mix(seed ^ mix((u64::from(pass) << 8) | stream as u64));
        Sampler {
            rng: Pcg::new(key.wrapping_add(mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)))),
        }
    }

    /// State and increment of the generator.
    #[inline(always)]
    pub(crate) fn parts(&self) -> (u64, u64) {
        self.rng.parts()
    }

    /// The inverse of [`Sampler::parts`].
    #[inline(always)]
    pub(crate) fn from_parts(state: u64, increment: u64) -> Self {
        Sampler {
            rng: Pcg::from_parts(state, increment),
        }
    }

    /// An independent generator: its key is two numbers of this one.
    #[inline]
    pub fn branch(&mut self) -> Self {
        let (high, low) = (self.rng.next_u32(), self.rng.next_u32());
        Sampler {
            rng: Pcg::new(u64::from(high) << 32 | u64::from(low)),
        }
    }

    /// The next number.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.rng.next_f32()
    }

    /// A low-discrepancy sequence with a random start: three numbers of the generator.
    #[inline]
    pub fn next_sequence(&mut self) -> LowDiscrepancySequence {
        LowDiscrepancySequence::new([self.next_1d(), self.next_1d(), self.next_1d()])
    }

    /// The next two numbers.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        Vec2::new(self.rng.next_f32(), self.rng.next_f32())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_fill_the_cube_evenly() {
        let mut sampler = Sampler::new(5, 0, Stream::Test, 0);
        for _ in 0..20 {
            let numbers = sampler.next_sequence();
            let mut cells = [0; 8];
            for index in 0..80 {
                let (a, b) = numbers.triple(index);
                cells[(a * 2.0) as usize * 4 + (b.y * 2.0) as usize * 2 + (b.x * 2.0) as usize] +=
                    1;
            }
            assert!(cells.iter().all(|c| (6..=14).contains(c)), "{cells:?}");
        }
    }

    #[test]
    fn points_of_passes_fill_the_square_evenly() {
        for item in 0..20 {
            let mut cells = [0; 16];
            for index in 0..160 {
                let u = Pass { seed: 3, index }.low_discrepancy_2d(Stream::Pixel, item);
                cells[(u.y * 4.0) as usize * 4 + (u.x * 4.0) as usize] += 1;
            }
            assert!(cells.iter().all(|c| (7..=13).contains(c)), "{cells:?}");
        }
    }
}
