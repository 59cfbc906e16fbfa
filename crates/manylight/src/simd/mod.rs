//! Eight or sixteen floats at a time, with one implementation per instruction set.
//!
//! Kernels are generic over [`Simd`] and written once; [`Isa::run`] compiles them for each instruction set and calls the
//! one that was chosen. The value of an implementing type is the proof that the machine has the instructions, so that
//! the operations themselves are safe to call. Everything here and in the kernels is `inline(always)`, because only what
//! is inlined into the function with `target_feature` is compiled for it. A kernel may also ignore the value, and be made
//! of plain loops that the compiler turns into these instructions.
//!
//! [`Floats::mul_add`] and [`Floats::mul_sub`] are all that rounds differently in different instruction sets. Kernels
//! without them give the same bits in all.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
#[cfg(test)]
mod tests;

use portable::Portable;
use std::mem::MaybeUninit;

/// Lanes of the narrow vectors.
pub(crate) const NARROW: usize = 8;

/// Lanes of the wide vectors.
pub(crate) const WIDE: usize = 16;

/// Operations on `N` floats. Comparisons with NaN are false; where either is NaN, minimum and maximum are the second argument.
/// Bit `i` of bits is lane `i`.
pub(crate) trait Floats<const N: usize>: Copy {
    /// The floats.
    type F: Copy;
    /// As many truth values.
    type M: Copy;
    /// As many words.
    type U: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; N]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; N];
    fn load_words(self, x: &[u32; N]) -> Self::U;
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn sqrt(self, a: Self::F) -> Self::F;
    /// `a b + c`, with one rounding where the machine has it.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a b - c`, rounded like [`Floats::mul_add`].
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a` with its sign turned where `b` is negative.
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn bits(self, m: Self::M) -> u32;
    /// The opposite of [`Floats::bits`].
    fn lanes(self, bits: u32) -> Self::M;
    /// `a` where `m` is true, else `b`.
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// The lanes whose bits are set, in rising order; what follows them is unspecified.
    fn compress(self, bits: u32, x: Self::F) -> [f32; N];
    /// The same for words.
    fn compress_words(self, bits: u32, x: Self::U) -> [u32; N];
}

/// Operations on wide vectors.
pub(crate) trait Wide: Floats<16> {
    /// The first lane with the lowest value among those whose bits are set, which is one at least.
    fn lowest(self, bits: u32, x: Self::F) -> u32;
}

/// The narrow and the wide vectors of one instruction set.
pub(crate) trait Simd: Floats<8> {
    /// Operations on wide vectors.
    type Wide: Wide;

    /// Operations on wide vectors.
    fn wide(self) -> Self::Wide;
    /// Writes the words and near values of the lanes whose `span` has near <= far, in the order of `order` (three bits per
    /// place), and returns which places these are: as many entries are initialized.
    fn compress_ordered(
        self,
        order: u32,
        words: &[u32; NARROW],
        span: (Self::F, Self::F),
        words_out: &mut [MaybeUninit<u32>; NARROW],
        near_out: &mut [MaybeUninit<f32>; NARROW],
    ) -> u32;
}

/// The positions of the set bits, lowest first.
#[inline(always)]
pub(crate) fn set_bits(bits: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut bits: u64 = bits.into();
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (bit < u64::BITS).then_some(bit as usize)
    })
}

/// Code that is compiled once per instruction set.
pub(crate) trait SimdKernel {
    /// What it computes.
    type Output;
    /// The body; must be `inline(always)`, like all it calls with `s`.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// Sets of instructions that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// What every machine has.
    Portable,
    /// AVX2 and FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl Instructions {
    /// All that this machine has, the best first.
    pub fn available() -> Vec<Instructions> {
        let all = [
            Instructions::Avx512,
            Instructions::Avx2,
            Instructions::Portable,
        ];
        all.into_iter()
            .filter(|&set| Isa::new(set).is_some())
            .collect()
    }
}

/// The instructions to use, with the proof that the machine has them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Isa {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl Isa {
    /// `None` if the machine lacks them.
    pub(crate) fn new(instructions: Instructions) -> Option<Isa> {
        match instructions {
            Instructions::Portable => Some(Isa::Portable),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => avx2::Avx2::detect().map(Isa::Avx2),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => avx512::Avx512::detect().map(Isa::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            Instructions::Avx2 | Instructions::Avx512 => None,
        }
    }

    /// The best that this machine can run. Cheap: the machine is asked only once.
    pub(crate) fn best() -> Isa {
        Isa::new(Instructions::Avx512)
            .or_else(|| Isa::new(Instructions::Avx2))
            .unwrap_or(Isa::Portable)
    }

    /// Runs a kernel.
    #[inline]
    pub(crate) fn run<K: SimdKernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => avx512.run(kernel),
        }
    }
}
