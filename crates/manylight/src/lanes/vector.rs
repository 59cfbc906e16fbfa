//! Vectors, colors and frames in lanes.

#![allow(
    missing_docs,
    reason = "the names are those of the operations and components"
)]

use super::numbers::{Float, Mask};
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::simd::{One, Width};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A pair of floats per lane.
#[derive(Clone, Copy, Debug)]
pub struct Pair<S: Width> {
    pub x: Float<S>,
    pub y: Float<S>,
}

/// A vector per lane.
#[derive(Clone, Copy, Debug)]
pub struct Vector<S: Width> {
    pub x: Float<S>,
    pub y: Float<S>,
    pub z: Float<S>,
}

/// A linear Rec. 709 color per lane; see [`Rgb`].
#[derive(Clone, Copy, Debug)]
pub struct Color<S: Width> {
    pub r: Float<S>,
    pub g: Float<S>,
    pub b: Float<S>,
}

/// A right-handed orthonormal basis per lane; see [`Frame`].
#[derive(Clone, Copy, Debug)]
pub struct Axes<S: Width> {
    pub s: Vector<S>,
    pub t: Vector<S>,
    pub n: Vector<S>,
}

impl<S: Width> Pair<S> {
    #[inline(always)]
    pub fn new(x: Float<S>, y: Float<S>) -> Self {
        Pair { x, y }
    }

    /// `v` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, v: Vec2) -> Self {
        Pair::new(Float::splat(s, v.x), Float::splat(s, v.y))
    }

    /// The pair `value(i)` in each lane `i`.
    #[inline(always)]
    pub fn from_fn(s: S, value: impl Fn(usize) -> Vec2) -> Self {
        let all = s.each(value);
        Pair::new(
            Float::from_fn(s, |i| all.as_ref()[i].x),
            Float::from_fn(s, |i| all.as_ref()[i].y),
        )
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> Float<S> {
        self.x.mul_add(o.x, self.y * o.y)
    }

    #[inline(always)]
    pub fn length_squared(self) -> Float<S> {
        self.dot(self)
    }
}

impl<S: Width> Vector<S> {
    #[inline(always)]
    pub fn new(x: Float<S>, y: Float<S>, z: Float<S>) -> Self {
        Vector { x, y, z }
    }

    /// `v` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, v: Vec3) -> Self {
        Vector::new(
            Float::splat(s, v.x),
            Float::splat(s, v.y),
            Float::splat(s, v.z),
        )
    }

    /// The vector `value(i)` in each lane `i`.
    #[inline(always)]
    pub fn from_fn(s: S, value: impl Fn(usize) -> Vec3) -> Self {
        let all = s.each(value);
        let component = |k: usize| Float::from_fn(s, |i| all.as_ref()[i][k]);
        Vector::new(component(0), component(1), component(2))
    }

    /// From an array with an element per lane for each component.
    #[inline(always)]
    pub fn load(s: S, [x, y, z]: &[S::Each<f32>; 3]) -> Self {
        Vector::new(Float::load(s, x), Float::load(s, y), Float::load(s, z))
    }

    /// An array with an element per lane for each component.
    #[inline(always)]
    pub fn store(self) -> [S::Each<f32>; 3] {
        [self.x.store(), self.y.store(), self.z.store()]
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> Float<S> {
        self.x.mul_add(o.x, self.y.mul_add(o.y, self.z * o.z))
    }

    /// `self · o + c`.
    #[inline(always)]
    pub fn dot_add(self, o: Self, c: Float<S>) -> Float<S> {
        (self.x).mul_add(o.x, self.y.mul_add(o.y, self.z.mul_add(o.z, c)))
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Vector::new(
            self.y.mul_sub(o.z, self.z * o.y),
            self.z.mul_sub(o.x, self.x * o.z),
            self.x.mul_sub(o.y, self.y * o.x),
        )
    }

    #[inline(always)]
    pub fn length_squared(self) -> Float<S> {
        self.dot(self)
    }

    #[inline(always)]
    pub fn length(self) -> Float<S> {
        self.length_squared().sqrt()
    }

    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.length().recip()
    }

    /// The unit vector, and whether there is one. Elsewhere the vector is unspecified.
    #[inline(always)]
    pub fn try_normalize(self) -> (Self, Mask<S>) {
        let inverse = self.length().recip();
        (self * inverse, inverse.is_finite() & inverse.gt(0.0))
    }

    /// Magnitude of each component.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Vector::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Minimum of each component.
    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Vector::new(self.x.min(o.x), self.y.min(o.y), self.z.min(o.z))
    }

    /// Maximum of each component.
    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Vector::new(self.x.max(o.x), self.y.max(o.y), self.z.max(o.z))
    }

    #[inline(always)]
    pub fn max_component(self) -> Float<S> {
        self.x.max(self.y).max(self.z)
    }

    /// The components by axis.
    #[inline(always)]
    pub fn to_array(self) -> [Float<S>; 3] {
        [self.x, self.y, self.z]
    }

    /// The vector with the z coordinate multiplied by `factor`.
    #[inline(always)]
    pub fn scale_z(self, factor: Float<S>) -> Self {
        Vector {
            z: self.z * factor,
            ..self
        }
    }

    /// `a` in the lanes of `m`, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: Mask<S>, a: Self, b: Self) -> Self {
        Vector::new(m.select(a.x, b.x), m.select(a.y, b.y), m.select(a.z, b.z))
    }
}

