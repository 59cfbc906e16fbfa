//! Vectors of eight or sixteen floats, with one implementation per instruction set.
//!
//! Kernels are generic over [`Simd`] and written once. [`Isa::run`] compiles them for each instruction set and calls the selected version. A
//! value of an implementing type proves that the machine has the instructions, so that its operations are safe to call. All
//! operations and kernels are `inline(always)`: only code inlined into a function with `target_feature` is compiled for the feature.
//! A kernel may also ignore the value and consist of plain loops, which the compiler then vectorizes.
//!
//! Only [`Floats::mul_add`] and [`Floats::mul_sub`] round differently between instruction sets. Kernels without them give the same bits in
//! all instruction sets.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
#[cfg(test)]
mod tests;

use portable::Portable;
use std::mem::MaybeUninit;
use std::sync::OnceLock;

/// The instruction set of this process. The first use selects the best, unless [`select_instruction_set`] has selected another.
static SELECTED: OnceLock<Isa> = OnceLock::new();

/// Selects the instruction set of this process by its name: `avx512`, `avx2` or `portable`. Renders by one instruction set have
/// equal bits on all machines that have it. Call it before the first scene is built.
///
/// # Errors
/// What was found and expected: the machine lacks these instructions, or the process uses others already.
pub fn select_instruction_set(name: &str) -> Result<(), String> {
    let available: Vec<Isa> = Instructions::available()
        .into_iter()
        .filter_map(Isa::new)
        .collect();
    let Some(&isa) = available.iter().find(|isa| isa.name() == name) else {
        let names: Vec<&str> = available.iter().map(|isa| isa.name()).collect();
        return Err(format!(
            "found '{name}', expected one of {}",
            names.join(", ")
        ));
    };
    let selected = SELECTED.get_or_init(|| isa).name();
    if selected != name {
        return Err(format!(
            "found '{name}', but this process uses {selected} already"
        ));
    }
    Ok(())
}

/// The instruction set that renders use in this process, such as `x86_64 avx512`. Another one may round otherwise.
pub fn instruction_set() -> String {
    format!("{} {}", std::env::consts::ARCH, Isa::best().name())
}

/// Number of lanes of narrow vectors.
pub(crate) const NARROW: usize = 8;

/// Number of lanes of wide vectors.
pub(crate) const WIDE: usize = 16;

/// Operations on vectors of `N` floats. Comparisons with NaN are false. If an argument is NaN, minimum and maximum are the second argument.
/// In masks of bits, bit `i` is lane `i`.
pub(crate) trait Floats<const N: usize>: Copy {
    /// Vector of `N` floats.
    type F: Copy;
    /// Mask of `N` lanes.
    type M: Copy;
    /// Vector of `N` 32-bit words.
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
    /// `a b + c`, rounded once if the instruction set has fused operations, else twice.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a b - c`, rounded like [`Floats::mul_add`].
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a` with the sign bit inverted in lanes with a set sign bit of `b`.
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn bits(self, m: Self::M) -> u32;
    /// The inverse of [`Floats::bits`].
    fn lanes(self, bits: u32) -> Self::M;
    /// `a` in the lanes of `m`, `b` elsewhere.
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// The lanes with set bits, in ascending order; the rest is unspecified.
    fn compress(self, bits: u32, x: Self::F) -> [f32; N];
    /// [`Floats::compress`] for words.
    fn compress_words(self, bits: u32, x: Self::U) -> [u32; N];
}

/// Operations on wide vectors. Words are unsigned, and their arithmetic wraps.
pub(crate) trait Wide: Floats<16> + std::fmt::Debug {
    /// The first lane with the lowest value among those with set bits. At least one bit must be set.
    fn lowest(self, bits: u32, x: Self::F) -> u32;
    /// `a` with the sign of `b`.
    fn copy_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn not(self, m: Self::M) -> Self::M;
    /// The bits of floats.
    fn float_bits(self, x: Self::F) -> Self::U;
    /// The inverse of [`Wide::float_bits`].
    fn floats_of_bits(self, x: Self::U) -> Self::F;
    fn splat_word(self, x: u32) -> Self::U;
    fn store_words(self, x: Self::U) -> [u32; 16];
    fn add_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn sub_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn mul_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn and_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn xor_words(self, a: Self::U, b: Self::U) -> Self::U;
    /// All words shifted to the left by `bits` < 32.
    fn shift_left(self, a: Self::U, bits: u32) -> Self::U;
    /// All words shifted to the right by `bits` < 32; zeros come in.
    fn shift_right(self, a: Self::U, bits: u32) -> Self::U;
    fn equal_words(self, a: Self::U, b: Self::U) -> Self::M;
    /// `a` in the lanes of `m`, `b` elsewhere.
    fn select_words(self, m: Self::M, a: Self::U, b: Self::U) -> Self::U;
    /// Runs code in a separate function, compiled for this instruction set.
    fn outline<K: Outlined>(self, kernel: K) -> K::Output;
    /// Transposes rows in memory, one per lane, of `N` times four floats: element `[n][k]` of the result has number `k` of `row(i)[n]` in each
    /// lane `i`. The lanes are asked for in ascending order.
    fn gather_quads<'a, const N: usize>(
        self,
        row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[Self::F; 4]; N];
}

/// The narrow and the wide vectors of one instruction set.
pub(crate) trait Simd: Floats<8> {
    /// Operations on wide vectors.
    type Wide: Wide;

    /// Operations on wide vectors.
    fn wide(self) -> Self::Wide;
    /// Selects the lanes with near <= far, `span` being (near, far). Writes their words and near values in the order `order`, three bits per
    /// place. Returns the selected places as bits; as many entries are initialized as bits are set.
    fn compress_ordered(
        self,
        order: u32,
        words: &[u32; NARROW],
        span: (Self::F, Self::F),
        words_out: &mut [MaybeUninit<u32>; NARROW],
        near_out: &mut [MaybeUninit<f32>; NARROW],
    ) -> u32;
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

/// Code that is compiled for each instruction set.
pub(crate) trait SimdKernel {
    /// Result of the kernel.
    type Output;
    /// The body. Must be `inline(always)`, like all functions that get `s`.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// Code that is compiled once for each type, instead of once for each caller: large code with several callers.
pub trait Outlined {
    /// Result of the code.
    type Output;
    /// The body. Must be `inline(always)`.
    fn run(self) -> Self::Output;
}

/// Instruction sets for which kernels are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Instructions of every machine of the target.
    Portable,
    /// AVX2 and FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl Instructions {
    /// The instruction sets of this machine, the best first.
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

/// A selected instruction set, with the proof that the machine has it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Isa {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl Isa {
    /// `None` if the machine lacks the instructions.
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

    /// The instruction set of this process: the best of this machine, unless another was selected.
    pub(crate) fn best() -> Isa {
        *SELECTED.get_or_init(|| {
            Isa::new(Instructions::Avx512)
                .or_else(|| Isa::new(Instructions::Avx2))
                .unwrap_or(Isa::Portable)
        })
    }

    fn name(self) -> &'static str {
        match self {
            Isa::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(_) => "avx512",
        }
    }

    /// Runs a kernel in vectors, or returns it if this instruction set has none.
    #[inline]
    pub(crate) fn run_in_vectors<K: SimdKernel>(self, kernel: K) -> Result<K::Output, K> {
        match self {
            Isa::Portable => Err(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => Ok(avx2.run(kernel)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => Ok(avx512.run(kernel)),
        }
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
