//! Vector operations in plain Rust on arrays, which the compiler vectorizes as far as the target allows.

use super::{Floats, NARROW, Outlined, Simd, WIDE, Wide, set_bits};
use std::mem::MaybeUninit;

/// The portable instruction set, available on all machines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

#[inline(always)]
fn map2<const N: usize, A: Copy, B: Copy, C: Copy>(
    a: [A; N],
    b: [B; N],
    f: impl Fn(A, B) -> C,
) -> [C; N] {
    map(|i| f(a[i], b[i]))
}

/// `value(i)` in each lane `i`. Functions of the standard library over arrays are not always inlined.
#[inline(always)]
fn map<const N: usize, T: Copy>(value: impl Fn(usize) -> T) -> [T; N] {
    let mut out = [value(0); N];
    for (i, lane) in out.iter_mut().enumerate() {
        *lane = value(i);
    }
    out
}

#[inline(always)]
fn compress<const N: usize, T: Copy>(bits: u32, mut x: [T; N]) -> [T; N] {
    for (place, i) in set_bits(bits).enumerate() {
        x[place] = x[i];
    }
    x
}

impl<const N: usize> Floats<N> for Portable {
    type F = [f32; N];
    type M = [bool; N];
    type U = [u32; N];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [x; N]
    }
    #[inline(always)]
    fn load(self, x: &[f32; N]) -> Self::F {
        *x
    }
    #[inline(always)]
    fn store(self, x: Self::F) -> [f32; N] {
        x
    }
    #[inline(always)]
    fn load_words(self, x: &[u32; N]) -> Self::U {
        *x
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
    fn abs(self, a: Self::F) -> Self::F {
        map(|i| a[i].abs())
    }
    #[inline(always)]
    fn sqrt(self, a: Self::F) -> Self::F {
        map(|i| a[i].sqrt())
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        map(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        map(|i| a[i] * b[i] - c[i])
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
    fn lanes(self, bits: u32) -> Self::M {
        map(|i| bits >> i & 1 != 0)
    }
    #[inline(always)]
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F {
        map(|i| if m[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn compress(self, bits: u32, x: Self::F) -> [f32; N] {
        compress(bits, x)
    }
    #[inline(always)]
    fn compress_words(self, bits: u32, x: Self::U) -> [u32; N] {
        compress(bits, x)
    }
}

impl Wide for Portable {
    #[inline(always)]
    fn lowest(self, bits: u32, x: [f32; WIDE]) -> u32 {
        let first = bits.trailing_zeros() as usize;
        let lowest = set_bits(bits).fold(first, |best, i| if x[i] < x[best] { i } else { best });
        lowest as u32
    }
    #[inline(always)]
    fn copy_sign(self, a: [f32; WIDE], b: [f32; WIDE]) -> [f32; WIDE] {
        map2(a, b, f32::copysign)
    }
    #[inline(always)]
    fn not(self, m: [bool; WIDE]) -> [bool; WIDE] {
        map(|i| !m[i])
    }
    #[inline(always)]
    fn float_bits(self, x: [f32; WIDE]) -> [u32; WIDE] {
        map(|i| x[i].to_bits())
    }
    #[inline(always)]
    fn floats_of_bits(self, x: [u32; WIDE]) -> [f32; WIDE] {
        map(|i| f32::from_bits(x[i]))
    }
    #[inline(always)]
    fn splat_word(self, x: u32) -> [u32; WIDE] {
        [x; WIDE]
    }
    #[inline(always)]
    fn store_words(self, x: [u32; WIDE]) -> [u32; WIDE] {
        x
    }
    #[inline(always)]
    fn add_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map2(a, b, u32::wrapping_add)
    }
    #[inline(always)]
    fn sub_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map2(a, b, u32::wrapping_sub)
    }
    #[inline(always)]
    fn mul_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map2(a, b, u32::wrapping_mul)
    }
    #[inline(always)]
    fn and_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map2(a, b, |a, b| a & b)
    }
    #[inline(always)]
    fn xor_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map2(a, b, |a, b| a ^ b)
    }
    #[inline(always)]
    fn shift_left(self, a: [u32; WIDE], bits: u32) -> [u32; WIDE] {
        map(|i| a[i] << bits)
    }
    #[inline(always)]
    fn shift_right(self, a: [u32; WIDE], bits: u32) -> [u32; WIDE] {
        map(|i| a[i] >> bits)
    }
    #[inline(always)]
    fn equal_words(self, a: [u32; WIDE], b: [u32; WIDE]) -> [bool; WIDE] {
        map2(a, b, |a, b| a == b)
    }
    #[inline(always)]
    fn select_words(self, m: [bool; WIDE], a: [u32; WIDE], b: [u32; WIDE]) -> [u32; WIDE] {
        map(|i| if m[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn gather_quads<'a, const N: usize>(
        self,
        mut row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[[f32; WIDE]; 4]; N] {
        let mut out = [[[0.0; WIDE]; 4]; N];
        for i in 0..WIDE {
            for (quad, columns) in row(i).iter().zip(&mut out) {
                for (k, column) in columns.iter_mut().enumerate() {
                    column[i] = quad[k];
                }
            }
        }
        out
    }
    #[inline(never)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        kernel.run()
    }
}

impl Simd for Portable {
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }

    #[inline(always)]
    fn compress_ordered(
        self,
        order: u32,
        words: &[u32; NARROW],
        (near, far): ([f32; NARROW], [f32; NARROW]),
        words_out: &mut [MaybeUninit<u32>; NARROW],
        near_out: &mut [MaybeUninit<f32>; NARROW],
    ) -> u32 {
        let (mut count, mut kept) = (0, 0);
        for place in 0..NARROW {
            let i = (order >> (3 * place) & 7) as usize;
            if near[i] <= far[i] {
                words_out[count].write(words[i]);
                near_out[count].write(near[i]);
                count += 1;
                kept |= 1 << place;
            }
        }
        kept
    }
}
