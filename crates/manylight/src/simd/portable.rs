//! Vector operations in plain Rust: on one number, and on arrays, which the compiler vectorizes as
//! far as the target allows.

use super::width::{LANES, LaneKernel, NARROW, Outlined, Simd, SimdKernel, Width, array};
use std::mem::MaybeUninit;

/// One lane: plain numbers.
#[derive(Clone, Copy, Debug)]
pub struct One;

/// `N` lanes in the portable instruction set, which all machines have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable<const N: usize>;

/// Runs a kernel in vectors.
#[inline]
pub(super) fn run<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.kernel()
}

/// Runs a kernel with one lane.
#[inline]
pub(super) fn run_lanes<K: LaneKernel>(kernel: K) -> K::Output {
    kernel.lanes()
}

/// The code of kernels; methods for the sake of the compiler's time, like those of `compiled`.
trait KernelCode: SimdKernel + Sized {
    fn kernel(self) -> Self::Output {
        self.run(Portable::<NARROW>)
    }
}

impl<K: SimdKernel> KernelCode for K {}

/// The code of kernels with one lane.
trait LaneCode: LaneKernel + Sized {
    fn lanes(self) -> Self::Output {
        self.run(One)
    }
}

impl<K: LaneKernel> LaneCode for K {}

/// Code that several kernels call.
trait SharedCode: Outlined + Sized {
    #[inline(never)]
    fn shared(self) -> Self::Output {
        self.run()
    }
}

impl<K: Outlined> SharedCode for K {}

/// `value(i)` in each lane `i`. A loop over all lanes, which the compiler vectorizes.
#[inline(always)]
fn map<const N: usize, T: Copy>(value: impl Fn(usize) -> T) -> [T; N] {
    let mut out = [value(0); N];
    for (i, lane) in out.iter_mut().enumerate() {
        *lane = value(i);
    }
    out
}

/// A lane of a mask.
#[inline(always)]
fn word_of(lane: bool) -> u32 {
    u32::from(lane).wrapping_neg()
}

/// `a` where the bits of `m` are set, `b` elsewhere.
#[inline(always)]
fn blend(m: u32, a: u32, b: u32) -> u32 {
    (m & a) | (!m & b)
}

/// The operations on the numbers of a lane, but those of its truth value.
macro_rules! operations {
    ($implement:ident) => {
        $implement! {
            add(a: F, b: F) -> F = a + b;
            sub(a: F, b: F) -> F = a - b;
            mul(a: F, b: F) -> F = a * b;
            div(a: F, b: F) -> F = a / b;
            min(a: F, b: F) -> F = if a < b { a } else { b };
            max(a: F, b: F) -> F = if a > b { a } else { b };
            abs(a: F) -> F = a.abs();
            sqrt(a: F) -> F = a.sqrt();
            mul_add(a: F, b: F, c: F) -> F = a * b + c;
            mul_sub(a: F, b: F, c: F) -> F = a * b - c;
            mul_sign(a: F, b: F) -> F = f32::from_bits(a.to_bits() ^ (b.to_bits() & 0x8000_0000));
            copy_sign(a: F, b: F) -> F = a.copysign(b);
            float_bits(x: F) -> U = x.to_bits();
            floats_of_bits(x: U) -> F = f32::from_bits(x);
            add_words(a: U, b: U) -> U = a.wrapping_add(b);
            sub_words(a: U, b: U) -> U = a.wrapping_sub(b);
            mul_words(a: U, b: U) -> U = a.wrapping_mul(b);
            and_words(a: U, b: U) -> U = a & b;
            xor_words(a: U, b: U) -> U = a ^ b;
            reverse_bits(a: U) -> U = a.reverse_bits();
        }
    };
}

macro_rules! on_numbers {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident = $value:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            $value
        }
    )*};
}

