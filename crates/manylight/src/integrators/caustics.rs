//! What specular events throw onto smooth ones: a density estimate over caustic photons.
//!
//! It counts by the part of the kernel that is surface, so that edges and thin tubes keep their light.

use super::carried::share_of_directions;
use super::eye_path::GatherPoint;
use super::light_set::PreparedPasses;
use super::partition::Stage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::maps::density::{
    Bandwidth, DensityReceiver, density_estimate, progressive_radius_scale,
};
use crate::maps::{
    COVERAGE_PROBES, COVERAGE_PROBES_INDIRECT, KdTree, Located, Neighbors, covered_fraction,
};
use crate::particles::Photon;
use crate::sampling::rng;

/// Photons in an estimate.
pub(super) const CAUSTIC_NEIGHBORS: usize = 48;
/// Largest radius of an estimate in pixels, after one pass.
const CAUSTIC_PIXELS: f32 = 72.0;
/// And as a share of the scene's diagonal.
const CAUSTIC_RADIUS: f32 = 0.03;

/// How far estimates at a gathering point look.
fn bandwidth(set: &PreparedPasses, point: &GatherPoint) -> Bandwidth {
    let largest = CAUSTIC_RADIUS * set.scene.geometry.bounds().diagonal();
    Bandwidth {
        largest: point.reach.min(largest),
        share: progressive_radius_scale(set.passes.end),
    }
}

impl PreparedPasses<'_> {
    /// What photons whose last event was specular bring to a gathering point. On glossy lobes, eye paths look for what they
    /// bring from other surfaces.
    pub(super) fn caustic_radiance(&self, point: &GatherPoint, found: &mut Neighbors) -> Rgb {
        let (bsdf, wo) = (&point.at.bsdf, point.at.wo);
        self.density_estimate(&self.caustics, point, found, |photon: &Photon| {
            if photon.origin != Lobes::NONE {
                return bsdf.f(photon.wi, wo, Lobes::DIFFUSE);
            }
            let f_cos = bsdf.f_cos_wi(photon.wi, wo, Lobes::NON_SPECULAR);
            bsdf.f(photon.wi, wo, Lobes::NON_SPECULAR) * share_of_directions(point.broad, f_cos)
        })
    }

    /// Density estimate over photons that fit the path limits: `Σ_j k_j f_j Φ_j`, over the covered part of the kernel.
    pub(super) fn density_estimate<P: Located + AsRef<Photon> + Sync>(
        &self,
        photons: &KdTree<P>,
        point: &GatherPoint,
        found: &mut Neighbors,
        f: impl Fn(&P) -> Rgb,
    ) -> Rgb {
        if point.photons == 0.0 {
            return Rgb::BLACK;
        }
        let x = &point.at.x;
        let n = point.at.lit_from.unwrap_or(x.normal_towards(point.at.wo));
        let receiver = DensityReceiver { p: x.p, n };
        let mut sum = Rgb::BLACK;
        let bandwidth = bandwidth(self, point);
        let radius = density_estimate(photons, receiver, bandwidth, found, |item, kernel| {
            let photon: &Photon = item.as_ref();
            if self.limits.allow(point.segments + u32::from(photon.depth)) {
                sum += photon.flux * f(item) * kernel;
            }
        });
        if sum.is_black() {
            return sum;
        }
        // The view names the turn of the probes: it differs in every pass, and not with the scene's unit of length.
        let turn = rng::unit(rng::key(point.at.wo.to_array()));
        let probes = match point.stage {
            Stage::BeforeX => COVERAGE_PROBES,
            Stage::AfterX | Stage::Decided(_) => COVERAGE_PROBES_INDIRECT,
        };
        sum * (point.photons
            / covered_fraction(&self.scene.geometry, receiver, radius, probes, turn))
    }

    /// Largest radius of an estimate at the end of an eye path of the given length, in m: some pixels.
    pub(super) fn caustic_reach(&self, length: f32) -> f32 {
        CAUSTIC_PIXELS * (self.pixel.0 + self.pixel.1 * length)
    }
}
