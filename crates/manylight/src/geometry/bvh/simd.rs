//! Eight floats at a time, with one implementation per instruction set.
//!
//! Kernels are generic over [`Simd`] and written once; [`Isa::run`] compiles them for each instruction set and calls the
//! one that was chosen. The value of an implementing type is the proof that the machine has the instructions, so that
//! the operations themselves are safe to call. Everything here and in the kernels is `inline(always)`, because only what
//! is inlined into the function with `target_feature` is compiled for it.

use super::stack::Stack;

/// Lanes per vector.
pub(super) const LANES: usize = 8;

/// Operations on eight floats. Comparisons with NaN are false.
pub(super) trait Simd: Copy {
    /// Eight floats.
    type F: Copy;
    /// Eight truth values.
    type M: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; LANES]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; LANES];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a b + c`, with one rounding where the machine has it.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a b - c`, rounded like [`Simd::mul_add`].
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `a` with its sign turned where `b` is negative.
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Bit `i` is lane `i`.
    fn bits(self, m: Self::M) -> u32;
    /// Pushes the children in `hit` with their distances, in the order of `order` (three bits per place).
    fn push_ordered(
        self,
        stack: &mut Stack,
        children: &[u32; LANES],
        order: u32,
        near: Self::F,
        hit: Self::M,
    );
}

/// Plain Rust on arrays, for the compiler to vectorize as far as the target allows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

#[inline(always)]
fn map2<A: Copy, B: Copy, C>(a: [A; LANES], b: [B; LANES], f: impl Fn(A, B) -> C) -> [C; LANES] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl Simd for Portable {
    type F = [f32; LANES];
    type M = [bool; LANES];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [x; LANES]
    }
    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> Self::F {
        *x
    }
    #[inline(always)]
    fn store(self, x: Self::F) -> [f32; LANES] {
        x
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        std::array::from_fn(|i| a[i] * b[i] - c[i])
    }
    #[inline(always)]
    fn mul_sign(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| {
            f32::from_bits(a.to_bits() ^ (b.to_bits() & 0x8000_0000))
        })
    }
    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        map2(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        map2(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        map2(a, b, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        map2(a, b, |a, b| a | b)
    }
    #[inline(always)]
    fn bits(self, m: Self::M) -> u32 {
        m.iter()
            .rev()
            .fold(0, |bits, &lane| bits << 1 | u32::from(lane))
    }
    #[inline(always)]
    fn push_ordered(
        self,
        stack: &mut Stack,
        children: &[u32; LANES],
        order: u32,
        near: Self::F,
        hit: Self::M,
    ) {
        for place in 0..LANES {
            let i = (order >> (3 * place) & 7) as usize;
            if hit[i] {
                stack.push(children[i], near[i]);
            }
        }
    }
}

/// Code that is compiled once per instruction set.
pub(super) trait Kernel {
    /// What it computes.
    type Output;
    /// The body; must be `inline(always)`, like all it calls with `s`.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// The instruction set to use.
#[derive(Clone, Copy, Debug)]
pub(super) enum Isa {
    /// No assumption.
    Portable,
    /// AVX2 with FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2(super::avx2::Avx2),
}

impl Isa {
    /// All that this machine can run, the best first.
    pub(super) fn available() -> Vec<Isa> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        all.extend(super::avx2::Avx2::detect().map(Isa::Avx2));
        all.push(Isa::Portable);
        all
    }

    /// The best that this machine can run.
    pub(super) fn best() -> Isa {
        Isa::available()[0]
    }

    /// Runs a kernel.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run(kernel),
        }
    }
}