// `inline`, and not `inline(always)`: LLVM then simplifies the loop of an operation once, before it
// is inlined, and not once for each of its uses. A release of the core compiles in 183 s of
// processor time instead of 320 s, and the speed of the portable code changes by less than 2 %
// (rustc 1.95, two codegen units, without LTO). Debug assertions add branches to every loop, and
// the time of LLVM's global value numbering grows with the square of the branches of a function:
// with them operations are not inlined, and the core compiles in 237 s instead of 601 s (opt-level
// 3, 16 codegen units).
macro_rules! on_arrays {
    ($($name:ident($($arg:ident: $ty:ident),*) -> $out:ident = $value:expr;)*) => {$(
        #[cfg_attr(debug_assertions, inline(never))]
        #[cfg_attr(not(debug_assertions), inline)]
        fn $name(self, $($arg: Self::$ty),*) -> Self::$out {
            map(|i| {
                $(let $arg = $arg[i];)*
                $value
            })
        }
    )*};
}

impl Width for One {
    const LANES: usize = 1;
    type F = f32;
    type M = bool;
    type U = u32;
    type Each<T: Copy> = [T; 1];

    operations!(on_numbers);
    on_numbers! {
        le(a: F, b: F) -> M = a <= b;
        lt(a: F, b: F) -> M = a < b;
        select(m: M, a: F, b: F) -> F = if m { a } else { b };
        and(a: M, b: M) -> M = a & b;
        or(a: M, b: M) -> M = a | b;
        not(m: M) -> M = !m;
        equal_words(a: U, b: U) -> M = a == b;
        select_words(m: M, a: U, b: U) -> U = if m { a } else { b };
    }

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
    fn bits(self, m: bool) -> u32 {
        u32::from(m)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> bool {
        bits & 1 != 0
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
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        kernel.shared()
    }
}

impl<const N: usize> Width for Portable<N> {
    const LANES: usize = N;
    type F = [f32; N];
    /// All bits of a lane, or none. Bytes would be packed and unpacked between the vectors.
    type M = [u32; N];
    type U = [u32; N];
    type Each<T: Copy> = [T; N];

    operations!(on_arrays);
    on_arrays! {
        le(a: F, b: F) -> M = word_of(a <= b);
        lt(a: F, b: F) -> M = word_of(a < b);
        select(m: M, a: F, b: F) -> F = f32::from_bits(blend(m, a.to_bits(), b.to_bits()));
        and(a: M, b: M) -> M = a & b;
        or(a: M, b: M) -> M = a | b;
        not(m: M) -> M = !m;
        equal_words(a: U, b: U) -> M = word_of(a == b);
        select_words(m: M, a: U, b: U) -> U = blend(m, a, b);
    }

    #[inline(always)]
    fn each<T: Copy>(self, value: impl FnMut(usize) -> T) -> [T; N] {
        array(value)
    }
    #[inline(always)]
    fn load(self, x: &[f32; N]) -> [f32; N] {
        *x
    }
    #[inline(always)]
    fn store(self, x: [f32; N]) -> [f32; N] {
        x
    }
    #[inline(always)]
    fn load_words(self, x: &[u32; N]) -> [u32; N] {
        *x
    }
    #[inline(always)]
    fn store_words(self, x: [u32; N]) -> [u32; N] {
        x
    }
    #[inline(always)]
    fn splat(self, x: f32) -> [f32; N] {
        [x; N]
    }
    #[inline(always)]
    fn splat_word(self, x: u32) -> [u32; N] {
        [x; N]
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline)]
    fn bits(self, m: [u32; N]) -> u32 {
        let lanes = m.iter().enumerate();
        lanes.fold(0, |bits, (i, lane)| bits | (lane & 1 << i))
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline)]
    fn mask(self, bits: u32) -> [u32; N] {
        map(|i| word_of(bits & 1 << i != 0))
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline)]
    fn shift_left(self, a: [u32; N], bits: u32) -> [u32; N] {
        map(|i| a[i] << bits)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline)]
    fn shift_right(self, a: [u32; N], bits: u32) -> [u32; N] {
        map(|i| a[i] >> bits)
    }
    #[inline(always)]
    fn outline<K: Outlined>(self, kernel: K) -> K::Output {
        kernel.shared()
    }
}

impl Simd for Portable<NARROW> {
    type Wide = Portable<LANES>;

    #[inline(always)]
    fn wide(self) -> Portable<LANES> {
        Portable
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
