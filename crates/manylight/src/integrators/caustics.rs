//! What specular events throw onto smooth ones: a density estimate over caustic photons.
//!
//! It counts by the part of the kernel that is surface, so that edges and thin tubes keep their light.

use super::eye_path::Gathering;
use super::light_set::LightSet;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::maps::density::{Bandwidth, Receiver, estimate, shrinking};
use crate::maps::{Neighbors, covered};
use crate::sampling::rng;

/// Photons in an estimate.
pub(super) const CAUSTIC_NEIGHBORS: usize = 48;
/// Largest radius of an estimate in pixels, after one pass.
const CAUSTIC_PIXELS: f32 = 72.0;
/// And as a share of the scene's diagonal.
const CAUSTIC_RADIUS: f32 = 0.03;

/// How far estimates at a gathering point look.
pub(super) fn bandwidth(set: &LightSet, point: &Gathering) -> Bandwidth {
    let largest = CAUSTIC_RADIUS * set.scene.geometry.bounds().diagonal();
    Bandwidth {
        largest: point.reach.min(largest),
        share: shrinking(set.passes.end),
    }
}

impl LightSet<'_> {
    /// Density estimate over caustic photons: `Σ_j k_j f Φ_j`, over the covered part of the kernel. On glossy lobes, eye paths
    /// look for what photons bring from other surfaces.
    pub(super) fn caustic_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let x = &point.at.x;
        let n = point.at.lit_from.unwrap_or(x.normal_towards(point.at.wo));
        let receiver = Receiver { p: x.p, n };
        let mut sum = Rgb::BLACK;
        let radius = estimate(
            &self.caustics,
            receiver,
            bandwidth(self, point),
            found,
            |photon, kernel| {
                if self.limits.allow(point.segments + u32::from(photon.depth)) {
                    let lobes = if photon.origin == Lobes::NONE {
                        Lobes::SMOOTH
                    } else {
                        Lobes::DIFFUSE
                    };
                    sum += photon.flux * point.at.bsdf.f(photon.wi, point.at.wo, lobes) * kernel;
                }
            },
        );
        if sum.is_black() {
            return sum;
        }
        // The view names the turn of the probes: it differs in every pass, and not with the scene's unit of length.
        let turn = rng::unit(rng::key(point.at.wo.to_array()));
        sum / covered(&self.scene.geometry, receiver, radius, turn)
    }

    /// Largest radius of an estimate at the end of an eye path of the given length, in m: some pixels.
    pub(super) fn caustic_reach(&self, length: f32) -> f32 {
        CAUSTIC_PIXELS * (self.pixel.0 + self.pixel.1 * length)
    }
}