impl<S: Width> Color<S> {
    #[inline(always)]
    pub fn new(r: Float<S>, g: Float<S>, b: Float<S>) -> Self {
        Color { r, g, b }
    }

    /// `v` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, v: Rgb) -> Self {
        Color::new(
            Float::splat(s, v.r),
            Float::splat(s, v.g),
            Float::splat(s, v.b),
        )
    }

    #[inline(always)]
    pub fn black(s: S) -> Self {
        Color::splat(s, Rgb::BLACK)
    }

    /// The same value in every channel.
    #[inline(always)]
    pub fn grey(v: Float<S>) -> Self {
        Color::new(v, v, v)
    }

    /// The color `value(i)` in each lane `i`.
    #[inline(always)]
    pub fn from_fn(s: S, value: impl Fn(usize) -> Rgb) -> Self {
        let all = s.each(|i| value(i).to_array());
        let channel = |k: usize| Float::from_fn(s, |i| all.as_ref()[i][k]);
        Color::new(channel(0), channel(1), channel(2))
    }

    /// From an array with an element per lane for each channel.
    #[inline(always)]
    pub fn load(s: S, [r, g, b]: &[S::Each<f32>; 3]) -> Self {
        Color::new(Float::load(s, r), Float::load(s, g), Float::load(s, b))
    }

    /// An array with an element per lane for each channel.
    #[inline(always)]
    pub fn store(self) -> [S::Each<f32>; 3] {
        [self.r.store(), self.g.store(), self.b.store()]
    }

    /// Relative luminance.
    #[inline(always)]
    pub fn luminance(self) -> Float<S> {
        let [r, g, b] = Rgb::LUMINANCE;
        self.r * r + self.g * g + self.b * b
    }

    /// The sum of the channels times these weights, with fused operations where the instruction set
    /// has them.
    #[inline(always)]
    pub(crate) fn weighted_sum(self, [r, g, b]: [f32; 3]) -> Float<S> {
        let last = self.b * b;
        let sum = self.g.mul_add(last.same(g), last);
        self.r.mul_add(last.same(r), sum)
    }

    /// The largest channel.
    #[inline(always)]
    pub fn max_channel(self) -> Float<S> {
        self.r.max(self.g).max(self.b)
    }

    /// Whether every channel is zero.
    #[inline(always)]
    pub fn is_black(self) -> Mask<S> {
        self.r.equals(0.0) & self.g.equals(0.0) & self.b.equals(0.0)
    }

    /// Whether every channel is finite.
    #[inline(always)]
    pub fn is_finite(self) -> Mask<S> {
        self.r.is_finite() & self.g.is_finite() & self.b.is_finite()
    }

    /// Applies `f` to every channel.
    #[inline(always)]
    pub fn map(self, f: impl Fn(Float<S>) -> Float<S>) -> Self {
        Color::new(f(self.r), f(self.g), f(self.b))
    }

    /// Applies `f` to every pair of channels.
    #[inline(always)]
    pub fn zip(self, o: Self, f: impl Fn(Float<S>, Float<S>) -> Float<S>) -> Self {
        Color::new(f(self.r, o.r), f(self.g, o.g), f(self.b, o.b))
    }

    /// Linear interpolation: `self` at `t = 0`, `o` at `t = 1`.
    #[inline(always)]
    pub fn lerp(self, o: Self, t: Float<S>) -> Self {
        self * (1.0 - t) + o * t
    }

    /// The color in the lanes of `m`, black elsewhere.
    #[inline(always)]
    pub fn within(self, m: Mask<S>) -> Self {
        self.map(|v| m.select(v, 0.0))
    }

    /// `a` in the lanes of `m`, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: Mask<S>, a: Self, b: Self) -> Self {
        a.zip(b, |a, b| m.select(a, b))
    }
}

