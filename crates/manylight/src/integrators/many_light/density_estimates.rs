//! Density estimates over photons at a gather point: caustics, and compensation photons.
//!
//! Each is divided by the fraction of its kernel that is surface, so that edges and thin tubes keep their light.

use super::caustic_shares::{are_dense, is_shared_with_directions, photon_fraction};
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

/// Largest radius of an estimate in pixel widths, before it shrinks from pass to pass. Unmeasured.
const MAX_RADIUS_PIXELS: f32 = 72.0;
/// Largest radius of an estimate as a fraction of the scene's diagonal, likewise. Unmeasured.
const MAX_RADIUS_FRACTION: f32 = 0.03;

/// `f cosθ` with which a photon counts, in 1/sr.
struct PhotonWeight {
    f_cos: Rgb,
    /// What it counts more where photons with such a part are dense; `None` for other photons.
    f_cos_where_dense: Option<Rgb>,
}

impl From<Rgb> for PhotonWeight {
    fn from(f_cos: Rgb) -> Self {
        PhotonWeight {
            f_cos,
            f_cos_where_dense: None,
        }
    }
}

/// `f cosθ` of the non-specular lobes for a photon, in 1/sr, and the part of the diffuse ones.
#[derive(Clone, Copy)]
struct Reflected {
    f_cos: Rgb,
    diffuse: Rgb,
}

/// Reflection at a point from the unit directions `wi`.
fn reflected_from(at: &ShadingPoint, wi: Vec<Vec3>) -> Vec<Reflected> {
    let ShadingPoint { bsdf, wo, .. } = at;
    let (mut all, mut diffuse) = (Vec::new(), Vec::new());
    bsdf.f_cos_each_wi(&wi, *wo, Lobes::NON_SPECULAR, &mut all);
    if bsdf.lobes().has(Lobes::GLOSSY) {
        bsdf.f_cos_each_wi(&wi, *wo, Lobes::DIFFUSE, &mut diffuse);
    } else {
        diffuse.clone_from(&all);
    }
    let pairs = all.into_iter().zip(diffuse);
    pairs
        .map(|(f_cos, diffuse)| Reflected { f_cos, diffuse })
        .collect()
}

