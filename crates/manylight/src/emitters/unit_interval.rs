//! Maps of the unit interval to itself.

/// A number in [0, 1] with density proportional to the line from `a` at 0 to `b` at 1; `u` itself if both are 0.
#[inline]
pub(super) fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    if a + b <= 0.0 {
        return u;
    }
    // The quadratic cumulative density is inverted in the form without cancellation.
    (u * (a + b) / (a + (a * a + (b * b - a * a) * u).max(0.0).sqrt())).clamp(0.0, 1.0)
}

/// Whether `u` is below `p`, and a number that is uniform in [0, 1) given that answer.
#[inline]
pub(super) fn split(u: f32, p: f32) -> (bool, f32) {
    const LARGEST: f32 = 1.0 - f32::EPSILON * 0.5;
    if u < p {
        (true, (u / p).min(LARGEST))
    } else {
        (false, ((u - p) / (1.0 - p)).clamp(0.0, LARGEST))
    }
}
