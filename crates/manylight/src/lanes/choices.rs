//! Choices by uniform numbers, and the weights that combine them, in lanes: [`crate::sampling`] for
//! [`Float`].

use super::numbers::{Float, Mask, Operand, Word};
use super::vector::{Pair, Vector};
use crate::math::float::ONE_MINUS_EPSILON;
use crate::simd::Width;

/// Whether `u` is below `p`, and a number that is uniform in [0, 1) given that answer.
#[inline(always)]
pub(crate) fn split<S: Width>(u: Float<S>, p: impl Operand<S>) -> (Mask<S>, Float<S>) {
    let p = p.float(u.width());
    let is_below = u.lt(p);
    let (part, whole) = (is_below.select(u, u - p), is_below.select(p, 1.0 - p));
    (is_below, (part / whole).clamp(0.0, ONE_MINUS_EPSILON))
}

/// A number in [0, 1] with density proportional to the line from `a` at 0 to `b` at 1; `u` itself
/// if both are 0.
#[inline(always)]
pub(crate) fn sample_linear<S: Width>(u: Float<S>, a: Float<S>, b: Float<S>) -> Float<S> {
    let is_constant = (a + b).le(0.0);
    // The squares would overflow, or vanish.
    let unit = inverse_exponent(a.max(b));
    let (a, b) = (a * unit, b * unit);
    // The quadratic cumulative density is inverted in the form without cancellation.
    let root = (a * a + (b * b - a * a) * u).safe_sqrt();
    let inverse = (u * (a + b) / (a + root)).clamp(0.0, 1.0);
    is_constant.select(u, inverse)
}

/// The power of two that brings a positive number into [1, 2): products with it are exact.
#[inline(always)]
fn inverse_exponent<S: Width>(x: Float<S>) -> Float<S> {
    let exponent = x.to_bits() & 0x7f80_0000;
    (Word::splat(x.width(), 0x7f00_0000) - exponent).to_float()
}

/// See [`warp::triangle`](crate::sampling::warp::triangle).
#[inline(always)]
pub(crate) fn triangle<S: Width>(u: Pair<S>) -> Pair<S> {
    let (x, y) = (u.x * 0.5, u.y * 0.5);
    let is_left = u.x.lt(u.y);
    Pair::new(is_left.select(x, u.x - y), is_left.select(u.y - x, y))
}

/// See [`warp::sphere`](crate::sampling::warp::sphere).
#[inline(always)]
pub(crate) fn sphere<S: Width>(u: Pair<S>) -> Vector<S> {
    let z = 1.0 - 2.0 * u.y;
    let r = (1.0 - z * z).safe_sqrt();
    let (sin, cos) = u.x.sin_cos_turns();
    Vector::new(r * cos, r * sin, z)
}

/// Weight of the power heuristic with exponent 2 for one sample of each of two techniques:
/// `a² / (a² + b²)` for the densities `a`, `b`; 0 for `a = 0`. The larger density is divided out
/// first, so that squares do not overflow.
///
/// Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.
#[inline(always)]
pub(crate) fn power<S: Width>(a: Float<S>, b: Float<S>) -> Float<S> {
    let is_less = a.lt(b);
    let r = is_less.select(a, b) / is_less.select(b, a);
    let r2 = r * r;
    let weight = is_less.select(r2, 1.0) / (1.0 + r2);
    a.gt(0.0).select(weight, 0.0)
}