impl PreparedPasses<'_> {
    /// Radiance at a gather point from photons with a specular last event, in W/(m² sr). Of light that other surfaces have
    /// reflected, directions account for a part of what glossy lobes reflect: see [`photon_fraction`].
    pub(super) fn caustic_radiance(&self, point: &GatherPoint, found: &mut Neighbors) -> Rgb {
        let weight = |photon: &Photon, reflected: Reflected| {
            let Reflected { f_cos, diffuse } = reflected;
            if is_shared_with_directions(photon) {
                return PhotonWeight {
                    f_cos: diffuse,
                    f_cos_where_dense: Some((f_cos - diffuse) * photon_fraction(f_cos)),
                };
            }
            (f_cos * direction_fraction(point.direction_limit, f_cos)).into()
        };
        self.density_estimate(&self.caustics, point, found, weight)
    }

    /// Whether caustic photons are dense at a receiver behind `segments` segments of a camera path, for estimates of at most
    /// `largest` m.
    pub(super) fn caustics_are_dense(
        &self,
        receiver: DensityReceiver,
        segments: u32,
        largest: f32,
        found: &mut Neighbors,
    ) -> bool {
        let (mut near, bandwidth) = (0, self.bandwidth(largest));
        density_estimate(&self.caustics, receiver, bandwidth, found, |photon, _| {
            let counts = self.limits.allow(segments + u32::from(photon.depth));
            near += u32::from(counts && is_shared_with_directions(photon));
        });
        are_dense(near, bandwidth)
    }

    /// Radiance at a gather point from compensation photons, in W/(m² sr).
    pub(super) fn compensation_photon_radiance(
        &self,
        point: &GatherPoint,
        found: &mut Neighbors,
    ) -> Rgb {
        let at = &point.at;
        let weight = |photon: &CompensationPhoton, reflected: Reflected| {
            let CompensationPhoton {
                reflected: photon,
                assignment,
            } = *photon;
            let f_cos = reflected.f_cos;
            let fraction = 1.0 - direction_fraction(direction_limit(f_cos), photon.f_cos);
            if fraction == 0.0 {
                return Rgb::BLACK.into();
            }
            // The photon comes from there: its direction is that of the connection.
            let clamped = self.gather.clamped_fraction(
                &self.lights,
                &at.into(),
                &photon.from,
                assignment,
                |_| f_cos,
            );
            (f_cos * (fraction * clamped)).into()
        };
        self.density_estimate(&self.compensation_photons, point, found, weight)
    }

    /// `Σ_j k_j f_j Φ_j` over photons within the path limits, divided by the covered fraction of the kernel. On transmitting
    /// surfaces light arrives on both sides, unless one of them was chosen.
    fn density_estimate<P: OnSurface + AsRef<Photon> + Sync>(
        &self,
        photons: &KdTree<P>,
        point: &GatherPoint,
        found: &mut Neighbors,
        weight: impl Fn(&P, Reflected) -> PhotonWeight,
    ) -> Rgb {
        if point.photon_weight == 0.0 {
            return Rgb::BLACK;
        }
        let ShadingPoint { x, wo, bsdf, .. } = &point.at;
        let visible_side = x.normal_towards(*wo);
        let sum = match point.at.lit_from {
            Some(n) => self.density_on_side(photons, point, n, found, &weight),
            None if bsdf.receiving_normal(*wo).is_none() => {
                self.density_on_side(photons, point, visible_side, found, &weight)
                    + self.density_on_side(photons, point, -visible_side, found, &weight)
            }
            None => self.density_on_side(photons, point, visible_side, found, &weight),
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
        weight: &impl Fn(&P, Reflected) -> PhotonWeight,
    ) -> Rgb {
        let receiver = DensityReceiver { p: point.at.x.p, n };
        let (mut sum, mut sum_where_dense, mut near) = (Rgb::BLACK, Rgb::BLACK, 0u32);
        let bandwidth = self.bandwidth(point.max_photon_radius);
        let mut arriving: Vec<(&P, f32)> = Vec::new();
        let radius = density_estimate(photons, receiver, bandwidth, found, |item, kernel| {
            let photon: &Photon = item.as_ref();
            let cos = photon.wi.dot(point.at.x.ng).abs();
            if cos > 0.0 && self.limits.allow(point.segments + u32::from(photon.depth)) {
                arriving.push((item, kernel / cos));
            }
        });
        let directions = arriving.iter().map(|(item, _)| (*item).as_ref().wi);
        let reflected = reflected_from(&point.at, directions.collect());
        for (&(item, kernel), reflected) in arriving.iter().zip(reflected) {
            let (weight, flux) = (weight(item, reflected), item.as_ref().flux * kernel);
            sum += flux * weight.f_cos;
            if let Some(f_cos) = weight.f_cos_where_dense {
                sum_where_dense += flux * f_cos;
                near += 1;
            }
        }
        // Each photon counts if the others are dense without it: of a Poisson process, that has the expectation of independent
        // photons (Mecke's equation), so that the shares of photons and directions sum to one.
        if near > 0 && are_dense(near - 1, bandwidth) {
            sum += sum_where_dense;
        }
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

    fn bandwidth(&self, max_photon_radius: f32) -> Bandwidth {
        let largest = MAX_RADIUS_FRACTION * self.scene.geometry.bounds().diagonal();
        Bandwidth {
            largest: max_photon_radius.min(largest),
            share: progressive_radius_scale(self.group.passes.end),
        }
    }

    /// Largest radius of an estimate at `distance` m along a camera path, in m.
    pub(super) fn max_photon_radius(&self, distance: f32) -> f32 {
        MAX_RADIUS_PIXELS * self.pixel.width_at(distance)
    }
}
