//! Code that is written once for one value and for sixteen: the operations, by number of lanes.

use crate::simd::{Isa, Outlined, Simd, SimdKernel, WIDE, Wide};
use std::fmt::Debug;

/// The number of lanes of [`Float`](super::Float) and the types made of it: [`One`], or sixteen in the vectors of an instruction
/// set. A value of an implementing type proves that the machine has the instructions.
///
/// Functions over it must be `inline(always)`, as all functions over vectors. Comparisons with NaN are false. If an argument is
/// NaN, minimum and maximum are the second argument.
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
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    fn copy_sign(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn not(self, m: Self::M) -> Self::M;
    fn bits(self, m: Self::M) -> u32;
    fn mask(self, bits: u32) -> Self::M;

    fn float_bits(self, x: Self::F) -> Self::U;
    fn floats_of_bits(self, x: Self::U) -> Self::F;
    fn add_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn sub_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn mul_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn and_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn xor_words(self, a: Self::U, b: Self::U) -> Self::U;
    fn shift_left(self, a: Self::U, bits: u32) -> Self::U;
    fn shift_right(self, a: Self::U, bits: u32) -> Self::U;
    fn equal_words(self, a: Self::U, b: Self::U) -> Self::M;
    fn select_words(self, m: Self::M, a: Self::U, b: Self::U) -> Self::U;

    fn gather_quads<'a, const N: usize>(
        self,
        row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[Self::F; 4]; N];

    /// Runs code in a separate function, shared by all callers.
    fn outline<K: Outlined>(self, kernel: K) -> K::Output;
}

/// Code that is compiled for each number of lanes.
pub(crate) trait LaneKernel {
    /// Result of the kernel.
    type Output;
    /// The body. Must be `inline(always)`.
    fn run<S: Width>(self, s: S) -> Self::Output;
}

/// Runs a kernel with sixteen lanes, or with one in the portable instruction set: large code over arrays becomes poor vector code, in much
/// time of the compiler.
#[inline]
pub(crate) fn run<K: LaneKernel>(isa: Isa, kernel: K) -> K::Output {
    match isa.run_in_vectors(InVectors(kernel)) {
        Ok(output) => output,
        Err(InVectors(kernel)) => kernel.run(One),
    }
}

struct InVectors<K>(K);

impl<K: LaneKernel> SimdKernel for InVectors<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> K::Output {
        self.0.run(Sixteen(isa.wide()))
    }
}

/// One lane: plain numbers.
#[derive(Clone, Copy, Debug)]
pub struct One;

/// Sixteen lanes in the vectors of an instruction set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sixteen<W>(pub(crate) W);

impl Width for One {
    const LANES: usize = 1;
    type F = f32;
    type M = bool;
    type U = u32;
    type Each<T: Copy> = [T; 1];

