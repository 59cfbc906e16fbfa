//! The kernels' operations in AVX-512.
#![allow(
    unsafe_code,
    reason = "vendor intrinsics; every kernel is tested against brute force in each instruction set"
)]

use super::lanes::{Kernel, Lanes, WIDTH};
use std::arch::x86_64::*;

/// Proof that the machine has AVX-512 and the bit counting of the same age: [`Avx512::detect`] is the only way to get one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx512(());

impl Avx512 {
    /// The proof, if it can be had.
    pub(super) fn detect() -> Option<Self> {
        let bits = is_x86_feature_detected!("bmi1") && is_x86_feature_detected!("popcnt");
        (is_x86_feature_detected!("avx512f") && bits).then_some(Avx512(()))
    }

    /// Runs a kernel compiled for these instructions.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: `self` exists only where `detect` found all that `run` enables.
        unsafe { run(self, kernel) }
    }
}

#[target_feature(enable = "avx512f,bmi1,popcnt")]
fn run<K: Kernel>(avx512: Avx512, kernel: K) -> K::Output {
    kernel.run(avx512)
}

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $ty:ty),*) -> $out:ty = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: $ty),*) -> $out {
            // SAFETY: `self` proves AVX-512, and register arithmetic has no other condition.
            unsafe { $body }
        }
    )*};
}

impl Lanes for Avx512 {
    type F = __m512;

    intrinsics! {
        splat(x: f32) -> __m512 = _mm512_set1_ps(x);
        add(a: __m512, b: __m512) -> __m512 = _mm512_add_ps(a, b);
        sub(a: __m512, b: __m512) -> __m512 = _mm512_sub_ps(a, b);
        mul(a: __m512, b: __m512) -> __m512 = _mm512_mul_ps(a, b);
        max(a: __m512, b: __m512) -> __m512 = _mm512_max_ps(a, b);
        le(a: __m512, b: __m512) -> u32 = u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b));
    }

    #[inline(always)]
    fn load(self, x: &[f32; WIDTH]) -> __m512 {
        // SAFETY: `self` proves AVX-512; the array is sixteen readable floats, and the load needs no alignment.
        unsafe { _mm512_loadu_ps(x.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, x: __m512) -> [f32; WIDTH] {
        let mut out = [0.0; WIDTH];
        // SAFETY: `self` proves AVX-512; the array is sixteen writable floats, and the store needs no alignment.
        unsafe { _mm512_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn compress(self, mask: u32, x: __m512) -> [f32; WIDTH] {
        // SAFETY: `self` proves AVX-512.
        self.store(unsafe { _mm512_maskz_compress_ps(mask as u16, x) })
    }

    #[inline(always)]
    fn compress_index(self, mask: u32, x: &[u32; WIDTH]) -> [u32; WIDTH] {
        let mut out = [0; WIDTH];
        // SAFETY: `self` proves AVX-512; both arrays are sixteen words, and neither access needs alignment.
        unsafe {
            let x = _mm512_loadu_si512(x.as_ptr().cast());
            let packed = _mm512_maskz_compress_epi32(mask as u16, x);
            _mm512_storeu_si512(out.as_mut_ptr().cast(), packed);
        }
        out
    }

    #[inline(always)]
    fn lowest(self, mask: u32, x: __m512) -> u32 {
        // SAFETY: `self` proves AVX-512.
        let equal = unsafe {
            let lowest = _mm512_mask_reduce_min_ps(mask as u16, x);
            _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(mask as u16, x, _mm512_set1_ps(lowest))
        };
        equal.trailing_zeros()
    }
}
