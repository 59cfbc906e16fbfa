//! Eight or sixteen floats at a time, with one implementation per instruction set.
//!
//! Kernels are generic over [`Simd`] and written once; [`Isa::run`] compiles them for each instruction set and calls the
//! one that was chosen. The value of an implementing type is the proof that the machine has the instructions, so that
//! the operations themselves are safe to call. Everything here and in the kernels is `inline(always)`, because only what
//! is inlined into the function with `target_feature` is compiled for it.

use super::portable::Portable;
use super::stack::Stack;
use std::mem::MaybeUninit;

/// Lanes of the narrow vectors: children of a node, triangles of a block.
pub(super) const LANES: usize = 8;

/// Lanes of the wide vectors.
pub(super) const WIDE: usize = 16;

/// Operations on `N` floats. Comparisons with NaN are false; the minimum or maximum of NaN and `b` is `b`.
pub(super) trait Lanes<const N: usize>: Copy {
    /// The floats.
    type F: Copy;
    /// As many truth values.
    type M: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; N]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; N];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    /// `a b + c`, with one rounding where the machine has it.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a b - c`, rounded like [`Lanes::mul_add`].
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a` with its sign turned where `b` is negative.
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Bit `i` is lane `i`.
    fn bits(self, m: Self::M) -> u32;
}

/// The narrow and the wide vectors of one instruction set.
pub(super) trait Simd: Lanes<8> {
    /// Operations on wide vectors.
    type Wide: Lanes<16>;

    /// Operations on wide vectors.
    fn wide(self) -> Self::Wide;
    /// Writes the words whose bits are set to the front of `out`, and anything behind them.
    fn compact(self, words: &[u32; LANES], bits: u32, out: &mut [MaybeUninit<u32>; LANES]);
    /// Pushes the children with near <= far and their near distances, in the order of `order` (three bits per place).
    fn push_ordered(
        self,
        stack: &mut Stack,
        children: &[u32; LANES],
        order: u32,
        near: Self::F,
        far: Self::F,
    );
}

/// Code that is compiled once per instruction set.
pub(super) trait Kernel {
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
pub(super) enum Isa {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(super::avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(super::avx512::Avx512),
}

impl Isa {
    /// `None` if the machine lacks them.
    pub(super) fn new(instructions: Instructions) -> Option<Isa> {
        match instructions {
            Instructions::Portable => Some(Isa::Portable),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => super::avx2::Avx2::detect().map(Isa::Avx2),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => super::avx512::Avx512::detect().map(Isa::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            Instructions::Avx2 | Instructions::Avx512 => None,
        }
    }

    /// The best that this machine can run.
    pub(super) fn best() -> Isa {
        Isa::new(Instructions::Avx512)
            .or_else(|| Isa::new(Instructions::Avx2))
            .unwrap_or(Isa::Portable)
    }

    /// Runs a kernel.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => avx512.run(kernel),
        }
    }
}