    #[inline(always)]
    fn each<T: Copy>(self, mut value: impl FnMut(usize) -> T) -> [T; 1] {
        [value(0)]
    }
    #[inline(always)]
    fn load(self, x: &[f32; 1]) -> f32 {
        x[0]
    }
    #[inline(always)]
    fn store(self, x: f32) -> [f32; 1] {
        [x]
    }
    #[inline(always)]
    fn load_words(self, x: &[u32; 1]) -> u32 {
        x[0]
    }
    #[inline(always)]
    fn store_words(self, x: u32) -> [u32; 1] {
        [x]
    }
    #[inline(always)]
    fn splat(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn splat_word(self, x: u32) -> u32 {
        x
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn div(self, a: f32, b: f32) -> f32 {
        a / b
    }
    #[inline(always)]
    fn min(self, a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    #[inline(always)]
    fn max(self, a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    #[inline(always)]
    fn abs(self, a: f32) -> f32 {
        a.abs()
    }
    #[inline(always)]
    fn sqrt(self, a: f32) -> f32 {
        a.sqrt()
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }
    #[inline(always)]
    fn copy_sign(self, a: f32, b: f32) -> f32 {
        a.copysign(b)
    }
    #[inline(always)]
    fn le(self, a: f32, b: f32) -> bool {
        a <= b
    }
    #[inline(always)]
    fn lt(self, a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn select(self, m: bool, a: f32, b: f32) -> f32 {
        if m { a } else { b }
    }
    #[inline(always)]
    fn and(self, a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(self, a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn not(self, m: bool) -> bool {
        !m
    }
    #[inline(always)]
    fn bits(self, m: bool) -> u32 {
        u32::from(m)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> bool {
        bits & 1 != 0
    }
    #[inline(always)]
    fn float_bits(self, x: f32) -> u32 {
        x.to_bits()
    }
    #[inline(always)]
    fn floats_of_bits(self, x: u32) -> f32 {
        f32::from_bits(x)
    }
    #[inline(always)]
    fn add_words(self, a: u32, b: u32) -> u32 {
        a.wrapping_add(b)
    }
    #[inline(always)]
    fn sub_words(self, a: u32, b: u32) -> u32 {
        a.wrapping_sub(b)
    }
    #[inline(always)]
    fn mul_words(self, a: u32, b: u32) -> u32 {
        a.wrapping_mul(b)
    }
    #[inline(always)]
    fn and_words(self, a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn xor_words(self, a: u32, b: u32) -> u32 {
        a ^ b
    }
    #[inline(always)]
    fn shift_left(self, a: u32, bits: u32) -> u32 {
        a << bits
    }
    #[inline(always)]
    fn shift_right(self, a: u32, bits: u32) -> u32 {
        a >> bits
    }
    #[inline(always)]
    fn equal_words(self, a: u32, b: u32) -> bool {
        a == b
    }
    #[inline(always)]
    fn select_words(self, m: bool, a: u32, b: u32) -> u32 {
        if m { a } else { b }
    }
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    fn gather_quads<'a, const N: usize>(
        self,
        mut row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[f32; 4]; N] {
        let quads = row(0);
        let mut out = [[0.0; 4]; N];
        for n in 0..N {
            out[n] = *quads[n];
        }
        out
    }
    #[inline(never)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        kernel.run()
    }
}

macro_rules! wide {
    ($($name:ident($($arg:ident: $ty:ty),*) -> $out:ty;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: $ty),*) -> $out {
            self.0.$name($($arg),*)
        }
    )*};
}

impl<W: Wide> Width for Sixteen<W> {
    const LANES: usize = WIDE;
    type F = W::F;
    type M = W::M;
    type U = W::U;
    type Each<T: Copy> = [T; WIDE];

    wide! {
        load(x: &[f32; WIDE]) -> W::F;
        store(x: W::F) -> [f32; WIDE];
        load_words(x: &[u32; WIDE]) -> W::U;
        store_words(x: W::U) -> [u32; WIDE];
        splat(x: f32) -> W::F;
        splat_word(x: u32) -> W::U;
        add(a: W::F, b: W::F) -> W::F;
        sub(a: W::F, b: W::F) -> W::F;
        mul(a: W::F, b: W::F) -> W::F;
        div(a: W::F, b: W::F) -> W::F;
        min(a: W::F, b: W::F) -> W::F;
        max(a: W::F, b: W::F) -> W::F;
        abs(a: W::F) -> W::F;
        sqrt(a: W::F) -> W::F;
        mul_add(a: W::F, b: W::F, c: W::F) -> W::F;
        copy_sign(a: W::F, b: W::F) -> W::F;
        le(a: W::F, b: W::F) -> W::M;
        lt(a: W::F, b: W::F) -> W::M;
        select(m: W::M, a: W::F, b: W::F) -> W::F;
        and(a: W::M, b: W::M) -> W::M;
        or(a: W::M, b: W::M) -> W::M;
        not(m: W::M) -> W::M;
        bits(m: W::M) -> u32;
        float_bits(x: W::F) -> W::U;
        floats_of_bits(x: W::U) -> W::F;
        add_words(a: W::U, b: W::U) -> W::U;
        sub_words(a: W::U, b: W::U) -> W::U;
        mul_words(a: W::U, b: W::U) -> W::U;
        and_words(a: W::U, b: W::U) -> W::U;
        xor_words(a: W::U, b: W::U) -> W::U;
        shift_left(a: W::U, bits: u32) -> W::U;
        shift_right(a: W::U, bits: u32) -> W::U;
        equal_words(a: W::U, b: W::U) -> W::M;
        select_words(m: W::M, a: W::U, b: W::U) -> W::U;
    }

    #[inline(always)]
    fn each<T: Copy>(self, mut value: impl FnMut(usize) -> T) -> [T; WIDE] {
        // Functions of the standard library over arrays are not always inlined.
        let mut all = [value(0); WIDE];
        for (i, element) in all.iter_mut().enumerate().skip(1) {
            *element = value(i);
        }
        all
    }

    #[inline(always)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        self.0.outline(kernel)
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> W::M {
        self.0.lanes(bits)
    }

    #[inline(always)]
    fn gather_quads<'a, const N: usize>(
        self,
        row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[W::F; 4]; N] {
        self.0.gather_quads(row)
    }
}
