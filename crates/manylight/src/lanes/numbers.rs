//! Floats, truth values and words in lanes, with operators.

#![allow(
    missing_docs,
    reason = "the names are those of the operations and components"
)]

use crate::simd::{LANES, One, Portable, Sixteen, Width};
use std::fmt;
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, BitOrAssign, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub,
    SubAssign,
};

/// 1.5 · 2²³. Adding it to |x| < 2²² rounds x to the nearest integer, which the last bits of the
/// sum then hold.
pub(super) const ROUNDING: f32 = 12_582_912.0;

/// Sixteen lanes as plain arrays. Data of this width is made once, and loaded into the vectors of
/// each instruction set.
pub(crate) type Stored = Portable<LANES>;

/// A float per lane.
#[derive(Clone, Copy)]
pub struct Float<S: Width> {
    v: S::F,
    s: S,
}

/// A truth value per lane.
#[derive(Clone, Copy)]
pub struct Mask<S: Width> {
    m: S::M,
    s: S,
}

/// A 32-bit word per lane. Arithmetic wraps.
#[derive(Clone, Copy)]
pub struct Word<S: Width> {
    u: S::U,
    s: S,
}

/// A float per lane, or one constant for all lanes.
pub trait Operand<S: Width> {
    /// The value in the vectors of `s`.
    fn float(self, s: S) -> Float<S>;
}

impl<S: Width> Operand<S> for Float<S> {
    #[inline(always)]
    fn float(self, _: S) -> Float<S> {
        self
    }
}

impl<S: Width> Operand<S> for f32 {
    #[inline(always)]
    fn float(self, s: S) -> Float<S> {
        Float::splat(s, self)
    }
}

impl<S: Width> Float<S> {
    /// `x` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, x: f32) -> Self {
        Float { v: s.splat(x), s }
    }

    /// `value(i)` in each lane `i`.
    #[inline(always)]
    pub fn from_fn(s: S, value: impl FnMut(usize) -> f32) -> Self {
        Float::load(s, &s.each(value))
    }

    /// From an array with an element per lane.
    #[inline(always)]
    pub fn load(s: S, x: &S::Each<f32>) -> Self {
        Float { v: s.load(x), s }
    }

    /// An array with an element per lane.
    #[inline(always)]
    pub fn store(self) -> S::Each<f32> {
        self.s.store(self.v)
    }

    /// Rows in memory, one per lane, of `N` times four floats: element `[n][k]` has number `k` of
    /// `row(i)[n]` in each lane `i`. The lanes are asked for in ascending order.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators over vectors are not always inlined"
    )]
    pub fn gather_quads<'a, const N: usize>(
        s: S,
        row: impl FnMut(usize) -> [&'a [f32; 4]; N],
    ) -> [[Self; 4]; N] {
        let gathered = s.gather_quads(row);
        let mut out = [[Float::splat(s, 0.0); 4]; N];
        for n in 0..N {
            for k in 0..4 {
                out[n][k].v = gathered[n][k];
            }
        }
        out
    }

    /// The token of the width: whoever holds it may run the instructions of these lanes.
    #[inline(always)]
    pub fn width(self) -> S {
        self.s
    }

    /// The vector that holds the lanes.
    #[inline(always)]
    pub(crate) fn vector(self) -> S::F {
        self.v
    }

    /// The constant `x` in as many lanes.
    #[inline(always)]
    pub fn same(self, x: f32) -> Self {
        Float::splat(self.s, x)
    }

    #[inline(always)]
    pub fn min(self, o: impl Operand<S>) -> Self {
        let o = o.float(self.s);
        self.with(self.s.min(self.v, o.v))
    }

    #[inline(always)]
    pub fn max(self, o: impl Operand<S>) -> Self {
        let o = o.float(self.s);
        self.with(self.s.max(self.v, o.v))
    }

    #[inline(always)]
    pub fn clamp(self, low: impl Operand<S>, high: impl Operand<S>) -> Self {
        self.max(low).min(high)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.with(self.s.abs(self.v))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.with(self.s.sqrt(self.v))
    }

    /// Square root of a value that only rounding makes negative.
    #[inline(always)]
    pub fn safe_sqrt(self) -> Self {
        self.max(0.0).sqrt()
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        1.0 / self
    }

    /// The square.
    #[inline(always)]
    pub fn squared(self) -> Self {
        self * self
    }

    /// `self * a + b`, rounded once if the instruction set has fused operations, else twice.
    #[inline(always)]
    pub fn mul_add(self, a: impl Operand<S>, b: impl Operand<S>) -> Self {
        let (a, b) = (a.float(self.s), b.float(self.s));
        self.with(self.s.mul_add(self.v, a.v, b.v))
    }

    /// `self * a - b`, rounded like [`Float::mul_add`].
    #[inline(always)]
    pub fn mul_sub(self, a: impl Operand<S>, b: impl Operand<S>) -> Self {
        let (a, b) = (a.float(self.s), b.float(self.s));
        self.with(self.s.mul_sub(self.v, a.v, b.v))
    }

    /// The value with its sign inverted where `o` has a set sign bit.
    #[inline(always)]
    pub fn mul_sign(self, o: Self) -> Self {
        self.with(self.s.mul_sign(self.v, o.v))
    }

    #[inline(always)]
    pub fn copysign(self, o: Self) -> Self {
        self.with(self.s.copy_sign(self.v, o.v))
    }

    /// 1 with the sign of the value.
    #[inline(always)]
    pub fn sign(self) -> Self {
        self.same(1.0).copysign(self)
    }

    #[inline(always)]
    pub fn lt(self, o: impl Operand<S>) -> Mask<S> {
        let o = o.float(self.s);
        Mask {
            m: self.s.lt(self.v, o.v),
            s: self.s,
        }
    }

    #[inline(always)]
    pub fn le(self, o: impl Operand<S>) -> Mask<S> {
        let o = o.float(self.s);
        Mask {
            m: self.s.le(self.v, o.v),
            s: self.s,
        }
    }

    #[inline(always)]
    pub fn gt(self, o: impl Operand<S>) -> Mask<S> {
        o.float(self.s).lt(self)
    }

    #[inline(always)]
    pub fn ge(self, o: impl Operand<S>) -> Mask<S> {
        o.float(self.s).le(self)
    }

    /// Whether the values are equal; false for NaN.
    #[inline(always)]
    pub fn equals(self, o: impl Operand<S>) -> Mask<S> {
        let o = o.float(self.s);
        self.le(o) & o.le(self)
    }

    #[inline(always)]
    pub fn is_finite(self) -> Mask<S> {
        self.abs().le(f32::MAX)
    }

    /// The lanes with set bits, in ascending order; the rest is unspecified.
    #[inline(always)]
    pub fn compress(self, bits: u32) -> S::Each<f32> {
        self.s.compress(bits, self.v)
    }

    /// The first lane with the lowest value among those with set bits. At least one bit must be
    /// set.
    #[inline(always)]
    pub fn lowest(self, bits: u32) -> usize {
        self.s.lowest(bits, self.v) as usize
    }

    /// The bits of the floats.
    #[inline(always)]
    pub fn to_bits(self) -> Word<S> {
        Word {
            u: self.s.float_bits(self.v),
            s: self.s,
        }
    }

    #[inline(always)]
    fn with(self, v: S::F) -> Self {
        Float { v, s: self.s }
    }
}

