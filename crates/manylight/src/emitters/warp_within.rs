//! One-dimensional warps that keep the unit interval.

/// A number in [0, 1] with density proportional to the line from `a` at 0 to `b` at 1; `u` itself if both are 0.
#[inline]
pub(super) fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    if a + b <= 0.0 {
        return u;
    }
    // Inverts the quadratic cumulative density in the form without cancellation.
    (u * (a + b) / (a + (a * a + (b * b - a * a) * u).max(0.0).sqrt())).clamp(0.0, 1.0)
}

/// Whether `u` falls below `p`, and what is left of it: uniform again.
#[inline]
pub(super) fn split(u: f32, p: f32) -> (bool, f32) {
    const LARGEST: f32 = 1.0 - f32::EPSILON * 0.5;
    if u < p {
        (true, (u / p).min(LARGEST))
    } else {
        (false, ((u - p) / (1.0 - p)).clamp(0.0, LARGEST))
    }
}
