//! Data-parallel code: one program for many values.
//!
//! [`Float`], [`Vector`] and [`Color`] have a number of lanes as a type parameter, a [`Width`]:
//! [`One`], or sixteen in the vectors of an instruction set (eight, too, in the ray tree). Code
//! over them is written once for all.
//!
//! Code that is not inlined gets vectors through memory and lacks the instructions, which costs a
//! factor of ten. Functions over lanes are therefore `inline(always)`; large or recursive ones are
//! declared by `outlined!`, and compiled once for each instruction set. Closures, iterators, and
//! the functions of arrays such as `map` and `from_fn` are not always inlined: they fit for single
//! lanes, not for vectors.
//!
//! Arrays of sixteen values are for loops over lanes, which the compiler turns into vector
//! instructions. For this a loop must be free of calls, early exits and saturating conversions.

mod choices;
mod functions;
mod groups;
mod numbers;
mod stored;
#[cfg(test)]
mod tests;
mod vector;

pub use crate::simd::{LANES, One, Width};
pub(crate) use crate::simd::{LaneKernel, Sixteen};
pub(crate) use choices::{power, sample_linear, sphere, split, triangle};
pub(crate) use functions::{cosine_hemisphere, cosine_hemisphere_pdf, disc};
pub(crate) use numbers::Stored;
pub use numbers::{Float, Mask, Operand, Word};
pub(crate) use stored::{CacheAligned, in_lanes, lanewise};
pub use vector::{Axes, Color, Pair, Vector};

use crate::color::Rgb;
use crate::math::Vec3;
use crate::simd::set_bits;

/// The three components in lane `i` of a stored [`Vector`] or [`Color`].
#[inline(always)]
pub(crate) fn lane<E: AsRef<[f32]>>([x, y, z]: &[E; 3], i: usize) -> [f32; 3] {
    [x.as_ref()[i], y.as_ref()[i], z.as_ref()[i]]
}

/// One value per lane.
pub type Lanes = [f32; LANES];

/// One bit per lane.
pub type LaneMask = u16;

/// The lanes for which `test` holds.
#[inline(always)]
pub fn mask(test: impl Fn(usize) -> bool) -> LaneMask {
    // Two loops: the compiler recognizes the second as a reduction.
    let mut bits = [0u32; LANES];
    for (i, bit) in bits.iter_mut().enumerate() {
        *bit = if test(i) { 1 << i } else { 0 };
    }
    bits.iter().fold(0, |all, bit| all | bit) as LaneMask
}

impl<S: Width> Mask<S> {
    /// The lanes of a mask in memory.
    #[inline(always)]
    pub(crate) fn of_lanes(s: S, lanes: LaneMask) -> Self {
        Mask::from_bits(s, u32::from(lanes))
    }
}

/// Indices of the set lanes of a mask, ascending.
#[inline(always)]
pub fn lanes_of(mask: LaneMask) -> impl Iterator<Item = usize> {
    set_bits(mask)
}

/// Three values per lane: a vector or a color. Indices: component, lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes3(pub [Lanes; 3]);

impl Lanes3 {
    /// Zero in all lanes.
    pub const ZERO: Lanes3 = Lanes3([[0.0; LANES]; 3]);

    /// The vector `value(i)` in each lane `i`.
    #[inline(always)]
    pub fn from_fn(value: impl Fn(usize) -> Vec3) -> Self {
        let mut all = Lanes3::ZERO;
        for i in 0..LANES {
            all.set(i, value(i));
        }
        all
    }

    /// The vector in lane `i`.
    #[inline(always)]
    pub fn vec(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    /// The color in lane `i`.
    #[inline(always)]
    pub fn rgb(&self, i: usize) -> Rgb {
        Rgb::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    /// All lanes as vectors.
    #[inline(always)]
    pub(crate) fn vectors<W: Sixteen>(&self, s: W) -> Vector<W> {
        Vector::load(s, &self.0)
    }

    /// All lanes as colors.
    #[inline(always)]
    pub(crate) fn colors<W: Sixteen>(&self, s: W) -> Color<W> {
        Color::load(s, &self.0)
    }

    /// From vectors.
    #[inline(always)]
    pub(crate) fn of_vectors<W: Sixteen>(vectors: Vector<W>) -> Self {
        Lanes3(vectors.store())
    }

    /// From colors.
    #[inline(always)]
    pub(crate) fn of_colors<W: Sixteen>(colors: Color<W>) -> Self {
        Lanes3(colors.store())
    }

    /// Sets lane `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, value: impl Into<[f32; 3]>) {
        let [x, y, z] = value.into();
        self.0[0][i] = x;
        self.0[1][i] = y;
        self.0[2][i] = z;
    }
}