impl<S: Width> Axes<S> {
    /// `frame` in all lanes.
    #[inline(always)]
    pub fn splat(s: S, frame: &Frame) -> Self {
        Axes {
            s: Vector::splat(s, frame.s),
            t: Vector::splat(s, frame.t),
            n: Vector::splat(s, frame.n),
        }
    }

    /// See [`Frame::from_normal`].
    #[inline(always)]
    pub fn from_normal(n: Vector<S>) -> Self {
        let sign = n.z.sign();
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Axes {
            s: Vector::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vector::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// See [`Frame::from_normal_and_tangent`].
    #[inline(always)]
    pub fn from_normal_and_tangent(n: Vector<S>, tangent: Vector<S>) -> Self {
        let (s, is_unit) = (tangent - n * n.dot(tangent)).try_normalize();
        let t = n.cross(s);
        if is_unit.all() {
            return Axes { s, t, n };
        }
        let other = Axes::from_normal(n);
        Axes {
            s: Vector::select(is_unit, s, other.s),
            t: Vector::select(is_unit, t, other.t),
            n,
        }
    }

    /// From world to local coordinates.
    #[inline(always)]
    pub fn to_local(&self, w: Vector<S>) -> Vector<S> {
        Vector::new(self.s.dot(w), self.t.dot(w), self.n.dot(w))
    }

    /// From local to world coordinates.
    #[inline(always)]
    pub fn to_world(&self, w: Vector<S>) -> Vector<S> {
        let along = |s: Float<S>, t: Float<S>, n: Float<S>| s.mul_add(w.x, t.mul_add(w.y, n * w.z));
        Vector::new(
            along(self.s.x, self.t.x, self.n.x),
            along(self.s.y, self.t.y, self.n.y),
            along(self.s.z, self.t.z, self.n.z),
        )
    }
}

macro_rules! by_component {
    ($trait:ident $method:ident: $($name:ident { $($field:ident),* }),*) => {$(
        impl<S: Width> $trait for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                $name { $($field: self.$field.$method(o.$field)),* }
            }
        }
    )*};
}

by_component!(Add add: Pair { x, y }, Vector { x, y, z }, Color { r, g, b });
by_component!(Sub sub: Pair { x, y }, Vector { x, y, z }, Color { r, g, b });
by_component!(Mul mul: Pair { x, y }, Color { r, g, b });
by_component!(Div div: Pair { x, y });

macro_rules! by_factor {
    ($factor:ty: $($name:ident { $($field:ident),* }),*) => {$(
        impl<S: Width> Mul<$factor> for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, o: $factor) -> Self {
                $name { $($field: self.$field * o),* }
            }
        }
    )*};
}

by_factor!(Float<S>: Pair { x, y }, Vector { x, y, z }, Color { r, g, b });
by_factor!(f32: Pair { x, y }, Vector { x, y, z }, Color { r, g, b });

impl<S: Width> Div<Float<S>> for Color<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Float<S>) -> Self {
        self.map(|v| v / o)
    }
}

impl<S: Width> AddAssign for Color<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Width> Neg for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vector::new(-self.x, -self.y, -self.z)
    }
}

impl From<Pair<One>> for Vec2 {
    #[inline(always)]
    fn from(v: Pair<One>) -> Self {
        Vec2::new(v.x.get(), v.y.get())
    }
}

impl From<Vec2> for Pair<One> {
    #[inline(always)]
    fn from(v: Vec2) -> Self {
        Pair::splat(One, v)
    }
}

impl From<Vec3> for Vector<One> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Vector::splat(One, v)
    }
}

impl From<Vector<One>> for Vec3 {
    #[inline(always)]
    fn from(v: Vector<One>) -> Self {
        Vec3::new(v.x.get(), v.y.get(), v.z.get())
    }
}

impl From<Rgb> for Color<One> {
    #[inline(always)]
    fn from(v: Rgb) -> Self {
        Color::splat(One, v)
    }
}

impl From<Color<One>> for Rgb {
    #[inline(always)]
    fn from(v: Color<One>) -> Self {
        Rgb::new(v.r.get(), v.g.get(), v.b.get())
    }
}

impl From<&Frame> for Axes<One> {
    #[inline(always)]
    fn from(frame: &Frame) -> Self {
        Axes::splat(One, frame)
    }
}
