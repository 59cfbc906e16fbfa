//! Russian roulette: probabilities to continue a path. Surviving paths divide their throughput by
//! them.

use crate::lanes::{Color, Float, Width};

/// For camera paths: the largest channel of the throughput without the η² that refraction puts into
/// radiance, at most 0.95. This is Mitsuba's rule.
#[inline(always)]
pub(crate) fn camera_survivals<S: Width>(throughput: Color<S>, eta_squared: Float<S>) -> Float<S> {
    (throughput.max_channel() * eta_squared).clamp(0.0, 0.95)
}

/// For photons: the ratio of the largest channels of flux after and before the event, at most 0.99
/// so that walks between perfect mirrors end. Below that bound no channel exceeds the largest one
/// before the event, and photon density follows irradiance. (By luminance, a photon would leave a
/// deep blue surface with fourteen times the blue flux that arrived.)
#[inline(always)]
pub(crate) fn photon_survivals<S: Width>(before: Color<S>, after: Color<S>) -> Float<S> {
    let before = before.max_channel();
    let survival = (after.max_channel() / before).clamp(0.0, 0.99);
    before.gt(0.0).select(survival, 0.0)
}
