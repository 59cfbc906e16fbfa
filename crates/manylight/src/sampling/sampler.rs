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

    /// Two numbers of item `index`, uniform over renders, that fill the square evenly over passes: an additive recurrence with a
    /// random start per item. The spread over passes then overstates the variance of the mean, never understates it.
    ///
    /// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018: the R2 sequence.
    pub fn spread_2d(self, stream: Stream, index: u64) -> Vec2 {
        const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
        let start = Sampler::new(self.seed, u32::MAX, stream, index).next_2d();
        let at = |start: f32, step: f64| {
            (f64::from(start) + step * f64::from(self.index)).fract() as f32
        };
        Vec2::new(at(start.x, STEP[0]), at(start.y, STEP[1])).min(Vec2::splat(1.0 - f32::EPSILON))
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
