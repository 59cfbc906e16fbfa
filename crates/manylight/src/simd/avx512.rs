//! Vector operations in AVX-512.
#![allow(
    unsafe_code,
    reason = "vendor intrinsics; every kernel is tested against the portable path"
)]

use super::avx2::{REVERSED_BYTES, REVERSED_HIGH_NIBBLES, REVERSED_LOW_NIBBLES};
use super::compiled::compiled_for;
use super::width::{LANES, LaneKernel, NARROW, Outlined, Simd, SimdKernel, Width, array};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Eight lanes; the proof that the machine has AVX-512 (F, VL, DQ, BW) and the older sets that
/// kernels enable. Only [`Avx512::detect`] creates one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(());

/// Sixteen lanes. Only [`Avx512::wide`] creates one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512Wide(());

impl Avx512 {
    /// The proof; `None` if the machine lacks an instruction set.
    pub(super) fn detect() -> Option<Self> {
        let older = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        let vectors = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw");
        (older && vectors).then_some(Avx512(()))
    }
}

compiled_for!(
    Avx512,
    "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt"
);

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            // SAFETY: `self` proves AVX-512. Register arithmetic has no other condition, and the
            // tables have the length of the vectors that are loaded from them.
            unsafe { $body }
        }
    )*};
}

/// The operations of vectors with `$n` lanes: those of registers, the intrinsics of the others by
/// name, and further functions.
macro_rules! width {
    ($vectors:ident: $n:ident lanes in $float:ident, $mask:ident, $words:ident;
    $splat:ident, $load:ident, $store:ident, $compress:ident;
    $splat_word:ident, $load_words:ident, $store_words:ident, $compress_words:ident,
    $shift_left:ident, $shift_right:ident;
    { $($arithmetic:tt)* } $($more:tt)*) => {
        impl Width for $vectors {
            const LANES: usize = $n;
            type F = $float;
            type M = $mask;
            type U = $words;
            type Each<T: Copy> = [T; $n];

            intrinsics! { $($arithmetic)* }

            #[inline(always)]
            fn each<T: Copy>(self, value: impl FnMut(usize) -> T) -> [T; $n] {
                array(value)
            }

            #[inline(always)]
            fn load(self, x: &[f32; $n]) -> $float {
                // SAFETY: `self` proves AVX-512; the array is readable floats, one per lane, and
                // the load needs no alignment.
                unsafe { $load(x.as_ptr()) }
            }

            #[inline(always)]
            fn store(self, x: $float) -> [f32; $n] {
                let mut out = [0.0; $n];
                // SAFETY: `self` proves AVX-512; the array is writable floats, one per lane, and
                // the store needs no alignment.
                unsafe { $store(out.as_mut_ptr(), x) };
                out
            }

            #[inline(always)]
            fn load_words(self, x: &[u32; $n]) -> $words {
                // SAFETY: `self` proves AVX-512; the array is readable words, one per lane, and the
                // load needs no alignment.
                unsafe { $load_words(x.as_ptr().cast()) }
            }

            #[inline(always)]
            fn store_words(self, x: $words) -> [u32; $n] {
                let mut out = [0; $n];
                // SAFETY: `self` proves AVX-512; the array is writable words, one per lane, and the
                // store needs no alignment.
                unsafe { $store_words(out.as_mut_ptr().cast(), x) };
                out
            }

            #[inline(always)]
            fn splat(self, x: f32) -> $float {
                // SAFETY: `self` proves AVX-512.
                unsafe { $splat(x) }
            }

            #[inline(always)]
            fn splat_word(self, x: u32) -> $words {
                // SAFETY: `self` proves AVX-512.
                unsafe { $splat_word(x as i32) }
            }

            #[inline(always)]
            fn and(self, a: $mask, b: $mask) -> $mask {
                a & b
            }

            #[inline(always)]
            fn or(self, a: $mask, b: $mask) -> $mask {
                a | b
            }

            #[inline(always)]
            fn not(self, m: $mask) -> $mask {
                !m
            }

            #[inline(always)]
            fn bits(self, m: $mask) -> u32 {
                u32::from(m)
            }

            #[inline(always)]
            fn mask(self, bits: u32) -> $mask {
                bits as $mask
            }

            #[inline(always)]
            fn shift_left(self, a: $words, bits: u32) -> $words {
                // SAFETY: `self` proves AVX-512.
                unsafe { $shift_left(a, self.splat_word(bits)) }
            }

            #[inline(always)]
            fn shift_right(self, a: $words, bits: u32) -> $words {
                // SAFETY: `self` proves AVX-512.
                unsafe { $shift_right(a, self.splat_word(bits)) }
            }

            #[inline(always)]
            fn compress(self, bits: u32, x: $float) -> [f32; $n] {
                // SAFETY: `self` proves AVX-512.
                self.store(unsafe { $compress(bits as $mask, x) })
            }

            #[inline(always)]
            fn compress_words(self, bits: u32, x: $words) -> [u32; $n] {
                // SAFETY: `self` proves AVX-512.
                self.store_words(unsafe { $compress_words(bits as $mask, x) })
            }

            #[inline(always)]
            fn outline<K: Outlined>(self, kernel: K) -> K::Output {
                // SAFETY: `self` exists only where `detect` found all that the code enables.
                unsafe { kernel.shared() }
            }

            $($more)*
        }
    };
}

