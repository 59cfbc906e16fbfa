//! Density estimates over photons at gather points: caustics, and compensation photons.
//!
//! Caustic photons and chains of directions share the light that arrives by specular events. Single
//! photons show as discs, while directions rarely find small mirrors and small emitters. Both
//! account for a part of each path, by the balance heuristic: docs/path_partition.md.
//!
//! A kernel blurs what a glossy lobe reflects by the angle under which its radius is seen from the
//! surface behind the chain. So kernels of glossy lobes are a few pixels wide.

use super::PreparedPasses;
use super::chain_densities::{ChainDensities, SharedLight};
use super::compensation_photons::{CompensationPhoton, direction_fraction, direction_limit};
use super::gather_point::{DIRECTIONS, GatherPath, GatherPoint, GatherRole};
use super::passes::PixelFootprint;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::integrators::light_groups::RadianceByGroup;
use crate::integrators::partition::PathStage;
use crate::maps::density::{
    Bandwidth, DensityReceiver, OnSurface, density_estimate, progressive_radius_scale,
};
use crate::maps::{
    ArrivingPhotons, COVERAGE_PROBES, COVERAGE_PROBES_INDIRECT, KdTree, Neighbors, PhotonReceiver,
};
use crate::math::Vec3;
use crate::particles::Photon;
use std::f32::consts::PI;

/// Largest radius of a kernel of glossy lobes, relative to that of diffuse lobes: 8 pixel widths at
/// the first gather points of camera paths. At half and double (2 passes at 256x144 and 192x192;
/// kitchen and staircase2 of third parties): error after Open Image Denoise -1.2 and +1.1 %, -1.7
/// and +1.7 %; classroom at double -0.9 %. Half leaves a quarter of the photons in a kernel for light
/// that photons alone find.
const GLOSSY_RADIUS_FRACTION: f32 = 1.0 / 9.0;
/// Smallest cosine by which densities are divided.
const MIN_COS: f32 = 1e-4;
/// Largest radius of an estimate in pixel widths, before it shrinks from pass to pass. At 36 and
/// 144 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, Garage): the same picture.
/// In pictures as small as these, the bound by the diagonal is smaller.
const MAX_RADIUS_PIXELS: f32 = 72.0;
/// Largest radius of an estimate as a fraction of the scene's diagonal, likewise. At 0.015 and 0.06
/// (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE +2.7 and -0.7 %
/// (standard error 2 %).
const MAX_RADIUS_FRACTION: f32 = 0.03;

/// The classes of lobes that have kernels of their own.
const CLASSES: [Lobes; 2] = [Lobes::DIFFUSE, Lobes::GLOSSY];

/// A direction from which light arrives at a gather point.
#[derive(Clone, Copy, Debug)]
pub(super) struct IncidentDirection {
    /// Unit vector.
    pub(super) wi: Vec3,
    /// `f cosθ` of the non-specular lobes, in 1/sr.
    pub(super) f_cos: Rgb,
}

/// A kernel of caustic photons.
#[derive(Clone, Copy, Debug)]
struct CausticKernel {
    /// Radius, in m.
    radius: f32,
    /// Number of its photons from surfaces, besides the one that is weighed.
    others: u32,
}

/// Whether virtual lights carry the light of a caustic photon to the surface behind the chain:
/// other surfaces have reflected it. Light of the others is emitted behind the chain.
fn is_of_surface(photon: &Photon) -> bool {
    photon.origin != Lobes::NONE
}

/// How directions share the light of a chain with caustic photons: the densities of each class of
/// lobes at the gather point where the light of the chain arrives.
pub(super) fn shared_light(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    incident: IncidentDirection,
    found: &mut Neighbors,
) -> SharedLight {
    let (bsdf, wo) = (&point.at.bsdf, point.at.wo);
    let mut of_lobes = |lobes: Lobes| {
        let has_lobes = bsdf.lobes().has(lobes);
        has_lobes.then(|| densities_at_direction(prepared, point, incident, lobes, found))
    };
    let [diffuse, glossy] = CLASSES.map(&mut of_lobes);
    let glossy_fraction = match (diffuse, glossy) {
        (_, None) => Rgb::BLACK,
        (None, Some(_)) => Rgb::WHITE,
        (Some(_), Some(_)) => {
            let f = |lobes| bsdf.f(incident.wi, wo, lobes);
            f(Lobes::GLOSSY).zip(f(Lobes::NON_SPECULAR), |part, all| {
                if all > 0.0 { part / all } else { 0.0 }
            })
        }
    };
    SharedLight {
        diffuse,
        glossy,
        glossy_fraction,
    }
}

/// The densities for one class of lobes, at the gather point where the light of a chain arrives.
fn densities_at_direction(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    incident: IncidentDirection,
    lobes: Lobes,
    found: &mut Neighbors,
) -> ChainDensities {
    let (x, path) = (&point.at.x, &point.path);
    let receiver = DensityReceiver {
        p: x.p,
        n: x.normal_towards(incident.wi),
    };
    let (mut others, bandwidth) = (0, caustic_bandwidth(prepared, path, lobes));
    let caustics = &prepared.caustics;
    let radius = density_estimate(caustics, receiver, bandwidth, found, |photon, _| {
        let counts = (prepared.limits).allow(path.segments + u32::from(photon.depth));
        others += u32::from(counts && is_of_surface(photon));
    });
    densities(point, incident, CausticKernel { radius, others })
}

