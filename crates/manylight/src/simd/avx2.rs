//! Vector operations in AVX2 and FMA.
#![allow(
    unsafe_code,
    reason = "vendor intrinsics; every kernel is tested against the portable path"
)]

use super::compiled::compiled_for;
use super::width::{LANES, LaneKernel, NARROW, Outlined, Simd, SimdKernel, Width, array};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Eight lanes; the proof that the machine has AVX2, FMA, BMI1 and POPCNT. Only [`Avx2::detect`]
/// creates one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

/// Sixteen lanes, in two vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2Wide(Avx2);

impl Avx2 {
    /// The proof; `None` if the machine lacks an instruction set.
    pub(super) fn detect() -> Option<Self> {
        let vectors = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let bits = is_x86_feature_detected!("bmi1") && is_x86_feature_detected!("popcnt");
        (vectors && bits).then_some(Avx2(()))
    }
}

compiled_for!(Avx2, "avx2,fma,bmi1,popcnt");

/// For each mask of eight bits, the positions of its set bits, ascending.
static SET_BITS: [[u8; NARROW]; 256] = set_bits();

const fn set_bits() -> [[u8; NARROW]; 256] {
    let mut table = [[0; NARROW]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < NARROW {
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

/// The words with set bits, in ascending order of lanes.
#[inline(always)]
fn pack(_: Avx2, bits: u32, words: __m256i) -> __m256i {
    let row = &SET_BITS[bits as usize & 0xff];
    // SAFETY: the first argument proves AVX2; a row of the table is eight readable bytes.
    unsafe {
        let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(row.as_ptr().cast()));
        _mm256_permutevar8x32_epi32(words, order)
    }
}

/// By the value of four bits: these bits in reverse order, for the upper half of a byte.
pub(super) static REVERSED_LOW_NIBBLES: [u8; 16] = [
    0x00, 0x80, 0x40, 0xc0, 0x20, 0xa0, 0x60, 0xe0, 0x10, 0x90, 0x50, 0xd0, 0x30, 0xb0, 0x70, 0xf0,
];

/// By the value of four bits: these bits in reverse order, for the lower half of a byte.
pub(super) static REVERSED_HIGH_NIBBLES: [u8; 16] = [
    0x00, 0x08, 0x04, 0x0c, 0x02, 0x0a, 0x06, 0x0e, 0x01, 0x09, 0x05, 0x0d, 0x03, 0x0b, 0x07, 0x0f,
];

/// The places of the bytes of four words in reverse order, word by word.
pub(super) static REVERSED_BYTES: [u8; 16] = [3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12];

macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            // SAFETY: `self` proves AVX2 and FMA. Register arithmetic has no other condition, and the
            // tables have the length of the vectors that are loaded from them.
            unsafe { $body }
        }
    )*};
}

impl Width for Avx2 {
    const LANES: usize = NARROW;
    type F = __m256;
    type M = __m256;
    type U = __m256i;
    type Each<T: Copy> = [T; NARROW];

