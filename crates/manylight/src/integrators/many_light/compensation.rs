//! Bias compensation: directions restore the light that clamping removes.
//!
//! The sum over virtual lights at `x` keeps a fraction of the light that the non-specular lobes at
//! `y` reflect towards `x`; the clamp removes the rest, `clamped_fraction(x, y)`. A direction
//! sampled at `x` that meets `y` takes that fraction of the radiance at `y` from the radiance
//! cache. Where the cache does not serve, near corners and on transmitting surfaces, it continues
//! with the probability of that fraction and gathers at `y` all light that arrives there: emitters,
//! photons, and virtual lights, for which clamping is compensated in the same way. Emission at `y`
//! is direct light at `x`, which is estimated elsewhere.
//!
//! With bidirectional lightcuts there is no cache: every direction continues by Russian roulette.
//!
//! Source: Kollig, Keller, "Illumination in the Presence of Weak Singularities", MCQMC 2004.
//! Deviations: a light represents many photons, so that the clamped fraction is that of the light
//! to which a photon at `y` is assigned; and the cache.

use super::compensation_photons::direction_limit;
use super::gather_point::{GatherPath, GatherPoint, GatherRole, TileGather};
use super::paths::{Direction, PathState};
use super::radiance_cache::CachePoint;
use crate::color::Rgb;
use crate::gather::Assignment;
use crate::geometry::SurfacePoint;
use crate::ids::MaterialId;
use crate::integrators::partition::PathStage;
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Vertex;
use crate::virtual_lights::SurfaceLocation;

/// Largest probability `p` of continuing beyond the second gather point of a camera path. It bounds
/// the expected number of further gather points by `1/(1 - p)`, 20: 10 at 0.9, 40 at 0.975. At 0.9
/// and 0.975 (2 passes of 128 lights at 72x40, 2 seeds; Kitchen): pictures differ by at most 0.4 %
/// (RMS).
pub(super) const MAX_SURVIVAL: f32 = 0.95;
/// The search for the light that represents `y` costs more than the rest of the step. So the
/// clamped fraction is first estimated as if that light represented this many times the area per
/// light around `x`, and the search made with that probability. At 8 and 32 (2 passes of 128 lights
/// at 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape): relMSE +0.5 and 0 % (standard error 1 %).
const ESTIMATED_AREAS: f32 = 16.0;
/// Least probability of that search: bounds the weight of directions for which the estimate is too
/// low by 8. At 0.0625 and 0.25 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room,
/// U-Shape): relMSE +0.8 and -0.6 % (standard error 1 %).
const LEAST_SEARCHED: f32 = 1.0 / 8.0;
/// Factor from the clamped fraction of a direction to the probability of a photon query at a glossy
/// surface. Measured against 1, over 8 passes at 160x90: relMSE falls by 5 % in the Kitchen and by
/// 10 % in the U-Shape, for 7 and 1 % more time.
const GLOSSY_SURVIVAL_FACTOR: f32 = 4.0;

/// A vertex `y` with non-specular lobes at which a direction arrives.
pub(super) struct DirectionEnd {
    pub(super) path: PathState,
    pub(super) direction: Direction,
    pub(super) throughput: Rgb,
    pub(super) eta_squared: f32,
    pub(super) segments: u32,
    pub(super) x: SurfacePoint,
    pub(super) material: MaterialId,
    /// Unit direction back along the segment, and the normal on that side.
    pub(super) w_prev: Vec3,
    pub(super) n: Vec3,
    /// Whether some lobe transmits.
    pub(super) transmits: bool,
    pub(super) is_glossy: bool,
    /// The scattering function of the diffuse lobes, for light along `n`; only for surfaces that
    /// have no others.
    pub(super) diffuse_f: Rgb,
}

impl DirectionEnd {
    fn vertex<'s>(&self, scene: &'s Scene) -> Vertex<'s> {
        Vertex {
            bsdf: (scene.materials).bsdf(self.material, &self.x, &scene.textures),
            x: self.x,
            w_prev: self.w_prev,
            segments: self.segments,
        }
    }

    /// The gather point from which the direction comes.
    fn from<'t, 's>(&self, tile: &'t TileGather<'s, '_, '_>) -> &'t GatherPoint<'s> {
        &tile.points[self.direction.from as usize]
    }

    /// `y`, on the side of the normal `n`.
    fn location(&self, n: Vec3) -> SurfaceLocation {
        SurfaceLocation {
            p: self.x.p,
            n,
            material: self.material,
        }
    }
}