width! {
    Avx512: NARROW lanes in __m256, __mmask8, __m256i;
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_maskz_compress_ps;
    _mm256_set1_epi32, _mm256_loadu_epi32, _mm256_storeu_epi32, _mm256_maskz_compress_epi32,
    _mm256_sllv_epi32, _mm256_srlv_epi32;
    {
        add(a: F, b: F) -> F = _mm256_add_ps(a, b);
        sub(a: F, b: F) -> F = _mm256_sub_ps(a, b);
        mul(a: F, b: F) -> F = _mm256_mul_ps(a, b);
        div(a: F, b: F) -> F = _mm256_div_ps(a, b);
        min(a: F, b: F) -> F = _mm256_min_ps(a, b);
        max(a: F, b: F) -> F = _mm256_max_ps(a, b);
        abs(a: F) -> F = _mm256_andnot_ps(_mm256_set1_ps(-0.0), a);
        sqrt(a: F) -> F = _mm256_sqrt_ps(a);
        mul_add(a: F, b: F, c: F) -> F = _mm256_fmadd_ps(a, b, c);
        mul_sub(a: F, b: F, c: F) -> F = _mm256_fmsub_ps(a, b, c);
        mul_sign(a: F, b: F) -> F = _mm256_xor_ps(a, _mm256_and_ps(b, _mm256_set1_ps(-0.0)));
        copy_sign(a: F, b: F) -> F = {
            let sign = _mm256_set1_ps(-0.0);
            _mm256_or_ps(_mm256_andnot_ps(sign, a), _mm256_and_ps(sign, b))
        };
        le(a: F, b: F) -> M = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
        lt(a: F, b: F) -> M = _mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b);
        select(m: M, a: F, b: F) -> F = _mm256_mask_blend_ps(m, b, a);
        float_bits(x: F) -> U = _mm256_castps_si256(x);
        floats_of_bits(x: U) -> F = _mm256_castsi256_ps(x);
        add_words(a: U, b: U) -> U = _mm256_add_epi32(a, b);
        sub_words(a: U, b: U) -> U = _mm256_sub_epi32(a, b);
        mul_words(a: U, b: U) -> U = _mm256_mullo_epi32(a, b);
        and_words(a: U, b: U) -> U = _mm256_and_si256(a, b);
        xor_words(a: U, b: U) -> U = _mm256_xor_si256(a, b);
        reverse_bits(a: U) -> U = {
            let table = |bytes: &[u8; 16]| {
                _mm256_broadcastsi128_si256(_mm_loadu_si128(bytes.as_ptr().cast()))
            };
            let nibble = _mm256_set1_epi8(0x0f);
            let low = _mm256_and_si256(a, nibble);
            let high = _mm256_and_si256(_mm256_srli_epi32::<4>(a), nibble);
            let low = _mm256_shuffle_epi8(table(&REVERSED_LOW_NIBBLES), low);
            let high = _mm256_shuffle_epi8(table(&REVERSED_HIGH_NIBBLES), high);
            _mm256_shuffle_epi8(_mm256_or_si256(low, high), table(&REVERSED_BYTES))
        };
        equal_words(a: U, b: U) -> M = _mm256_cmpeq_epi32_mask(a, b);
        select_words(m: M, a: U, b: U) -> U = _mm256_mask_blend_epi32(m, b, a);
    }
}