/// The densities for light that arrives at a gather point.
fn densities(
    point: &GatherPoint,
    IncidentDirection { wi, f_cos }: IncidentDirection,
    CausticKernel { radius, others }: CausticKernel,
) -> ChainDensities {
    let count = match point.role {
        GatherRole::FirstVertex(_) => DIRECTIONS,
        GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1,
    };
    let cos = wi.dot(point.at.x.ng).abs().max(MIN_COS);
    ChainDensities {
        directions: count as f32 * f_cos.max_channel() / cos,
        kernel: PI * radius * radius,
        others,
        of_emitters: direction_fraction(point.role.direction_limit(), f_cos),
    }
}

/// Radiance at a gather point from photons with a specular last event, in W/(m² sr). Directions
/// account for a part of it. The radiance of each light group is added to `by_group`.
pub(super) fn caustic_radiance(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    found: &mut Neighbors,
    by_group: &mut RadianceByGroup,
) -> Rgb {
    let has_lobes = |lobes: &Lobes| point.at.bsdf.lobes().has(*lobes);
    (CLASSES.into_iter().filter(has_lobes))
        .map(|lobes| caustic_radiance_of(prepared, point, lobes, (found, by_group)))
        .fold(Rgb::BLACK, |sum, radiance| sum + radiance)
}

/// The part of [`caustic_radiance`] that one class of lobes reflects.
fn caustic_radiance_of(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    lobes: Lobes,
    found: (&mut Neighbors, &mut RadianceByGroup),
) -> Rgb {
    let bandwidth = caustic_bandwidth(prepared, &point.path, lobes);
    let photons = (&prepared.caustics, bandwidth);
    estimate(prepared, photons, point, found, |arriving, by_group| {
        let reflected = arriving.f_cos(lobes);
        // Directions are drawn from all non-specular lobes.
        let all = match CLASSES
            .iter()
            .all(|&class| point.at.bsdf.lobes().has(class))
        {
            true => arriving.f_cos(Lobes::NON_SPECULAR),
            false => reflected.clone(),
        };
        let of_surfaces = arriving.iter().filter(|(photon, _)| is_of_surface(photon));
        let near = of_surfaces.count() as u32;
        let mut sum = Rgb::BLACK;
        for ((photon, kernel), (f_cos, reflected)) in
            arriving.iter().zip(all.into_iter().zip(reflected))
        {
            let wi = photon.wi;
            let caustics = CausticKernel {
                radius: arriving.radius(),
                others: near.saturating_sub(1),
            };
            let densities = densities(point, IncidentDirection { wi, f_cos }, caustics);
            let fraction = match is_of_surface(photon) {
                true => 1.0 - densities.surface_fraction(),
                false => densities.photon_emission_fraction(photon.ray_density),
            };
            let value = photon.flux * reflected * (kernel * fraction);
            sum += value;
            by_group.add(photon.group, value);
        }
        sum
    })
}

/// Radiance at a gather point from compensation photons, in W/(m² sr). The radiance of each light
/// group is added to `by_group`.
pub(super) fn compensation_photon_radiance(
    prepared: &PreparedPasses,
    point: &GatherPoint,
    found: &mut Neighbors,
    by_group: &mut RadianceByGroup,
) -> Rgb {
    let bandwidth = bandwidth(prepared, &point.path);
    let photons = (&prepared.compensation_photons, bandwidth);
    let found = (found, by_group);
    estimate(prepared, photons, point, found, |arriving, by_group| {
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
            let value = reflected.photon.flux * kernel * (f_cos * (fraction * clamped));
            sum += value;
            by_group.add(reflected.photon.group, value);
        });
        sum
    })
}

/// A sum over the photons that arrive at a gather point, divided by the covered fraction of the
/// kernel. On transmitting surfaces light arrives on both sides, unless one of them was chosen.
fn estimate<P: OnSurface + Sync>(
    prepared: &PreparedPasses,
    (photons, bandwidth): (&KdTree<P>, Bandwidth),
    point: &GatherPoint,
    (found, by_group): (&mut Neighbors, &mut RadianceByGroup),
    sum: impl Fn(&ArrivingPhotons<P>, &mut RadianceByGroup) -> Rgb,
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
    let probes = match point.path.stage {
        PathStage::BeforeX => COVERAGE_PROBES,
        PathStage::AfterX | PathStage::Decided(_) => COVERAGE_PROBES_INDIRECT,
    };
    let mut on_side = |n: Vec3| {
        let arriving = ArrivingPhotons::around(photons, receiver, n, bandwidth, found);
        let mut groups = RadianceByGroup::black(prepared.light_groups);
        let sum = sum(&arriving, &mut groups);
        if sum.is_black() {
            return sum;
        }
        let covered = arriving.covered(&prepared.scene.geometry, probes);
        for (group, value) in groups.lit() {
            by_group.add(group, value / covered * weight);
        }
        sum / covered
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
    bandwidth_within(prepared, path.max_photon_radius)
}

/// Of caustic photons, for one class of lobes.
fn caustic_bandwidth(prepared: &PreparedPasses, path: &GatherPath, lobes: Lobes) -> Bandwidth {
    let fraction = match lobes.has(Lobes::GLOSSY) {
        true => GLOSSY_RADIUS_FRACTION,
        false => 1.0,
    };
    bandwidth_within(prepared, path.max_photon_radius * fraction)
}

fn bandwidth_within(prepared: &PreparedPasses, radius: f32) -> Bandwidth {
    let largest = MAX_RADIUS_FRACTION * prepared.scene.geometry.bounds().diagonal();
    Bandwidth {
        largest: radius.min(largest),
        radius_scale: progressive_radius_scale(prepared.group.passes.end),
    }
}

/// Largest radius of an estimate at `distance` m along a camera path, in m.
pub(super) fn max_photon_radius(pixel: PixelFootprint, distance: f32) -> f32 {
    MAX_RADIUS_PIXELS * pixel.width_at(distance)
}