    intrinsics! {
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
        le(a: F, b: F) -> M = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
        lt(a: F, b: F) -> M = _mm256_cmp_ps::<_CMP_LT_OQ>(a, b);
        select(m: M, a: F, b: F) -> F = _mm256_blendv_ps(b, a, m);
        and(a: M, b: M) -> M = _mm256_and_ps(a, b);
        or(a: M, b: M) -> M = _mm256_or_ps(a, b);
        not(m: M) -> M = {
            let all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
            _mm256_andnot_ps(m, all)
        };
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
        equal_words(a: U, b: U) -> M = _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b));
        select_words(m: M, a: U, b: U) -> U = _mm256_blendv_epi8(b, a, _mm256_castps_si256(m));
    }

    #[inline(always)]
    fn each<T: Copy>(self, value: impl FnMut(usize) -> T) -> [T; NARROW] {
        array(value)
    }

    #[inline(always)]
    fn load(self, x: &[f32; NARROW]) -> __m256 {
        // SAFETY: `self` proves AVX2; the array is eight readable floats, and the load needs no
        // alignment.
        unsafe { _mm256_loadu_ps(x.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, x: __m256) -> [f32; NARROW] {
        let mut out = [0.0; NARROW];
        // SAFETY: `self` proves AVX2; the array is eight writable floats, and the store needs no
        // alignment.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn load_words(self, x: &[u32; NARROW]) -> __m256i {
        // SAFETY: `self` proves AVX2; the array is eight readable words, and the load needs no
        // alignment.
        unsafe { _mm256_loadu_si256(x.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_words(self, x: __m256i) -> [u32; NARROW] {
        let mut out = [0; NARROW];
        // SAFETY: `self` proves AVX2; the array is eight writable words, and the store needs no
        // alignment.
        unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), x) };
        out
    }

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn splat_word(self, x: u32) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_set1_epi32(x as i32) }
    }

    #[inline(always)]
    fn bits(self, m: __m256) -> u32 {
        // SAFETY: `self` proves AVX.
        unsafe { _mm256_movemask_ps(m) as u32 }
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> __m256 {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let powers = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let mine = _mm256_and_si256(_mm256_set1_epi32(bits as i32), powers);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(mine, powers))
        }
    }

    #[inline(always)]
    fn shift_left(self, a: __m256i, bits: u32) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_sllv_epi32(a, self.splat_word(bits)) }
    }

    #[inline(always)]
    fn shift_right(self, a: __m256i, bits: u32) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_srlv_epi32(a, self.splat_word(bits)) }
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: __m256) -> [f32; NARROW] {
        self.store(self.floats_of_bits(pack(self, bits, self.float_bits(x))))
    }

    #[inline(always)]
    fn compress_words(self, bits: u32, x: __m256i) -> [u32; NARROW] {
        self.store_words(pack(self, bits, x))
    }

    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    fn gather_quads<'a, const N: usize>(
        self,
        mut row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[__m256; 4]; N] {
        let mut parts = [[self.splat(0.0); 4]; N];
        // Part i of vector k gets the quad of lane 4 i + k, so that the transposed vectors have the
        // lanes in order.
        macro_rules! insert {
            ($part:literal: $($k:literal)*) => {$(
                let quads = row(4 * $part + $k);
                for n in 0..N {
                    // SAFETY: `self` proves AVX2; a quad is four readable floats, and the load
                    // needs no alignment.
                    parts[n][$k] = unsafe {
                        _mm256_insertf128_ps::<$part>(parts[n][$k], _mm_loadu_ps(quads[n].as_ptr()))
                    };
                }
            )*};
        }
        insert!(0: 0 1 2 3);
        insert!(1: 0 1 2 3);
        for n in 0..N {
            let [a, b, c, d] = parts[n];
            // SAFETY: `self` proves AVX2.
            parts[n] = unsafe {
                let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
                    _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
                    _mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                    _mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
                ]
            };
        }
        parts
    }

    #[inline(always)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        // SAFETY: `self` exists only where `detect` found all that the code enables.
        unsafe { kernel.shared() }
    }
}

/// The two halves of an array.
#[inline(always)]
fn halves<T>(x: &[T; LANES]) -> [&[T; NARROW]; 2] {
    let (halves, _) = x.as_chunks::<NARROW>();
    [&halves[0], &halves[1]]
}

/// The array with two halves.
#[inline(always)]
fn joined<T: Copy + Default>([low, high]: [[T; NARROW]; 2]) -> [T; LANES] {
    // A constant, of which nothing remains: if the array began with `low[0]`, LLVM would write that
    // element apart, and the half in four parts.
    let mut all = [T::default(); LANES];
    let (halves, _) = all.as_chunks_mut::<NARROW>();
    halves[0] = low;
    halves[1] = high;
    all
}

macro_rules! in_halves {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            [self.0.$name($($arg[0]),*), self.0.$name($($arg[1]),*)]
        }
    )*};
}

impl Width for Avx2Wide {
    const LANES: usize = LANES;
    type F = [__m256; 2];
    type M = [__m256; 2];
    type U = [__m256i; 2];
    type Each<T: Copy> = [T; LANES];

    in_halves! {
        add(a: F, b: F) -> F;
        sub(a: F, b: F) -> F;
        mul(a: F, b: F) -> F;
        div(a: F, b: F) -> F;
        min(a: F, b: F) -> F;
        max(a: F, b: F) -> F;
        abs(a: F) -> F;
        sqrt(a: F) -> F;
        mul_add(a: F, b: F, c: F) -> F;
        mul_sub(a: F, b: F, c: F) -> F;
        mul_sign(a: F, b: F) -> F;
        copy_sign(a: F, b: F) -> F;
        le(a: F, b: F) -> M;
        lt(a: F, b: F) -> M;
        select(m: M, a: F, b: F) -> F;
        and(a: M, b: M) -> M;
        or(a: M, b: M) -> M;
        not(m: M) -> M;
        float_bits(x: F) -> U;
        floats_of_bits(x: U) -> F;
        add_words(a: U, b: U) -> U;
        sub_words(a: U, b: U) -> U;
        mul_words(a: U, b: U) -> U;
        and_words(a: U, b: U) -> U;
        xor_words(a: U, b: U) -> U;
        reverse_bits(a: U) -> U;
        equal_words(a: U, b: U) -> M;
        select_words(m: M, a: U, b: U) -> U;
    }

    #[inline(always)]
    fn each<T: Copy>(self, value: impl FnMut(usize) -> T) -> [T; LANES] {
        array(value)
    }

    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> [__m256; 2] {
        let [low, high] = halves(x);
        [self.0.load(low), self.0.load(high)]
    }

