//! Russian roulette: the probability to go on. Whoever survives divides by it.

use crate::color::Rgb;

/// For camera walks, as Mitsuba's path tracer has it: the largest channel of the throughput, freed of the η² that
/// refraction puts into radiance, at most 0.95.
#[inline]
pub fn camera_survival(throughput: Rgb, eta_squared: f32) -> f32 {
    (throughput.max_channel() * eta_squared).clamp(0.0, 0.95)
}

/// For photons: the ratio of the largest channels, so that no channel of their flux grows and photon density follows irradiance.
/// (By luminance, a photon would leave a deep blue surface with fourteen times the blue flux that it brought.) Kept below 1, so
/// that walks between perfect mirrors end.
#[inline]
pub fn photon_survival(before: Rgb, after: Rgb) -> f32 {
    let before = before.max_channel();
    if before > 0.0 {
        (after.max_channel() / before).clamp(0.0, 0.99)
    } else {
        0.0
    }
}
