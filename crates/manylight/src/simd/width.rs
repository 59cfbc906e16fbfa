//! What every instruction set has: the operations on its lanes, and the code that is compiled for
//! it.

use std::fmt::Debug;
use std::mem::MaybeUninit;

/// Number of lanes of wide vectors.
pub const LANES: usize = 16;

/// Number of lanes of narrow vectors.
pub(crate) const NARROW: usize = 8;

/// A number of lanes, and the operations on that many values: [`One`](super::One), or eight or
/// sixteen in the vectors of an instruction set. A value of an implementing type proves that the
/// machine has the instructions.
///
/// Functions over it must be `inline(always)`: only code inlined into a function with the
/// instructions is compiled for them. Comparisons with NaN are false. If an argument is NaN,
/// minimum and maximum are the second argument. Words are unsigned, and their arithmetic wraps. In
/// masks of bits, bit `i` is lane `i`.
///
/// Only [`Width::mul_add`] and [`Width::mul_sub`] round differently between instruction sets. Code
/// without them gives the same bits in all instruction sets.
#[allow(missing_docs, reason = "the names are those of the operations")]
pub trait Width: Copy + Debug {
    /// Number of lanes.
    const LANES: usize;
    /// A float per lane.
    type F: Copy;
    /// A truth value per lane.
    type M: Copy;
    /// A 32-bit word per lane.
    type U: Copy;
    /// Any value per lane.
    type Each<T: Copy>: Copy + AsRef<[T]> + AsMut<[T]>;

    /// `value(i)` in each lane `i`.
    fn each<T: Copy>(self, value: impl FnMut(usize) -> T) -> Self::Each<T>;
    fn load(self, x: &Self::Each<f32>) -> Self::F;
    fn store(self, x: Self::F) -> Self::Each<f32>;
    fn load_words(self, x: &Self::Each<u32>) -> Self::U;
    fn store_words(self, x: Self::U) -> Self::Each<u32>;
    fn splat(self, x: f32) -> Self::F;
    fn splat_word(self, x: u32) -> Self::U;

    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn sqrt(self, a: Self::F) -> Self::F;
    /// `a b + c`, rounded once if the instruction set has fused operations, else twice.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a b - c`, rounded like [`Width::mul_add`].
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a` with the sign bit inverted in lanes with a set sign bit of `b`.
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a` with the sign of `b`.
    fn copy_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    /// `a` in the lanes of `m`, `b` elsewhere.
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn not(self, m: Self::M) -> Self::M;
    /// One bit per lane.
    fn bits(self, m: Self::M) -> u32;
    /// The inverse of [`Width::bits`].
    fn mask(self, bits: u32) -> Self::M;

    /// The bits of floats.
    fn float_bits(self, x: Self::F) -> Self::U;
    /// The inverse of [`Width::float_bits`].
    fn floats_of_bits(self, x: Self::U) -> Self::F;
    fn add_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn sub_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn mul_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn and_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn xor_words(self, a: Self::U, b: Self::U) -> Self::U;
    /// All words shifted to the left by `bits` < 32.
    fn shift_left(self, a: Self::U, bits: u32) -> Self::U;
    /// All words shifted to the right by `bits` < 32; zeros come in.
    fn shift_right(self, a: Self::U, bits: u32) -> Self::U;
    /// The words with their bits in reverse order.
    fn reverse_bits(self, a: Self::U) -> Self::U;
    fn equal_words(self, a: Self::U, b: Self::U) -> Self::M;
    fn select_words(self, m: Self::M, a: Self::U, b: Self::U) -> Self::U;

    /// The lanes with set bits, in ascending order; the rest is unspecified.
    #[inline(always)]
    fn compress(self, bits: u32, x: Self::F) -> Self::Each<f32> {
        compress::<Self, f32>(bits, self.store(x))
    }

    /// [`Width::compress`] for words.
    #[inline(always)]
    fn compress_words(self, bits: u32, x: Self::U) -> Self::Each<u32> {
        compress::<Self, u32>(bits, self.store_words(x))
    }

