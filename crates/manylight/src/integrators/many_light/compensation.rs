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
use super::paths::ScaleRow;
use super::paths::{Direction, PathState};
use super::radiance_cache::{CachePoint, GroupLight};
use crate::color::Rgb;
use crate::gather::Assignment;
use crate::geometry::SurfacePoint;
use crate::ids::{LightGroup, MaterialId};
use crate::integrators::light_groups::RadianceByGroup;
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
const MIN_SEARCHED: f32 = 1.0 / 8.0;
/// Factor from the clamped fraction of a direction to the probability of a photon query at a glossy
/// surface. Measured against 1, over 8 passes at 160x90: relMSE falls by 5 % in the Kitchen and by
/// 10 % in the U-Shape, for 7 and 1 % more time.
const GLOSSY_SURVIVAL_FACTOR: f32 = 4.0;

/// Least probability of a photon query at a glossy surface with light groups told apart: groups that
/// have no photons around the cache point do not count in it. At 1/32 and 1/8 (128 lights at 96x54,
/// 10 seeds; Kitchen, Glossy Room, Disco): the variance of each group is the same to .5 %.
const MIN_OF_GROUPS: f32 = 1.0 / 16.0;

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
/// removes from the sum over lights.
pub(super) fn compensate(tile: &mut TileGather, y: &DirectionEnd, sampler: &mut Sampler) {
    let lit_side = lit_side(y, sampler);
    let location = y.location(lit_side);
    let searched = search_probability(tile, y, &location);
    if searched < 1.0 && sampler.next_1d() >= searched {
        return;
    }
    match cache_point(tile, y, &location) {
        Some(point) => compensate_by_cache(tile, y, (&location, point), searched, sampler),
        None => continue_path(tile, y, &location, searched, sampler),
    }
}

/// The normal at `y` on the side at which light is restored. Different lights light the two sides of
/// a transmitting surface: one side is chosen.
fn lit_side(y: &DirectionEnd, sampler: &mut Sampler) -> Vec3 {
    if y.transmits && sampler.next_1d() >= 0.5 {
        -y.n
    } else {
        y.n
    }
}

/// Probability of the search for the light that represents `y`.
fn search_probability(tile: &TileGather, y: &DirectionEnd, location: &SurfaceLocation) -> f32 {
    y.from(tile).area_per_light.map_or(1.0, |area| {
        let assignment = Assignment::Unassigned {
            area: ESTIMATED_AREAS * area,
        };
        clamped_fraction(tile, y, location, assignment).clamp(MIN_SEARCHED, 1.0)
    })
}

/// The point of the radiance cache that has the light at `y`, if the cache serves there.
fn cache_point<'o>(
    tile: &TileGather<'_, 'o, '_>,
    y: &DirectionEnd,
    location: &SurfaceLocation,
) -> Option<&'o CachePoint> {
    if y.transmits {
        return None;
    }
    let point = tile.prepared.cache.point(location, y.segments)?;
    let distance = location.p.distance(y.from(tile).at.x.p);
    point.serves(distance).then_some(point)
}

/// Continues the path at `y` with the probability of the clamped fraction, and gathers there; the
/// direction was followed with probability `searched`.
fn continue_path(
    tile: &mut TileGather,
    y: &DirectionEnd,
    location: &SurfaceLocation,
    searched: f32,
    sampler: &mut Sampler,
) {
    let first_weight = y.from(tile).path.first_weight;
    let (clamped, scales) = clamped_fractions(tile, y, location);
    let sides = if y.transmits { 2.0 } else { 1.0 };
    let path = GatherPath {
        pixel: y.path.pixel,
        throughput: y.throughput / searched * (sides * clamped),
        eta_squared: y.eta_squared,
        segments: y.segments,
        stage: y.path.stage.after_compensating_event(),
        max_photon_radius: y.direction.max_photon_radius,
        first_weight,
        scales,
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
    let lit_from = y.transmits.then_some(location.n);
    let vertex = y.vertex(tile.prepared.scene);
    tile.gather(&vertex, path, role, lit_from, sampler);
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
    if prepared.light_groups > 0 {
        return compensate_groups_by_cache(tile, y, (location, point), searched, sampler);
    }
    let cached = point.all();
    let assignment = cached.assignment(point, &prepared.lights);
    let clamped = clamped_fraction(tile, y, location, assignment);
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
        let found = (found, &mut RadianceByGroup::default());
        (prepared.cache).glossy_radiance(scene, (&y.vertex(scene), point), limit, found)
    } else {
        cached.reflected(y.diffuse_f, y.segments)
    };
    let weight = clamped / (searched * survival);
    let layer = y.path.stage.after_compensating_event().layer();
    let radiance = y.throughput * radiance * weight;
    tile.out.add(y.path.pixel as usize, layer, radiance);
}

