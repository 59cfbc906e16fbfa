//! The balance heuristic between chains of directions and caustic photons: docs/path_partition.md.
//!
//! Sources: Georgiev et al., "Light Transport Simulation with Vertex Connection and Merging", 2012,
//! and Hachisuka et al., "A Path Space Extension for Robust Light Transport Simulation", 2012.

use crate::color::Rgb;

/// Ratio of the photons in a kernel to the directions times `f` at which both account for one half
/// of the light of other surfaces that comes by a specular chain; in sr. The balance heuristic gives
/// π for photons that arrive evenly from a hemisphere; a smaller ratio prefers photons, because a
/// direction that finds a surface costs a gather point. At 0.25 and 1 for
/// glossy lobes (2 passes at 256x144 and 192x192; kitchen and staircase2 of third parties): error
/// after Open Image Denoise 0.0 and 0.0 %, +1.7 and -1.3 %. At 2 and 8 for diffuse lobes: -0.4 and
/// -1.0 %, -0.6 and -1.2 %, with 1 to 10 % more time.
const PHOTONS_PER_RESPONSE: f32 = 0.5;

/// Factor on the density of photons of emitters. A photon is common to the pixels of its kernel and
/// to the passes of a group, and what neighbors share survives a filter. At 1 (2 passes at 256x144
/// and 192x192; kitchen and staircase2 of third parties): error after Open Image Denoise +0.6 and +6
/// %, at 0.01 +0.2 and 0.0 %.
const PHOTON_WEIGHT: f32 = 0.1;

/// Densities of directions at a gather point, and of photons in its kernel, by which both share the
/// light that arrives at a class of lobes from a direction by specular events.
///
/// Photons arrive in proportion to `cosθ` and directions to `f cosθ`, so that both densities are
/// relative to `cosθ`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainDensities {
    /// Of directions, in 1/sr: their number times `f`.
    pub(super) directions: f32,
    /// Area of the kernel, in m².
    pub(super) kernel: f32,
    /// Photons from other surfaces in the kernel, besides the one that is weighed.
    pub(super) others: u32,
    /// Part of the light of emitters for which directions and caustic photons account together.
    pub(super) of_emitters: f32,
}

impl ChainDensities {
    /// The fraction for which directions account of the light of other surfaces; photons account
    /// for the rest.
    ///
    /// It is the balance heuristic for photons that arrive from all directions alike. Photons count
    /// the others: of a Poisson process, that has the expectation of independent photons (Mecke's
    /// equation), so that the fractions of photons and directions sum to one. A photon that is
    /// alone in its kernel counts nothing.
    pub(super) fn surface_fraction(&self) -> f32 {
        let photons = self.others as f32;
        match photons > 0.0 {
            true => self.share(photons / PHOTONS_PER_RESPONSE),
            false => 1.0,
        }
    }

    /// The fraction for which directions account of the light of an emitter, on rays where its
    /// photons have this density in 1/(m² sr).
    pub(super) fn emission_fraction(&self, ray_density: f32) -> f32 {
        self.of_emitters * self.share(PHOTON_WEIGHT * ray_density * self.kernel)
    }

    /// The fraction of the light of an emitter for which photons account.
    pub(super) fn photon_emission_fraction(&self, ray_density: f32) -> f32 {
        self.of_emitters - self.emission_fraction(ray_density)
    }

    /// The balance heuristic, against photons of this density in 1/sr.
    fn share(&self, photons: f32) -> f32 {
        match self.directions > 0.0 && photons.is_finite() {
            true => self.directions / (self.directions + photons),
            false => 0.0,
        }
    }
}

/// How directions share the light that a chain finds with the photons of each class of lobes at its
/// start.
#[derive(Clone, Copy, Debug)]
pub(super) struct SharedLight {
    /// Of the diffuse lobes, if there are any.
    pub(super) diffuse: Option<ChainDensities>,
    /// Of the glossy lobes, if there are any.
    pub(super) glossy: Option<ChainDensities>,
    /// The part of the reflected light that glossy lobes reflect.
    pub(super) glossy_fraction: Rgb,
}

impl SharedLight {
    /// The fraction of the light of other surfaces for which directions account.
    pub(super) fn surface_fraction(&self) -> Rgb {
        self.mean(ChainDensities::surface_fraction)
    }

    /// The fraction of the light of an emitter for which directions account, on rays where its
    /// photons have this density in 1/(m² sr).
    pub(super) fn emission_fraction(&self, ray_density: f32) -> Rgb {
        self.mean(|densities| densities.emission_fraction(ray_density))
    }

    /// The mean over the lobes, weighted by what they reflect.
    fn mean(&self, fraction: impl Fn(&ChainDensities) -> f32) -> Rgb {
        let of = |densities: &Option<ChainDensities>| densities.as_ref().map_or(0.0, &fraction);
        (self.glossy_fraction).map(|g| g * of(&self.glossy) + (1.0 - g) * of(&self.diffuse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DENSITIES: ChainDensities = ChainDensities {
        directions: 4.0,
        kernel: 0.5,
        others: 6,
        of_emitters: 1.0,
    };

    #[test]
    fn directions_and_photons_share_by_their_densities() {
        // 0.5 * 12 = 6 weighted photons per sr against 4 directions per sr.
        let density = 12.0 / PHOTON_WEIGHT;
        assert!((DENSITIES.emission_fraction(density) - 0.4).abs() < 1e-6);
        assert!((DENSITIES.photon_emission_fraction(density) - 0.6).abs() < 1e-6);
        let part = ChainDensities {
            of_emitters: 0.25,
            ..DENSITIES
        };
        let both = part.emission_fraction(density) + part.photon_emission_fraction(density);
        assert!((both - 0.25).abs() < 1e-6);
        assert!((part.surface_fraction() - DENSITIES.surface_fraction()).abs() < 1e-6);
    }

    #[test]
    fn whoever_is_alone_accounts_for_all() {
        let alone = ChainDensities {
            others: 0,
            ..DENSITIES
        };
        assert_eq!(alone.surface_fraction(), 1.0);
        assert_eq!(alone.emission_fraction(0.0), 1.0);
        assert_eq!(DENSITIES.emission_fraction(f32::INFINITY), 0.0);
        let empty = ChainDensities {
            kernel: 0.0,
            ..DENSITIES
        };
        assert_eq!(empty.emission_fraction(f32::INFINITY), 0.0);
        let dark = ChainDensities {
            directions: 0.0,
            ..DENSITIES
        };
        assert_eq!(dark.emission_fraction(12.0), 0.0);
    }
}