    #[inline(always)]
    fn store(self, x: [__m256; 2]) -> [f32; LANES] {
        joined([self.0.store(x[0]), self.0.store(x[1])])
    }

    #[inline(always)]
    fn load_words(self, x: &[u32; LANES]) -> [__m256i; 2] {
        let [low, high] = halves(x);
        [self.0.load_words(low), self.0.load_words(high)]
    }

    #[inline(always)]
    fn store_words(self, x: [__m256i; 2]) -> [u32; LANES] {
        joined([self.0.store_words(x[0]), self.0.store_words(x[1])])
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [__m256; 2] {
        [self.0.splat(x); 2]
    }

    #[inline(always)]
    fn splat_word(self, x: u32) -> [__m256i; 2] {
        [self.0.splat_word(x); 2]
    }

    #[inline(always)]
    fn bits(self, m: [__m256; 2]) -> u32 {
        self.0.bits(m[0]) | self.0.bits(m[1]) << NARROW
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> [__m256; 2] {
        [self.0.mask(bits), self.0.mask(bits >> NARROW)]
    }

    #[inline(always)]
    fn shift_left(self, a: [__m256i; 2], bits: u32) -> [__m256i; 2] {
        [self.0.shift_left(a[0], bits), self.0.shift_left(a[1], bits)]
    }

    #[inline(always)]
    fn shift_right(self, a: [__m256i; 2], bits: u32) -> [__m256i; 2] {
        [
            self.0.shift_right(a[0], bits),
            self.0.shift_right(a[1], bits),
        ]
    }

    #[inline(always)]
    fn compress(self, bits: u32, x: [__m256; 2]) -> [f32; LANES] {
        let words = self.compress_words(bits, self.float_bits(x));
        words.map(f32::from_bits)
    }

    #[inline(always)]
    fn compress_words(self, bits: u32, x: [__m256i; 2]) -> [u32; LANES] {
        let mut out = [0; LANES];
        let first = (bits & 0xff).count_ones() as usize;
        // SAFETY: `self` proves AVX2; the first store covers lanes 0 to 7, the second begins at
        // most at lane 8, and neither needs alignment.
        unsafe {
            _mm256_storeu_si256(out.as_mut_ptr().cast(), pack(self.0, bits, x[0]));
            let rest = pack(self.0, bits >> NARROW, x[1]);
            _mm256_storeu_si256(out.as_mut_ptr().add(first).cast(), rest);
        }
        out
    }

    #[inline(always)]
    fn lowest(self, bits: u32, x: [__m256; 2]) -> u32 {
        let infinity = self.splat(f32::INFINITY);
        let masked = self.select(self.mask(bits), x, infinity);
        // SAFETY: `self` proves AVX2.
        let equal = unsafe {
            let eight = _mm256_min_ps(masked[0], masked[1]);
            let four = _mm_min_ps(
                _mm256_castps256_ps128(eight),
                _mm256_extractf128_ps::<1>(eight),
            );
            let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
            let one = _mm_min_ss(two, _mm_movehdup_ps(two));
            let lowest = _mm256_broadcastss_ps(one);
            [
                _mm256_cmp_ps::<_CMP_EQ_OQ>(x[0], lowest),
                _mm256_cmp_ps::<_CMP_EQ_OQ>(x[1], lowest),
            ]
        };
        (self.bits(equal) & bits).trailing_zeros()
    }

    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    fn gather_quads<'a, const N: usize>(
        self,
        mut row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[[__m256; 2]; 4]; N] {
        let low = self.0.gather_quads(&mut row);
        let high = self.0.gather_quads(|i| row(NARROW + i));
        let mut out = [[self.splat(0.0); 4]; N];
        for n in 0..N {
            for k in 0..4 {
                out[n][k] = [low[n][k], high[n][k]];
            }
        }
        out
    }

    #[inline(always)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        self.0.outline(kernel)
    }
}

impl Simd for Avx2 {
    type Wide = Avx2Wide;

    #[inline(always)]
    fn wide(self) -> Avx2Wide {
        Avx2Wide(self)
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
        // SAFETY: `self` proves AVX2; both outputs are eight writable words, and the stores need no
        // alignment.
        unsafe {
            let places = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), places);
            let words = _mm256_permutevar8x32_epi32(words, order);
            let near = _mm256_permutevar8x32_ps(near, order);
            let far = _mm256_permutevar8x32_ps(far, order);
            let kept = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32;
            let near = pack(self, kept, _mm256_castps_si256(near));
            _mm256_storeu_si256(words_out.as_mut_ptr().cast(), pack(self, kept, words));
            _mm256_storeu_si256(near_out.as_mut_ptr().cast(), near);
            kept
        }
    }
}
