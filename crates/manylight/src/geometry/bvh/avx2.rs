//! The kernels' operations in AVX2 and FMA.
#![allow(
    unsafe_code,
    reason = "vendor intrinsics; every kernel is tested against the portable path"
)]

use super::simd::{Kernel, LANES, Lanes, Simd, WIDE};
use super::stack::Stack;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Proof that the machine has AVX2, FMA and the bit counting of the same age: [`Avx2::detect`] is the only way to get one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx2 {
    /// The proof, if it can be had.
    pub(super) fn detect() -> Option<Self> {
        let vectors = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let bits = is_x86_feature_detected!("bmi1") && is_x86_feature_detected!("popcnt");
        (vectors && bits).then_some(Avx2(()))
    }

    /// Runs a kernel compiled for these instructions.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: `self` exists only where `detect` found all that `run` enables.
        unsafe { run(self, kernel) }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,popcnt")]
fn run<K: Kernel>(avx2: Avx2, kernel: K) -> K::Output {
    kernel.run(avx2)
}

/// For each mask of eight bits, the positions of its set bits in rising order.
static COMPACT: [[u8; LANES]; 256] = compact();

const fn compact() -> [[u8; LANES]; 256] {
    let mut table = [[0; LANES]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < LANES {
            if mask >> bit & 1 == 1 {
                table[mask][count] = bit as u8;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
}

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            // SAFETY: `self` proves AVX2 and FMA, and register arithmetic has no other condition.
            unsafe { $body }
        }
    )*};
}

impl Lanes<LANES> for Avx2 {
    type F = __m256;
    type M = __m256;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> __m256 {
        // SAFETY: `self` proves AVX2; the array is eight readable floats, and the load needs no alignment.
        unsafe { _mm256_loadu_ps(x.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, x: __m256) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        // SAFETY: `self` proves AVX2; the array is eight writable floats, and the store needs no alignment.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    intrinsics! {
        add(a: F, b: F) -> F = _mm256_add_ps(a, b);
        sub(a: F, b: F) -> F = _mm256_sub_ps(a, b);
        mul(a: F, b: F) -> F = _mm256_mul_ps(a, b);
        div(a: F, b: F) -> F = _mm256_div_ps(a, b);
        min(a: F, b: F) -> F = _mm256_min_ps(a, b);
        max(a: F, b: F) -> F = _mm256_max_ps(a, b);
        abs(a: F) -> F = _mm256_andnot_ps(_mm256_set1_ps(-0.0), a);
        mul_add(a: F, b: F, c: F) -> F = _mm256_fmadd_ps(a, b, c);
        mul_sub(a: F, b: F, c: F) -> F = _mm256_fmsub_ps(a, b, c);
        mul_sign(a: F, b: F) -> F = _mm256_xor_ps(a, _mm256_and_ps(b, _mm256_set1_ps(-0.0)));
        le(a: F, b: F) -> M = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
        lt(a: F, b: F) -> M = _mm256_cmp_ps::<_CMP_LT_OQ>(a, b);
        and(a: M, b: M) -> M = _mm256_and_ps(a, b);
        or(a: M, b: M) -> M = _mm256_or_ps(a, b);
    }

    #[inline(always)]
    fn bits(self, m: __m256) -> u32 {
        // SAFETY: `self` proves AVX.
        unsafe { _mm256_movemask_ps(m) as u32 }
    }
}

macro_rules! in_halves {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            [
                <Self as Lanes<LANES>>::$name(self, $($arg[0]),*),
                <Self as Lanes<LANES>>::$name(self, $($arg[1]),*),
            ]
        }
    )*};
}

impl Lanes<WIDE> for Avx2 {
    type F = [__m256; 2];
    type M = [__m256; 2];

    #[inline(always)]
    fn splat(self, x: f32) -> [__m256; 2] {
        [<Self as Lanes<LANES>>::splat(self, x); 2]
    }

    #[inline(always)]
    fn load(self, x: &[f32; WIDE]) -> [__m256; 2] {
        let (halves, _) = x.as_chunks::<LANES>();
        [self.load(&halves[0]), self.load(&halves[1])]
    }

    #[inline(always)]
    fn store(self, x: [__m256; 2]) -> [f32; WIDE] {
        let mut out = [0.0; WIDE];
        let (halves, _) = out.as_chunks_mut::<LANES>();
        halves[0] = self.store(x[0]);
        halves[1] = self.store(x[1]);
        out
    }

    in_halves! {
        add(a: F, b: F) -> F;
        sub(a: F, b: F) -> F;
        mul(a: F, b: F) -> F;
        div(a: F, b: F) -> F;
        min(a: F, b: F) -> F;
        max(a: F, b: F) -> F;
        abs(a: F) -> F;
        mul_add(a: F, b: F, c: F) -> F;
        mul_sub(a: F, b: F, c: F) -> F;
        mul_sign(a: F, b: F) -> F;
        le(a: F, b: F) -> M;
        lt(a: F, b: F) -> M;
        and(a: M, b: M) -> M;
        or(a: M, b: M) -> M;
    }

    #[inline(always)]
    fn bits(self, m: [__m256; 2]) -> u32 {
        <Self as Lanes<LANES>>::bits(self, m[0]) | <Self as Lanes<LANES>>::bits(self, m[1]) << 8
    }
}

impl Simd for Avx2 {
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }

    #[inline(always)]
    fn compact(self, words: &[u32; LANES], bits: u32, out: &mut [MaybeUninit<u32>; LANES]) {
        // SAFETY: `self` proves AVX2; the row of `COMPACT` is eight readable bytes, the arrays are eight words.
        unsafe {
            let kept = COMPACT[bits as usize & 0xff].as_ptr();
            let kept = _mm256_cvtepu8_epi32(_mm_loadl_epi64(kept.cast()));
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let words = _mm256_permutevar8x32_epi32(words, kept);
            _mm256_storeu_si256(out.as_mut_ptr().cast(), words);
        }
    }

    #[inline(always)]
    fn push_ordered(
        self,
        stack: &mut Stack,
        children: &[u32; LANES],
        order: u32,
        near: __m256,
        far: __m256,
    ) {
        // SAFETY: `self` proves AVX2; `children` is eight readable words, the row of `COMPACT` eight readable bytes, and
        // `spare` gives room for eight entries.
        unsafe {
            let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
            let words = _mm256_loadu_si256(children.as_ptr().cast());
            let words = _mm256_permutevar8x32_epi32(words, order);
            let near = _mm256_permutevar8x32_ps(near, order);
            let far = _mm256_permutevar8x32_ps(far, order);
            let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as usize;
            // Out of the places in order, keep those that were hit.
            let kept = _mm256_cvtepu8_epi32(_mm_loadl_epi64(COMPACT[mask].as_ptr().cast()));
            let (child_out, near_out) = stack.spare();
            _mm256_storeu_si256(
                child_out.as_mut_ptr().cast(),
                _mm256_permutevar8x32_epi32(words, kept),
            );
            _mm256_storeu_ps(
                near_out.as_mut_ptr().cast(),
                _mm256_permutevar8x32_ps(near, kept),
            );
            stack.grow(mask.count_ones() as usize);
        }
    }
}