impl Float<One> {
    /// The value of the only lane.
    #[inline(always)]
    pub fn get(self) -> f32 {
        self.v
    }

    /// The value in all lanes of `s`.
    #[inline(always)]
    pub(crate) fn in_lanes<S: Width>(&self, s: S) -> Float<S> {
        Float::splat(s, self.v)
    }
}

impl Float<Stored> {
    /// The value of lane `i`.
    #[inline(always)]
    pub(crate) fn lane(&self, i: usize) -> Float<One> {
        self.v[i].into()
    }

    /// Sets lane `i`.
    #[inline(always)]
    pub(crate) fn set_lane(&mut self, i: usize, x: Float<One>) {
        self.v[i] = x.get();
    }

    /// All lanes in the vectors of `s`.
    #[inline(always)]
    pub(crate) fn in_vectors<S: Sixteen>(&self, s: S) -> Float<S> {
        Float::load(s, &self.v)
    }
}

impl From<f32> for Float<One> {
    #[inline(always)]
    fn from(x: f32) -> Self {
        Float::splat(One, x)
    }
}

impl<S: Width> Mask<S> {
    /// The lanes of the set bits.
    #[inline(always)]
    pub fn from_bits(s: S, bits: u32) -> Self {
        Mask { m: s.mask(bits), s }
    }

    /// `value` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, value: bool) -> Self {
        Mask::from_bits(s, if value { u32::MAX } else { 0 })
    }

    /// One bit per lane.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.s.bits(self.m)
    }

    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    #[inline(always)]
    pub fn none(self) -> bool {
        self.bits() == 0
    }

    #[inline(always)]
    pub fn all(self) -> bool {
        self.bits() == u32::MAX >> (32 - S::LANES)
    }

    /// `a` in the lanes that are set, `b` elsewhere.
    #[inline(always)]
    pub fn select(self, a: impl Operand<S>, b: impl Operand<S>) -> Float<S> {
        let (a, b) = (a.float(self.s), b.float(self.s));
        a.with(self.s.select(self.m, a.v, b.v))
    }

    /// `a` in the lanes that are set, `b` elsewhere.
    #[inline(always)]
    pub fn select_words(self, a: Word<S>, b: Word<S>) -> Word<S> {
        Word {
            u: self.s.select_words(self.m, a.u, b.u),
            s: self.s,
        }
    }

    /// The token of the width: whoever holds it may run the instructions of these lanes.
    #[inline(always)]
    pub fn width(self) -> S {
        self.s
    }
}

