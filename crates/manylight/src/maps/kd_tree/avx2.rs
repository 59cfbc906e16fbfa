//! The kernels' operations in AVX2.
#![allow(
    unsafe_code,
    reason = "vendor intrinsics; every kernel is tested against brute force in each instruction set"
)]

use super::lanes::{Kernel, Lanes, WIDTH};
use std::arch::x86_64::*;

/// Lanes per register.
const HALF: usize = WIDTH / 2;

/// Proof that the machine has AVX2 and the bit counting of the same age: [`Avx2::detect`] is the only way to get one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx2 {
    /// The proof, if it can be had.
    pub(super) fn detect() -> Option<Self> {
        let bits = is_x86_feature_detected!("bmi1") && is_x86_feature_detected!("popcnt");
        (is_x86_feature_detected!("avx2") && bits).then_some(Avx2(()))
    }

    /// Runs a kernel compiled for these instructions.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: `self` exists only where `detect` found all that `run` enables.
        unsafe { run(self, kernel) }
    }
}

#[target_feature(enable = "avx2,bmi1,popcnt")]
fn run<K: Kernel>(avx2: Avx2, kernel: K) -> K::Output {
    kernel.run(avx2)
}

/// For each mask of eight bits, the positions of its set bits in rising order.
static SET_BITS: [[u8; HALF]; 256] = set_bits();

const fn set_bits() -> [[u8; HALF]; 256] {
    let mut table = [[0; HALF]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < HALF {
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

/// The lanes of `mask` in rising order.
#[inline(always)]
fn compress(_: Avx2, mask: u32, halves: [__m256i; 2]) -> [u32; WIDTH] {
    let mut out = [0; WIDTH];
    let masks = [(mask & 0xff) as usize, (mask >> HALF & 0xff) as usize];
    // SAFETY: the first argument proves AVX2; a row of the table is eight readable bytes. The first store covers lanes 0 to
    // 7, the second begins at most at lane 8; neither needs alignment.
    unsafe {
        let packed = |half: usize| {
            let row = _mm_loadl_epi64(SET_BITS[masks[half]].as_ptr().cast());
            _mm256_permutevar8x32_epi32(halves[half], _mm256_cvtepu8_epi32(row))
        };
        let first = masks[0].count_ones() as usize;
        _mm256_storeu_si256(out.as_mut_ptr().cast(), packed(0));
        _mm256_storeu_si256(out.as_mut_ptr().add(first).cast(), packed(1));
    }
    out
}

macro_rules! both_halves {
    ($($name:ident = $intrinsic:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
            // SAFETY: `self` proves AVX2, and register arithmetic has no other condition.
            unsafe { [$intrinsic(a[0], b[0]), $intrinsic(a[1], b[1])] }
        }
    )*};
}

impl Lanes for Avx2 {
    type F = [__m256; 2];

    both_halves! {
        add = _mm256_add_ps;
        sub = _mm256_sub_ps;
        mul = _mm256_mul_ps;
        max = _mm256_max_ps;
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        [unsafe { _mm256_set1_ps(x) }; 2]
    }

    #[inline(always)]
    fn load(self, x: &[f32; WIDTH]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2; the array is sixteen readable floats, and the loads need no alignment.
        unsafe {
            [
                _mm256_loadu_ps(x.as_ptr()),
                _mm256_loadu_ps(x.as_ptr().add(HALF)),
            ]
        }
    }

    #[inline(always)]
    fn store(self, x: [__m256; 2]) -> [f32; WIDTH] {
        let mut out = [0.0; WIDTH];
        // SAFETY: `self` proves AVX2; the array is sixteen writable floats, and the stores need no alignment.
        unsafe {
            _mm256_storeu_ps(out.as_mut_ptr(), x[0]);
            _mm256_storeu_ps(out.as_mut_ptr().add(HALF), x[1]);
        }
        out
    }

    #[inline(always)]
    fn le(self, a: [__m256; 2], b: [__m256; 2]) -> u32 {
        // SAFETY: `self` proves AVX2.
        let bits = |i: usize| unsafe {
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a[i], b[i])) as u32
        };
        bits(0) | bits(1) << HALF
    }

    #[inline(always)]
    fn compress(self, mask: u32, x: [__m256; 2]) -> [f32; WIDTH] {
        // SAFETY: `self` proves AVX2.
        let halves = x.map(|half| unsafe { _mm256_castps_si256(half) });
        compress(self, mask, halves).map(f32::from_bits)
    }

    #[inline(always)]
    fn compress_index(self, mask: u32, x: &[u32; WIDTH]) -> [u32; WIDTH] {
        // SAFETY: `self` proves AVX2; the array is sixteen readable words, and the loads need no alignment.
        let halves = unsafe {
            let at = x.as_ptr().cast::<__m256i>();
            [_mm256_loadu_si256(at), _mm256_loadu_si256(at.add(1))]
        };
        compress(self, mask, halves)
    }

    #[inline(always)]
    fn lowest(self, mask: u32, x: [__m256; 2]) -> u32 {
        // SAFETY: `self` proves AVX2.
        let lowest = unsafe {
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let masked = |i: usize| {
                let mine = _mm256_set1_epi32((mask >> (HALF * i)) as i32);
                let inside = _mm256_cmpeq_epi32(_mm256_and_si256(mine, bits), bits);
                let infinity = _mm256_set1_ps(f32::INFINITY);
                _mm256_blendv_ps(infinity, x[i], _mm256_castsi256_ps(inside))
            };
            let eight = _mm256_min_ps(masked(0), masked(1));
            let four = _mm_min_ps(
                _mm256_castps256_ps128(eight),
                _mm256_extractf128_ps::<1>(eight),
            );
            let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
            let one = _mm_min_ss(two, _mm_movehdup_ps(two));
            _mm_cvtss_f32(one)
        };
        (self.le(x, self.splat(lowest)) & mask).trailing_zeros()
    }
}
