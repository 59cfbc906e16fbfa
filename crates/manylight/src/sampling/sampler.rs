//! The random numbers of one path.

use super::rng::{Pcg, mix};
use crate::math::Vec2;

/// What the numbers are for; each purpose has its own, so that adding one changes no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Camera paths, one index per pixel.
    Pixel = 1,
    /// Photon paths.
    Photon = 2,
    /// Importon paths.
    Importon = 3,
    /// Selection of virtual lights.
    Selection = 4,
    /// Everything else that a pass draws once.
    Pass = 5,
    /// Tests.
    Test = 6,
}

/// One pass of a render: what its random numbers are named after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// The seed of the render.
    pub seed: u64,
    /// Counts from 0.
    pub index: u32,
}

impl Pass {
    /// The random numbers of item `index` of `stream` in this pass.
    #[inline]
    pub fn sampler(self, stream: Stream, index: u64) -> Sampler {
        Sampler::new(self.seed, self.index, stream, index)
    }

    /// Two numbers of item `index`, uniform over renders, that fill the square evenly over passes. The spread over passes then
    /// overstates the variance of the mean, never understates it.
    pub fn spread_2d(self, stream: Stream, index: u64) -> Vec2 {
        self.spread_2d_in_parts(stream, index, 0, 1)
    }

    /// The same for part `k` of `parts` that the pass is divided into: all parts of all passes fill the square evenly.
    pub fn spread_2d_in_parts(self, stream: Stream, index: u64, k: u32, parts: u32) -> Vec2 {
        let start = Sampler::new(self.seed, u32::MAX, stream, index).next_2d();
        let step = u64::from(self.index) * u64::from(parts) + u64::from(k);
        Vec2::from(spread(start.to_array(), R2, step as u32))
    }
}

/// Steps of the recurrence in two and in three dimensions: powers of 1/g, where g² or g³ is 1 + 1/g.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
const R3: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_3,
];

/// Point `index` of an additive recurrence, whose points fill the cube evenly. With a random start each is uniform.
///
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
fn spread<const D: usize>(start: [f32; D], steps: [f64; D], index: u32) -> [f32; D] {
    let at = |k: usize| (f64::from(start[k]) + steps[k] * f64::from(index)).fract() as f32;
    std::array::from_fn(|k| at(k).min(1.0 - f32::EPSILON))
}

/// Triples of numbers, each uniform, that together fill the cube evenly; see [`Sampler::next_spread`].
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    start: [f32; 3],
}

impl Spread {
    /// One number, and two.
    #[inline]
    pub fn triple(&self, index: u32) -> (f32, Vec2) {
        let [a, b, c] = spread(self.start, R3, index);
        (a, Vec2::new(b, c))
    }
}

/// Uniform numbers in [0, 1) named by (seed, pass, stream, index): the same name gives the same numbers on any thread.
#[derive(Clone, Debug)]
pub struct Sampler {
    rng: Pcg,
}

impl Sampler {
    /// The sampler named by the four arguments.
    #[inline]
    pub fn new(seed: u64, pass: u32, stream: Stream, index: u64) -> Self {
        let key = mix(seed ^ mix((u64::from(pass) << 8) | stream as u64));
        Sampler {
            rng: Pcg::new(key.wrapping_add(mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)))),
        }
    }

    /// One number.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.rng.next_f32()
    }

    /// The start of many triples.
    #[inline]
    pub fn next_spread(&mut self) -> Spread {
        Spread {
            start: [self.next_1d(), self.next_1d(), self.next_1d()],
        }
    }

    /// Two numbers.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        Vec2::new(self.rng.next_f32(), self.rng.next_f32())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_triples_fill_the_cube_evenly() {
        let mut sampler = Sampler::new(5, 0, Stream::Test, 0);
        for _ in 0..20 {
            let numbers = sampler.next_spread();
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
    fn spread_numbers_fill_the_square_evenly() {
        for item in 0..20 {
            let mut cells = [0; 16];
            for index in 0..160 {
                let u = Pass { seed: 3, index }.spread_2d(Stream::Pixel, item);
                cells[(u.y * 4.0) as usize * 4 + (u.x * 4.0) as usize] += 1;
            }
            assert!(cells.iter().all(|c| (7..=13).contains(c)), "{cells:?}");
        }
    }
}
