//! Multiple importance sampling: weights, nothing else.
//!
//! Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.

/// Balance heuristic for one sample each: `a / (a + b)`.
#[inline]
pub fn balance(a: f32, b: f32) -> f32 {
    if a > 0.0 { a / (a + b) } else { 0.0 }
}

/// Power heuristic with exponent 2. Divides by the larger pdf first, so that infinite squares cannot occur.
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