/// [`compensate_by_cache`], for each light group.
fn compensate_groups_by_cache(
    tile: &mut TileGather,
    y: &DirectionEnd,
    (location, point): (&SurfaceLocation, &CachePoint),
    searched: f32,
    sampler: &mut Sampler,
) {
    let prepared = tile.prepared;
    let (lights, groups) = (&prepared.lights, prepared.cache.groups_at(point));
    let mut clamped = vec![None; prepared.light_groups];
    for GroupLight {
        group,
        light: cached,
    } in groups
    {
        let assignment = cached.assignment(point, lights);
        clamped[group.index()] = Some(clamped_fraction(tile, y, location, assignment));
    }
    let largest = clamped.iter().flatten().fold(0.0, |a: f32, &b| a.max(b));
    let survival = match y.is_glossy {
        true => (GLOSSY_SURVIVAL_FACTOR * largest / searched).clamp(MIN_OF_GROUPS, 1.0),
        false => 1.0,
    };
    if sampler.next_1d() >= survival {
        return;
    }
    let mut radiance = RadianceByGroup::black(prepared.light_groups);
    if y.is_glossy {
        let (scene, found) = (prepared.scene, &mut tile.found_photons);
        let limit = direction_limit(y.direction.f_cos);
        let at = (&y.vertex(scene), point);
        (prepared.cache).glossy_radiance(scene, at, limit, (found, &mut radiance));
    } else {
        for GroupLight {
            group,
            light: cached,
        } in groups
        {
            radiance.add(*group, cached.reflected(y.diffuse_f, y.segments));
        }
    }
    let layer = y.path.stage.after_compensating_event().layer();
    let row = y.from(tile).path.scales;
    for (group, radiance) in radiance.lit() {
        // Photons around `y` may be of groups that have none around the cache point.
        let clamped = clamped[group.index()].unwrap_or_else(|| {
            let light = prepared.nearest.light(group, prepared.scene, location);
            clamped_fraction(tile, y, location, lights.assignment(light, location.p))
        });
        let weight = clamped * tile.scales.of(row, group) / (searched * survival);
        let radiance = y.throughput * radiance * weight;
        (tile.out).add_light(y.path.pixel as usize, layer, group, radiance);
    }
}

/// The largest fraction of the light from `y`, over the light groups, that the clamp removes at the
/// point where the direction starts; and the factors of a path that goes on with that fraction.
fn clamped_fractions(
    tile: &mut TileGather,
    y: &DirectionEnd,
    location: &SurfaceLocation,
) -> (f32, ScaleRow) {
    let prepared = tile.prepared;
    let fraction = |group: usize| {
        let group = LightGroup(group as u8);
        let light = prepared.nearest.light(group, prepared.scene, location);
        let assignment = prepared.lights.assignment(light, location.p);
        clamped_fraction(tile, y, location, assignment)
    };
    if prepared.light_groups == 0 {
        return (fraction(0), ScaleRow::ONE);
    }
    let fractions: Vec<f32> = (0..prepared.light_groups).map(fraction).collect();
    let largest = fractions.iter().fold(0.0, |a: f32, &b| a.max(b));
    if largest == 0.0 {
        return (0.0, ScaleRow::ONE);
    }
    let row = y.from(tile).path.scales;
    let factors = fractions.into_iter().map(|fraction| fraction / largest);
    (largest, tile.scales.times(row, factors))
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