width! {
    Avx512Wide: LANES lanes in __m512, __mmask16, __m512i;
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_maskz_compress_ps;
    _mm512_set1_epi32, _mm512_loadu_epi32, _mm512_storeu_epi32, _mm512_maskz_compress_epi32,
    _mm512_sllv_epi32, _mm512_srlv_epi32;
    {
        add(a: F, b: F) -> F = _mm512_add_ps(a, b);
        sub(a: F, b: F) -> F = _mm512_sub_ps(a, b);
        mul(a: F, b: F) -> F = _mm512_mul_ps(a, b);
        div(a: F, b: F) -> F = _mm512_div_ps(a, b);
        min(a: F, b: F) -> F = _mm512_min_ps(a, b);
        max(a: F, b: F) -> F = _mm512_max_ps(a, b);
        abs(a: F) -> F = _mm512_andnot_ps(_mm512_set1_ps(-0.0), a);
        sqrt(a: F) -> F = _mm512_sqrt_ps(a);
        mul_add(a: F, b: F, c: F) -> F = _mm512_fmadd_ps(a, b, c);
        mul_sub(a: F, b: F, c: F) -> F = _mm512_fmsub_ps(a, b, c);
        mul_sign(a: F, b: F) -> F = _mm512_xor_ps(a, _mm512_and_ps(b, _mm512_set1_ps(-0.0)));
        copy_sign(a: F, b: F) -> F = {
            let sign = _mm512_set1_ps(-0.0);
            _mm512_or_ps(_mm512_andnot_ps(sign, a), _mm512_and_ps(sign, b))
        };
        le(a: F, b: F) -> M = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
        lt(a: F, b: F) -> M = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b);
        select(m: M, a: F, b: F) -> F = _mm512_mask_blend_ps(m, b, a);
        float_bits(x: F) -> U = _mm512_castps_si512(x);
        floats_of_bits(x: U) -> F = _mm512_castsi512_ps(x);
        add_words(a: U, b: U) -> U = _mm512_add_epi32(a, b);
        sub_words(a: U, b: U) -> U = _mm512_sub_epi32(a, b);
        mul_words(a: U, b: U) -> U = _mm512_mullo_epi32(a, b);
        and_words(a: U, b: U) -> U = _mm512_and_si512(a, b);
        xor_words(a: U, b: U) -> U = _mm512_xor_si512(a, b);
        reverse_bits(a: U) -> U = {
            let table = |bytes: &[u8; 16]| {
                _mm512_broadcast_i32x4(_mm_loadu_si128(bytes.as_ptr().cast()))
            };
            let nibble = _mm512_set1_epi8(0x0f);
            let low = _mm512_and_si512(a, nibble);
            let high = _mm512_and_si512(_mm512_srli_epi32::<4>(a), nibble);
            let low = _mm512_shuffle_epi8(table(&REVERSED_LOW_NIBBLES), low);
            let high = _mm512_shuffle_epi8(table(&REVERSED_HIGH_NIBBLES), high);
            _mm512_shuffle_epi8(_mm512_or_si512(low, high), table(&REVERSED_BYTES))
        };
        equal_words(a: U, b: U) -> M = _mm512_cmpeq_epi32_mask(a, b);
        select_words(m: M, a: U, b: U) -> U = _mm512_mask_blend_epi32(m, b, a);
    }

    #[inline(always)]
    fn lowest(self, bits: u32, x: __m512) -> u32 {
        // SAFETY: `self` proves AVX-512.
        let equal = unsafe {
            let lowest = _mm512_mask_reduce_min_ps(bits as __mmask16, x);
            let lowest = _mm512_set1_ps(lowest);
            _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(bits as __mmask16, x, lowest)
        };
        equal.trailing_zeros()
    }

    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    fn gather_quads<'a, const N: usize>(
        self,
        mut row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[__m512; 4]; N] {
        let mut parts = [[self.splat(0.0); 4]; N];
        // Part i of vector k gets the quad of lane 4 i + k, so that the transposed vectors have the
        // lanes in order.
        macro_rules! insert {
            ($part:literal: $($k:literal)*) => {$(
                let quads = row(4 * $part + $k);
                for n in 0..N {
                    // SAFETY: `self` proves AVX-512; a quad is four readable floats, and the load
                    // needs no alignment.
                    parts[n][$k] = unsafe {
                        _mm512_insertf32x4::<$part>(parts[n][$k], _mm_loadu_ps(quads[n].as_ptr()))
                    };
                }
            )*};
        }
        insert!(0: 0 1 2 3);
        insert!(1: 0 1 2 3);
        insert!(2: 0 1 2 3);
        insert!(3: 0 1 2 3);
        for n in 0..N {
            let [a, b, c, d] = parts[n];
            // SAFETY: `self` proves AVX-512.
            parts[n] = unsafe {
                let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
                let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
                [
                    _mm512_shuffle_ps::<0b01_00_01_00>(ab, cd),
                    _mm512_shuffle_ps::<0b11_10_11_10>(ab, cd),
                    _mm512_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                    _mm512_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
                ]
            };
        }
        parts
    }
}

impl Simd for Avx512 {
    type Wide = Avx512Wide;

    #[inline(always)]
    fn wide(self) -> Avx512Wide {
        Avx512Wide(())
    }

    #[inline(always)]
    fn compress_ordered(
        self,
        order: u32,
        words: &[u32; NARROW],
        (near, far): (__m256, __m256),
        words_out: &mut [MaybeUninit<u32>; NARROW],
        near_out: &mut [MaybeUninit<f32>; NARROW],
    ) -> u32 {
        let words = self.load_words(words);
        // SAFETY: `self` proves AVX-512; both outputs are eight writable words, and the stores need
        // no alignment.
        unsafe {
            let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
            let words = _mm256_permutevar8x32_epi32(words, order);
            let near = _mm256_permutevar8x32_ps(near, order);
            let far = _mm256_permutevar8x32_ps(far, order);
            let kept = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(near, far);
            let (words, near) = (
                _mm256_maskz_compress_epi32(kept, words),
                _mm256_maskz_compress_ps(kept, near),
            );
            _mm256_storeu_si256(words_out.as_mut_ptr().cast(), words);
            _mm256_storeu_ps(near_out.as_mut_ptr().cast(), near);
            u32::from(kept)
        }
    }
}
