//! Arithmetic of vectors with three components in lanes.

use crate::color::Rgb;
use crate::math::Vec3;
use crate::simd::Width;

/// `v` in all lanes.
#[inline(always)]
pub(crate) fn splat3<L: Width>(s: L, v: Vec3) -> [L::F; 3] {
    [s.splat(v.x), s.splat(v.y), s.splat(v.z)]
}

#[inline(always)]
pub(crate) fn load3<L: Width>(s: L, v: &[L::Each<f32>; 3]) -> [L::F; 3] {
    [s.load(&v[0]), s.load(&v[1]), s.load(&v[2])]
}

#[inline(always)]
pub(crate) fn store3<L: Width>(s: L, v: [L::F; 3]) -> [L::Each<f32>; 3] {
    [s.store(v[0]), s.store(v[1]), s.store(v[2])]
}

/// Magnitude of each component.
#[inline(always)]
pub(crate) fn abs3<L: Width>(s: L, v: [L::F; 3]) -> [L::F; 3] {
    [s.abs(v[0]), s.abs(v[1]), s.abs(v[2])]
}

#[inline(always)]
pub(crate) fn add3<L: Width>(s: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [s.add(a[0], b[0]), s.add(a[1], b[1]), s.add(a[2], b[2])]
}

#[inline(always)]
pub(crate) fn sub3<L: Width>(s: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [s.sub(a[0], b[0]), s.sub(a[1], b[1]), s.sub(a[2], b[2])]
}

#[inline(always)]
pub(crate) fn scale3<L: Width>(s: L, a: [L::F; 3], b: L::F) -> [L::F; 3] {
    [s.mul(a[0], b), s.mul(a[1], b), s.mul(a[2], b)]
}

/// Product by components.
#[inline(always)]
pub(crate) fn mul3<L: Width>(s: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [s.mul(a[0], b[0]), s.mul(a[1], b[1]), s.mul(a[2], b[2])]
}

#[inline(always)]
pub(crate) fn dot<L: Width>(s: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    s.mul_add(a[0], b[0], s.mul_add(a[1], b[1], s.mul(a[2], b[2])))
}

/// Luminance of colors: see [`Rgb::luminance`].
#[inline(always)]
pub(crate) fn luminance<L: Width>(s: L, color: [L::F; 3]) -> L::F {
    dot(s, color, splat3(s, Vec3::from(Rgb::LUMINANCE)))
}