    /// The first lane with the lowest value among those with set bits. At least one bit must be
    /// set.
    #[inline(always)]
    fn lowest(self, bits: u32, x: Self::F) -> u32 {
        let x = self.store(x);
        let x = x.as_ref();
        let first = bits.trailing_zeros() as usize;
        set_bits(bits).fold(first, |best, i| if x[i] < x[best] { i } else { best }) as u32
    }

    /// Transposes rows in memory, one per lane, of `N` times four floats: element `[n][k]` of the
    /// result has number `k` of `row(i)[n]` in each lane `i`. The lanes are asked for in ascending
    /// order.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    fn gather_quads<'a, const N: usize>(
        self,
        row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[Self::F; 4]; N] {
        let rows = self.each(row);
        let mut out = [[self.splat(0.0); 4]; N];
        for n in 0..N {
            for k in 0..4 {
                out[n][k] = self.load(&self.each(|i| rows.as_ref()[i][n][k]));
            }
        }
        out
    }

    /// Runs code in a separate function, compiled for these instructions and shared by all callers.
    fn outline<K: Outlined>(self, kernel: K) -> K::Output;
}

/// Sixteen lanes, in every instruction set.
pub(crate) trait Sixteen: Width<Each<f32> = [f32; LANES], Each<u32> = [u32; LANES]> {}

impl<S: Width<Each<f32> = [f32; LANES], Each<u32> = [u32; LANES]>> Sixteen for S {}

/// An instruction set: its vectors of eight lanes, with which the ray tree is traversed, and those
/// of sixteen.
pub(crate) trait Simd: Width<Each<f32> = [f32; NARROW], Each<u32> = [u32; NARROW]> {
    /// Sixteen lanes.
    type Wide: Sixteen;

    /// Sixteen lanes.
    fn wide(self) -> Self::Wide;
    /// Selects the lanes with near <= far, `span` being (near, far). Writes their words and near
    /// values in the order `order`, three bits per place. Returns the selected places as bits; as
    /// many entries are initialized as bits are set.
    fn compress_ordered(
        self,
        order: u32,
        words: &[u32; NARROW],
        span: (Self::F, Self::F),
        words_out: &mut [MaybeUninit<u32>; NARROW],
        near_out: &mut [MaybeUninit<f32>; NARROW],
    ) -> u32;
}

/// Code that is compiled for each instruction set: with vectors in every one.
pub(crate) trait SimdKernel {
    /// Result of the kernel.
    type Output;
    /// The body. Must be `inline(always)`, like all functions that get `s`.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// Code that is compiled for one lane and for sixteen: with plain numbers in the portable
/// instruction set, because large code over arrays becomes poor vector code, in much time of the
/// compiler.
pub(crate) trait LaneKernel {
    /// Result of the kernel.
    type Output;
    /// The body. Must be `inline(always)`.
    fn run<S: Width>(self, s: S) -> Self::Output;
}

/// Code that is compiled once for each type, instead of once for each caller: large code with
/// several callers.
pub trait Outlined {
    /// Result of the code.
    type Output;
    /// The body. Must be `inline(always)`.
    fn run(self) -> Self::Output;
}

/// Positions of the set bits, ascending.
#[inline(always)]
pub(crate) fn set_bits(bits: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut bits: u64 = bits.into();
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (bit < u64::BITS).then_some(bit as usize)
    })
}

/// `value(i)` at each index, asked for once in ascending order. Functions of the standard library
/// over arrays are not always inlined.
#[inline(always)]
pub(crate) fn array<T: Copy, const N: usize>(mut value: impl FnMut(usize) -> T) -> [T; N] {
    let mut all = [value(0); N];
    for (i, element) in all.iter_mut().enumerate().skip(1) {
        *element = value(i);
    }
    all
}

#[inline(always)]
fn compress<S: Width, T: Copy>(bits: u32, mut x: S::Each<T>) -> S::Each<T> {
    let all = x.as_mut();
    for (place, i) in set_bits(bits & (u32::MAX >> (32 - S::LANES))).enumerate() {
        all[place] = all[i];
    }
    x
}
