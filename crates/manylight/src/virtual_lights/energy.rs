//! Energy account of a set of lights.

use crate::color::Rgb;

/// Where the flux of the photons of a set went: a check of the partition and of the glossy profiles. All in W per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// Incident flux of all photons.
    pub photons: [f64; 3],
    /// Incident flux represented by the lights.
    pub lights: [f64; 3],
    /// Incident flux of the unassigned photons, before thinning.
    pub unassigned: [f64; 3],
    /// Flux that the glossy profiles should emit, by samples of the lobes.
    pub reflected: [f64; 3],
    /// Flux that the glossy profiles emit: their integrals.
    pub glossy: [f64; 3],
}

/// Adds `flux * scale` to `sum`.
pub(super) fn add(sum: &mut [f64; 3], flux: Rgb, scale: f64) {
    for (s, f) in sum.iter_mut().zip(flux.to_array()) {
        *s += f64::from(f) * scale;
    }
}