/// Restores the light that non-specular lobes at `y` reflect along the direction, and that clamping
/// removes from the sum over lights. A transmitting surface is lit from two sides by different
/// lights: one side is chosen.
pub(super) fn compensate(tile: &mut TileGather, y: &DirectionEnd, sampler: &mut Sampler) {
    let prepared = tile.prepared;
    let lit_side = if y.transmits && sampler.next_1d() >= 0.5 {
        -y.n
    } else {
        y.n
    };
    let location = y.location(lit_side);
    let from = y.from(tile);
    let first_weight = from.path.first_weight;
    let searched = from.area_per_light.map_or(1.0, |area| {
        let area = ESTIMATED_AREAS * area;
        let assignment = Assignment::Unassigned { area };
        let estimate = clamped_fraction(tile, y, &location, assignment);
        estimate.clamp(LEAST_SEARCHED, 1.0)
    });
    if searched < 1.0 && sampler.next_1d() >= searched {
        return;
    }
    let throughput = y.throughput / searched;
    if !y.transmits
        && let Some(point) = prepared.cache.point(&location, y.segments)
        && point.serves(location.p.distance(y.from(tile).at.x.p))
    {
        return compensate_by_cache(tile, y, (&location, point), searched, sampler);
    }
    let light = prepared.nearest.light(prepared.scene, &location);
    let assignment = prepared.lights.assignment(light, &location);
    let clamped = clamped_fraction(tile, y, &location, assignment);
    let sides = if y.transmits { 2.0 } else { 1.0 };
    let path = GatherPath {
        pixel: y.path.pixel,
        throughput: throughput * (sides * clamped),
        eta_squared: y.eta_squared,
        segments: y.segments,
        stage: y.path.stage.after_compensating_event(),
        max_photon_radius: y.direction.max_photon_radius,
        first_weight,
    };
    let survival = match y.path.stage {
        PathStage::AfterX => (clamped / searched).min(1.0),
        _ => (path.roulette_weight() / first_weight).min(MAX_SURVIVAL),
    };
    if survival <= 0.0 || sampler.next_1d() >= survival {
        return;
    }
    let path = GatherPath {
        throughput: path.throughput / survival,
        ..path
    };
    let role = GatherRole::Compensation {
        direction_limit: direction_limit(y.direction.f_cos),
    };
    let lit_from = y.transmits.then_some(lit_side);
    tile.gather(&y.vertex(prepared.scene), path, role, lit_from, sampler);
}

/// Ends a direction at `y` by its point of the radiance cache; it was followed with probability
/// `searched`.
fn compensate_by_cache(
    tile: &mut TileGather,
    y: &DirectionEnd,
    (location, point): (&SurfaceLocation, &CachePoint),
    searched: f32,
    sampler: &mut Sampler,
) {
    let prepared = tile.prepared;
    let clamped = clamped_fraction(tile, y, location, point.assignment(&prepared.lights));
    let survival = match y.is_glossy {
        true => (GLOSSY_SURVIVAL_FACTOR * clamped / searched).min(1.0),
        false => 1.0,
    };
    if sampler.next_1d() >= survival {
        return;
    }
    let radiance = if y.is_glossy {
        let (scene, found) = (prepared.scene, &mut tile.found_photons);
        let limit = direction_limit(y.direction.f_cos);
        (prepared.cache).glossy_radiance(scene, (&y.vertex(scene), point), limit, found)
    } else {
        point.reflected(y.diffuse_f, y.segments)
    };
    let weight = clamped / (searched * survival);
    let layer = y.path.stage.after_compensating_event().layer();
    let radiance = y.throughput * radiance * weight;
    tile.out.add(y.path.pixel as usize, layer, radiance);
}

/// Fraction of the light from `y` that the clamp removes at the point where the direction starts,
/// where `assignment` represents it.
fn clamped_fraction(
    tile: &TileGather,
    y: &DirectionEnd,
    location: &SurfaceLocation,
    assignment: Assignment,
) -> f32 {
    let (gather, lights) = (&tile.prepared.gather, &tile.prepared.lights);
    let receiver = (&y.from(tile).at).into();
    gather.clamped_fraction(lights, &receiver, location, assignment, |_| {
        y.direction.f_cos
    })
}
