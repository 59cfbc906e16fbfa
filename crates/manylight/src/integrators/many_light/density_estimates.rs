//! Density estimates over photons at gather points: caustics, and compensation photons.
//!
//! Caustic photons and sampled directions share what glossy lobes see by specular chains. Both can
//! find the light that other surfaces send through specular events. On a lobe of low roughness
//! single photons show, while directions find small mirrors rarely. Photons count the fraction
//! [`photon_fraction`] of the light of a path where [`are_dense`] holds, and directions the rest:
//! docs/path_partition.md.

use super::PreparedPasses;
use super::compensation_photons::{CompensationPhoton, direction_fraction, direction_limit};
use super::gather_point::{GatherPath, GatherPoint};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::integrators::partition::PathStage;
use crate::maps::density::{
    Bandwidth, DensityReceiver, OnSurface, density_estimate, progressive_radius_scale,
};
use crate::maps::{
    ArrivingPhotons, COVERAGE_PROBES, COVERAGE_PROBES_INDIRECT, KdTree, Neighbors, PhotonReceiver,
};
use crate::math::Vec3;
use crate::particles::Photon;

/// Caustic photons in a kernel, before it shrinks from pass to pass, from which on they are dense
/// enough for glossy lobes. Measured at 3 and 8, over 2 passes at 320x180: the variance of caustics
/// in the Disco is 0.017 of relMSE for both, and 0.0016 and 0.0011 of means of 16x16 pixels; with
/// directions for all glossy light 0.020 and 0.0011. With 24, photons hardly count.
const DENSE_PHOTONS: f32 = 8.0;
/// Largest `f cosθ`, in 1/sr, up to which photons account for all light that a glossy lobe sees by
/// a specular chain, where photons are dense. Diffuse surfaces reflect at most `1/π`. Measured at 1
/// and 4, over 2 passes at 320x180: the same variance of caustics in the Disco within 2 %.
const CAUSTIC_PHOTON_LIMIT: f32 = 1.0;
/// Largest radius of an estimate in pixel widths, before it shrinks from pass to pass. At 36 and
/// 144 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, Garage): the same picture.
/// In pictures as small as these, the bound by the diagonal is smaller.
const MAX_RADIUS_PIXELS: f32 = 72.0;
/// Largest radius of an estimate as a fraction of the scene's diagonal, likewise. At 0.015 and 0.06
/// (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE +2.7 and -0.7 %
/// (standard error 2 %).
const MAX_RADIUS_FRACTION: f32 = 0.03;

/// Fraction of the light reflected by glossy lobes for which caustic photons account, where photons
/// are dense and the non-specular lobes reflect it with `f_cos`, in 1/sr.
pub(super) fn photon_fraction(f_cos: Rgb) -> f32 {
    (CAUSTIC_PHOTON_LIMIT / f_cos.max_channel()).min(1.0)
}

/// Whether directions may account for the light of a caustic photon, too: other surfaces have
/// reflected it.
fn is_shared_with_directions(photon: &Photon) -> bool {
    photon.origin != Lobes::NONE
}

/// Whether `near` photons in a kernel are dense. The number falls as the kernel shrinks from pass
/// to pass.
fn are_dense(near: u32, bandwidth: Bandwidth) -> bool {
    near as f32 >= DENSE_PHOTONS * bandwidth.share * bandwidth.share
}

/// Whether caustic photons are dense at a receiver at the end of `path`.
pub(super) fn caustics_are_dense(
    prepared: &PreparedPasses,
    receiver: DensityReceiver,
    path: &GatherPath,
    found: &mut Neighbors,
) -> bool {
    let (mut near, bandwidth) = (0, bandwidth(prepared, path));
    density_estimate(
        &prepared.caustics,
        receiver,
        bandwidth,
        found,
        |photon, _| {
            let counts = (prepared.limits).allow(path.segments + u32::from(photon.depth));
            near += u32::from(counts && is_shared_with_directions(photon));
        },
    );
    are_dense(near, bandwidth)
}

