//! Density estimates over photons at a gather point: caustics, and compensation photons.
//!
//! Each is divided by the fraction of its kernel that is surface, so that edges and thin tubes keep their light.

use super::compensation_photons::{CompensationPhoton, direction_fraction, direction_limit};
use super::gather_points::GatherPoint;
use super::prepared::PreparedPasses;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::gather::ShadingPoint;
use crate::integrators::partition::PathStage;
use crate::maps::density::{
    Bandwidth, DensityReceiver, OnSurface, density_estimate, progressive_radius_scale,
};
use crate::maps::{COVERAGE_PROBES, COVERAGE_PROBES_INDIRECT, KdTree, Neighbors, covered_fraction};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::rng;

/// Photons in an estimate. Unmeasured: more of them blur, fewer of them show single photons.
pub(super) const PHOTON_NEIGHBORS: usize = 48;
/// Largest radius of an estimate in pixel widths, before it shrinks from pass to pass. Unmeasured.
const MAX_RADIUS_PIXELS: f32 = 72.0;
/// Largest radius of an estimate as a fraction of the scene's diagonal, likewise. Unmeasured.
const MAX_RADIUS_FRACTION: f32 = 0.03;

impl PreparedPasses<'_> {
    /// Radiance at a gather point from photons with a specular last event, in W/(m² sr). Of light that other surfaces have
    /// reflected, only the diffuse lobes' part: camera paths find that of glossy lobes.
    pub(super) fn caustic_radiance(&self, point: &GatherPoint, found: &mut Neighbors) -> Rgb {
        let (bsdf, wo) = (&point.at.bsdf, point.at.wo);
        self.density_estimate(&self.caustics, point, found, |photon: &Photon| {
            if photon.origin != Lobes::NONE {
                return bsdf.f(photon.wi, wo, Lobes::DIFFUSE);
            }
            let f_cos = bsdf.f_cos_wi(photon.wi, wo, Lobes::NON_SPECULAR);
            bsdf.f(photon.wi, wo, Lobes::NON_SPECULAR)
                * direction_fraction(point.direction_limit, f_cos)
        })
    }

    /// Radiance at a gather point from compensation photons, in W/(m² sr).
    pub(super) fn compensation_photon_radiance(
        &self,
        point: &GatherPoint,
        found: &mut Neighbors,
    ) -> Rgb {
        let at = &point.at;
        let weighted_f = |photon: &CompensationPhoton| {
            let CompensationPhoton {
                reflected,
                assignment,
            } = *photon;
            let wi = reflected.photon.wi;
            let f_cos = |w| at.bsdf.f_cos_wi(w, at.wo, Lobes::NON_SPECULAR);
            let limit = direction_limit(f_cos(wi));
            let fraction = 1.0 - direction_fraction(limit, reflected.f_cos);
            if fraction == 0.0 {
                return Rgb::BLACK;
            }
            let clamped = self.gather.clamped_fraction(
                &self.lights,
                &at.into(),
                &reflected.from,
                assignment,
                f_cos,
            );
            at.bsdf.f(wi, at.wo, Lobes::NON_SPECULAR) * (fraction * clamped)
        };
        self.density_estimate(&self.compensation_photons, point, found, weighted_f)
    }

    /// `Σ_j k_j f_j Φ_j` over photons within the path limits, divided by the covered fraction of the kernel. On transmitting
    /// surfaces light arrives on both sides, unless one of them was chosen.
    fn density_estimate<P: OnSurface + AsRef<Photon> + Sync>(
        &self,
        photons: &KdTree<P>,
        point: &GatherPoint,
        found: &mut Neighbors,
        f: impl Fn(&P) -> Rgb,
    ) -> Rgb {
        if point.photon_weight == 0.0 {
            return Rgb::BLACK;
        }
        let ShadingPoint { x, wo, bsdf, .. } = &point.at;
        let visible_side = x.normal_towards(*wo);
        let sum = match point.at.lit_from {
            Some(n) => self.density_on_side(photons, point, n, found, &f),
            None if bsdf.receiving_normal(*wo).is_none() => {
                self.density_on_side(photons, point, visible_side, found, &f)
                    + self.density_on_side(photons, point, -visible_side, found, &f)
            }
            None => self.density_on_side(photons, point, visible_side, found, &f),
        };
        sum * point.photon_weight
    }

    /// That sum over the photons that arrive on the side of the unit normal `n`.
    fn density_on_side<P: OnSurface + AsRef<Photon> + Sync>(
        &self,
        photons: &KdTree<P>,
        point: &GatherPoint,
        n: Vec3,
        found: &mut Neighbors,
        f: &impl Fn(&P) -> Rgb,
    ) -> Rgb {
        let receiver = DensityReceiver { p: point.at.x.p, n };
        let mut sum = Rgb::BLACK;
        let bandwidth = self.bandwidth(point);
        let radius = density_estimate(photons, receiver, bandwidth, found, |item, kernel| {
            let photon: &Photon = item.as_ref();
            if self.limits.allow(point.segments + u32::from(photon.depth)) {
                sum += photon.flux * f(item) * kernel;
            }
        });
        if sum.is_black() {
            return sum;
        }
        // The turn of the probe pattern is a hash of `wo`, which differs from pass to pass and does not depend on the unit of length.
        let turn = rng::unit(rng::key(point.at.wo.to_array()));
        let probes = match point.stage {
            PathStage::BeforeX => COVERAGE_PROBES,
            PathStage::AfterX | PathStage::Decided(_) => COVERAGE_PROBES_INDIRECT,
        };
        sum / covered_fraction(&self.scene.geometry, receiver, radius, probes, turn)
    }

    fn bandwidth(&self, point: &GatherPoint) -> Bandwidth {
        let largest = MAX_RADIUS_FRACTION * self.scene.geometry.bounds().diagonal();
        Bandwidth {
            largest: point.max_photon_radius.min(largest),
            share: progressive_radius_scale(self.group.passes.end),
        }
    }

    /// Largest radius of an estimate at `distance` m along a camera path, in m.
    pub(super) fn max_photon_radius(&self, distance: f32) -> f32 {
        MAX_RADIUS_PIXELS * self.pixel.width_at(distance)
    }
}
