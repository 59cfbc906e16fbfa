//! Russian roulette: probabilities to continue a path. Surviving paths divide their throughput by them.

use crate::color::Rgb;

/// For camera walks: the largest channel of the throughput without the η² that refraction puts into radiance, at most 0.95.
/// This is Mitsuba's rule.
#[inline]
pub fn camera_survival(throughput: Rgb, eta_squared: f32) -> f32 {
    (throughput.max_channel() * eta_squared).clamp(0.0, 0.95)
}

/// For photons: the ratio of the largest channels of flux after and before the event, at most 0.99 so that walks between
/// perfect mirrors end. No channel of the flux grows, and photon density follows irradiance. (By luminance, a photon would
/// leave a deep blue surface with fourteen times the blue flux that arrived.)
#[inline]
pub fn photon_survival(before: Rgb, after: Rgb) -> f32 {
    let before = before.max_channel();
    if before > 0.0 {
        (after.max_channel() / before).clamp(0.0, 0.99)
    } else {
        0.0
    }
}