/// Radiance at a gather point from photons with a specular last event, in W/(m² sr). Of light that
/// other surfaces have reflected, directions account for a part of what glossy lobes reflect.
pub(super) fn caustic_radiance(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    found: &mut Neighbors,
) -> Rgb {
    let bandwidth = bandwidth(prepared, &point.path);
    let limit = point.role.direction_limit();
    let is_glossy = point.at.bsdf.lobes().has(Lobes::GLOSSY);
    estimate(prepared, &prepared.caustics, point, found, |arriving| {
        let all = arriving.f_cos(Lobes::NON_SPECULAR);
        let diffuse = match is_glossy {
            true => arriving.f_cos(Lobes::DIFFUSE),
            false => all.clone(),
        };
        let (mut sum, mut sum_where_dense, mut near) = (Rgb::BLACK, Rgb::BLACK, 0u32);
        for ((photon, kernel), (f_cos, diffuse)) in
            arriving.iter().zip(all.into_iter().zip(diffuse))
        {
            let flux = photon.flux * kernel;
            if is_shared_with_directions(photon) {
                sum += flux * diffuse;
                sum_where_dense += flux * ((f_cos - diffuse) * photon_fraction(f_cos));
                near += 1;
            } else {
                sum += flux * (f_cos * direction_fraction(limit, f_cos));
            }
        }
        // Each photon counts if the others are dense without it: of a Poisson process, that has the
        // expectation of independent photons (Mecke's equation), so that the shares of photons and
        // directions sum to one.
        if near > 0 && are_dense(near - 1, bandwidth) {
            sum += sum_where_dense;
        }
        sum
    })
}

/// Radiance at a gather point from compensation photons, in W/(m² sr).
pub(super) fn compensation_photon_radiance(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    found: &mut Neighbors,
) -> Rgb {
    let photons = &prepared.compensation_photons;
    estimate(prepared, photons, point, found, |arriving| {
        let mut sum = Rgb::BLACK;
        arriving.each(Lobes::NON_SPECULAR, |photon, f_cos, kernel| {
            let CompensationPhoton {
                reflected,
                assignment,
            } = photon;
            let fraction = 1.0 - direction_fraction(direction_limit(f_cos), reflected.f_cos);
            if fraction == 0.0 {
                return;
            }
            // The photon comes from there: its direction is that of the connection.
            let (at, from) = ((&point.at).into(), &reflected.from);
            let (gather, lights) = (&prepared.gather, &prepared.lights);
            let clamped = gather.clamped_fraction(lights, &at, from, *assignment, |_| f_cos);
            sum += reflected.photon.flux * kernel * (f_cos * (fraction * clamped));
        });
        sum
    })
}

/// A sum over the photons that arrive at a gather point, divided by the covered fraction of the
/// kernel. On transmitting surfaces light arrives on both sides, unless one of them was chosen.
fn estimate<P: OnSurface + Sync>(
    prepared: &PreparedPasses,
    photons: &KdTree<P>,
    point: &GatherPoint,
    found: &mut Neighbors,
    sum: impl Fn(&ArrivingPhotons<P>) -> Rgb,
) -> Rgb {
    let weight = point.role.photon_weight();
    if weight == 0.0 {
        return Rgb::BLACK;
    }
    let (x, bsdf, wo) = (&point.at.x, &point.at.bsdf, point.at.wo);
    let receiver = PhotonReceiver {
        x,
        bsdf,
        wo,
        segments: point.path.segments,
        limits: prepared.limits,
    };
    let bandwidth = bandwidth(prepared, &point.path);
    let probes = match point.path.stage {
        PathStage::BeforeX => COVERAGE_PROBES,
        PathStage::AfterX | PathStage::Decided(_) => COVERAGE_PROBES_INDIRECT,
    };
    let mut on_side = |n: Vec3| {
        let arriving = ArrivingPhotons::around(photons, receiver, n, bandwidth, found);
        let sum = sum(&arriving);
        match sum.is_black() {
            true => sum,
            false => sum / arriving.covered(&prepared.scene.geometry, probes),
        }
    };
    let visible_side = x.normal_towards(wo);
    let sum = match point.at.lit_from {
        Some(n) => on_side(n),
        None if bsdf.receiving_normal(wo).is_none() => {
            on_side(visible_side) + on_side(-visible_side)
        }
        None => on_side(visible_side),
    };
    sum * weight
}

fn bandwidth(prepared: &PreparedPasses, path: &GatherPath) -> Bandwidth {
    let largest = MAX_RADIUS_FRACTION * prepared.scene.geometry.bounds().diagonal();
    Bandwidth {
        largest: path.max_photon_radius.min(largest),
        share: progressive_radius_scale(prepared.group.passes.end),
    }
}

/// Largest radius of an estimate at `distance` m along a camera path, in m.
pub(super) fn max_photon_radius(prepared: &PreparedPasses, distance: f32) -> f32 {
    MAX_RADIUS_PIXELS * prepared.pixel.width_at(distance)
}