impl<S: Width> Word<S> {
    /// The words as numbers, for words below 2²².
    #[inline(always)]
    pub fn integer(self) -> Float<S> {
        (self + ROUNDING.to_bits()).to_float() - ROUNDING
    }

    /// `x` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, x: u32) -> Self {
        Word {
            u: s.splat_word(x),
            s,
        }
    }

    /// From an array with an element per lane.
    #[inline(always)]
    pub fn load(s: S, x: &S::Each<u32>) -> Self {
        Word {
            u: s.load_words(x),
            s,
        }
    }

    /// An array with an element per lane.
    #[inline(always)]
    pub fn store(self) -> S::Each<u32> {
        self.s.store_words(self.u)
    }

    /// The token of the width: whoever holds it may run the instructions of these lanes.
    #[inline(always)]
    pub fn width(self) -> S {
        self.s
    }

    /// The lanes with set bits, in ascending order; the rest is unspecified.
    #[inline(always)]
    pub fn compress(self, bits: u32) -> S::Each<u32> {
        self.s.compress_words(bits, self.u)
    }

    /// The floats with these bits.
    #[inline(always)]
    pub fn to_float(self) -> Float<S> {
        Float {
            v: self.s.floats_of_bits(self.u),
            s: self.s,
        }
    }

    /// The words with their bits in reverse order.
    #[inline(always)]
    pub fn reverse_bits(self) -> Self {
        Word {
            u: self.s.reverse_bits(self.u),
            s: self.s,
        }
    }

    #[inline(always)]
    pub fn equals(self, x: u32) -> Mask<S> {
        Mask {
            m: self.s.equal_words(self.u, self.s.splat_word(x)),
            s: self.s,
        }
    }
}

macro_rules! float_operators {
    ($($trait:ident $method:ident;)*) => {$(
        impl<S: Width> $trait for Float<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                self.with(self.s.$method(self.v, o.v))
            }
        }
        impl<S: Width> $trait<f32> for Float<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f32) -> Self {
                self.$method(self.same(o))
            }
        }
        impl<S: Width> $trait<Float<S>> for f32 {
            type Output = Float<S>;
            #[inline(always)]
            fn $method(self, o: Float<S>) -> Float<S> {
                o.same(self).$method(o)
            }
        }
    )*};
}

float_operators! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

impl<S: Width> AddAssign for Float<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Width> SubAssign for Float<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<S: Width> Neg for Float<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        (self.to_bits() ^ 0x8000_0000).to_float()
    }
}

macro_rules! mask_operators {
    ($($trait:ident $method:ident $operation:ident;)*) => {$(
        impl<S: Width> $trait for Mask<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Mask { m: self.s.$operation(self.m, o.m), s: self.s }
            }
        }
    )*};
}

mask_operators! {
    BitAnd bitand and;
    BitOr bitor or;
}

impl<S: Width> BitOrAssign for Mask<S> {
    #[inline(always)]
    fn bitor_assign(&mut self, o: Self) {
        *self = *self | o;
    }
}

impl<S: Width> Not for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Mask {
            m: self.s.not(self.m),
            s: self.s,
        }
    }
}

macro_rules! word_operators {
    ($($trait:ident $method:ident $operation:ident;)*) => {$(
        impl<S: Width> $trait for Word<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Word { u: self.s.$operation(self.u, o.u), s: self.s }
            }
        }
        impl<S: Width> $trait<u32> for Word<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: u32) -> Self {
                self.$method(Word::splat(self.s, o))
            }
        }
    )*};
}

word_operators! {
    Add add add_words;
    Sub sub sub_words;
    Mul mul mul_words;
    BitAnd bitand and_words;
    BitXor bitxor xor_words;
}

impl<S: Width> Shl<u32> for Word<S> {
    type Output = Self;
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Word {
            u: self.s.shift_left(self.u, bits),
            s: self.s,
        }
    }
}

impl<S: Width> Shr<u32> for Word<S> {
    type Output = Self;
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Word {
            u: self.s.shift_right(self.u, bits),
            s: self.s,
        }
    }
}

impl<S: Width> fmt::Debug for Float<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.store().as_ref()).finish()
    }
}

impl<S: Width> fmt::Debug for Mask<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#b}", self.bits())
    }
}

impl<S: Width> fmt::Debug for Word<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.store().as_ref()).finish()
    }
}
