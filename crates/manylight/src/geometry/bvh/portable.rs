//! The kernels' operations in plain Rust on arrays, for the compiler to vectorize as far as the target allows.

use super::simd::{LANES, Lanes, Simd};
use super::stack::Stack;
use std::mem::MaybeUninit;

/// Needs nothing of the machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

#[inline(always)]
fn map2<const N: usize, A: Copy, B: Copy, C>(
    a: [A; N],
    b: [B; N],
    f: impl Fn(A, B) -> C,
) -> [C; N] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl<const N: usize> Lanes<N> for Portable {
    type F = [f32; N];
    type M = [bool; N];

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
        a.map(f32::abs)
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
}

impl Simd for Portable {
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }

    #[inline(always)]
    fn compact(self, words: &[u32; LANES], mut bits: u32, out: &mut [MaybeUninit<u32>; LANES]) {
        let mut count = 0;
        while bits != 0 {
            out[count % LANES].write(words[bits.trailing_zeros() as usize % LANES]);
            bits &= bits - 1;
            count += 1;
        }
    }

    #[inline(always)]
    fn push_ordered(
        self,
        stack: &mut Stack,
        children: &[u32; LANES],
        order: u32,
        near: [f32; LANES],
        far: [f32; LANES],
    ) {
        for place in 0..LANES {
            let i = (order >> (3 * place) & 7) as usize;
            if near[i] <= far[i] {
                stack.push(children[i], near[i]);
            }
        }
    }
}
