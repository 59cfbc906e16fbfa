//! Weights of multiple importance sampling.
//!
//! Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.

/// Weight of the balance heuristic for one sample of each of two techniques: `a / (a + b)` for the densities `a`, `b`; 0 for `a = 0`.
#[inline]
pub fn balance(a: f32, b: f32) -> f32 {
    if a > 0.0 { a / (a + b) } else { 0.0 }
}

/// Weight of the power heuristic with exponent 2: `a² / (a² + b²)`; 0 for `a = 0`. The larger density is divided out first, so that
/// squares do not overflow.
#[inline]
pub fn power(a: f32, b: f32) -> f32 {
    if a <= 0.0 {
        0.0
    } else if b > a {
        let r = a / b;
        r * r / (1.0 + r * r)
    } else {
        let r = b / a;
        1.0 / (1.0 + r * r)
    }
}
