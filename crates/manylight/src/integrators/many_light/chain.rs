//! Specular events: of prefixes, and of chains, which continue sampled directions from specular
//! surfaces.
//!
//! Lights are gathered at the surface behind a chain. Caustic photons carry the same light;
//! `density_estimates.rs` says which part of it they account for: of the light of surfaces, and of
//! emitters.

use super::compensation::MAX_SURVIVAL;
use super::density_estimates::{IncidentDirection, shared_light};
use super::gather_point::{GatherPath, GatherRole, TileGather};
use super::paths::{Chain, Direction, PathNumber, PathPart, PathState, Prefix, SPLIT};
use crate::bsdf::{Lobes, Numbers};
use crate::integrators::camera_round::Arrived;
use crate::integrators::partition::PathStage;
use crate::lanes::{Float, Pair, Width, lane};
use crate::math::{Vec2, Vec3};
use crate::simd::set_bits;
use crate::transport::stream::{Bits, Walks, lanes_where};
use crate::transport::walk::MAX_SPECULAR_SEGMENTS;

/// Factor from the throughput of a chain at the first gather point to the probability of following
/// it: low-roughness lobes see bright surfaces there. Measured at 64, over 4 passes at 160x90: no
/// change beyond 3 % in U-Shape, Garage and Disco.
const FIRST_SURVIVAL_FACTOR: f32 = 16.0;

/// Factor from the weight of a specular path to its probability of survival: only the weakest paths
/// are terminated. At 32 and 128 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room):
/// relMSE +0.8 and +0.1 %, shadow rays -2 and +4 %.
const SURVIVAL_FACTOR: f32 = 64.0;

/// How a path continues from a vertex by specular events.
#[derive(Clone, Copy)]
struct Branches {
    /// Number of events, each of which continues a path.
    count: u32,
    /// Factor on the throughput.
    scale: f32,
    /// Factor from the roulette weight to the probability of survival, and its maximum.
    survival_factor: f32,
    max_survival: f32,
}

impl Branches {
    const NONE: Branches = Branches {
        count: 0,
        scale: 0.0,
        survival_factor: 0.0,
        max_survival: 0.0,
    };
}

/// Appends to `next` the paths in `lanes` that continue by specular events; weak ones survive by
/// roulette.
#[inline(always)]
pub(super) fn follow<S: Width>(
    s: S,
    tile: &mut TileGather,
    at: &mut Arrived<S, PathState>,
    lanes: Bits,
    next: &mut Walks<PathState>,
) {
    let lanes = lanes & at.v.bsdf.has(Lobes::SPECULAR).bits();
    let lanes = lanes_where(lanes, |i| at.v.segments.as_ref()[i] < MAX_SPECULAR_SEGMENTS);
    if lanes == 0 {
        return;
    }
    let w_prev = at.v.w_prev.store();
    let all = s.each(|i| match lanes >> i & 1 {
        0 => Branches::NONE,
        _ => branches(tile, &at.paths.as_ref()[i]),
    });
    let branch = |i: usize| &all.as_ref()[i];
    let w = |i: usize| -Vec3::from(lane(&w_prev, i));
    let scaled = at.throughput * Float::from_fn(s, |i| branch(i).scale);
    let survival_factor = Float::from_fn(s, |i| branch(i).survival_factor);
    let max_survival = Float::from_fn(s, |i| branch(i).max_survival);
    let most = all.as_ref().iter().fold(0, |most, b| b.count.max(most));
    for k in 0..most {
        let lanes = lanes_where(lanes, |i| k < branch(i).count);
        let numbers = event_numbers(s, tile, at, &all, k);
        let samples = (at.v.bsdf).sample_each_wi(at.v.w_prev, numbers, Lobes::SPECULAR);
        let throughput = scaled * samples.weight;
        let eta_squared = at.eta_squared * samples.eta * samples.eta;
        let weight = throughput.max_channel() * eta_squared;
        let survival = (survival_factor * weight).min(max_survival);
        let survives = at.generators.next().lt(survival) & samples.valid;
        let segments = (at.v).next_camera_segments(&samples, throughput / survival, eta_squared);
        for i in set_bits(lanes & survives.bits()) {
            let sampler = at.generators.draw(i, |sampler| sampler.branch());
            let path = branch_path(tile, (&at.paths.as_ref()[i], w(i)), branch(i), k);
            let row = segments.row(i, sampler, path);
            next.push(match path.chain() {
                // Chains have no next-event estimation that shares the light of emitters.
                Some(_) => row.without_next_event(),
                None => row,
            });
        }
    }
}

/// Random numbers of event `k` of the branches. Paths that the prefix of a pixel splits into fill
/// their domains evenly.
#[inline(always)]
fn event_numbers<S: Width>(
    s: S,
    tile: &TileGather,
    at: &mut Arrived<S, PathState>,
    branches: &S::Each<Branches>,
    k: u32,
) -> Numbers<S> {
    let drawn = at.generators.next_bsdf();
    let is_split = lanes_where(u32::MAX >> (32 - S::LANES), |i| {
        branches.as_ref()[i].count > 1
    });
    if is_split == 0 {
        return drawn;
    }
    let (lobe, u, v) = (
        drawn.lobe.store(),
        drawn.direction.x.store(),
        drawn.direction.y.store(),
    );
    let numbers = s.each(|i| match at.paths.as_ref()[i].number() {
        Some(number) if is_split >> i & 1 != 0 => {
            let pixel = at.paths.as_ref()[i].pixel as usize;
            let index = number.index * branches.as_ref()[i].count + k;
            tile.numbers[pixel].events.triple(index)
        }
        _ => {
            let direction = Vec2::new(u.as_ref()[i], v.as_ref()[i]);
            (lobe.as_ref()[i], direction)
        }
    });
    let numbers = numbers.as_ref();
    Numbers {
        lobe: Float::from_fn(s, |i| numbers[i].0),
        direction: Pair::from_fn(s, |i| numbers[i].1),
    }
}

/// How a path continues from a vertex with specular lobes.
fn branches(tile: &TileGather, path: &PathState) -> Branches {
    match &path.part {
        PathPart::Prefix(prefix) => {
            let count = match prefix.number {
                Some(PathNumber { count, .. }) if count < SPLIT => SPLIT / count,
                _ => 1,
            };
            Branches {
                count,
                scale: 1.0 / count as f32,
                survival_factor: SURVIVAL_FACTOR,
                max_survival: 1.0,
            }
        }
        PathPart::Direction(direction) => first_branches(tile, path.stage, direction),
        PathPart::Chain(chain) => Branches {
            count: 1,
            scale: 1.0,
            survival_factor: 1.0 / chain.first_weight,
            max_survival: MAX_SURVIVAL,
        },
    }
}

/// The first event of a chain.
fn first_branches(tile: &TileGather, stage: PathStage, direction: &Direction) -> Branches {
    let point = &tile.points[direction.from as usize];
    let (survival_factor, max_survival) = match stage {
        PathStage::AfterX => (FIRST_SURVIVAL_FACTOR, 1.0),
        _ => (1.0, MAX_SURVIVAL),
    };
    Branches {
        count: 1,
        scale: 1.0,
        survival_factor: survival_factor / point.path.first_weight,
        max_survival,
    }
}

/// The chain that continues a direction, which arrives along the unit vector `w`.
fn chain_from(tile: &mut TileGather, direction: &Direction, w: Vec3) -> Chain {
    let point = &tile.points[direction.from as usize];
    let (prepared, found) = (tile.prepared, &mut tile.found_caustics);
    let incident = IncidentDirection {
        wi: w,
        f_cos: direction.f_cos,
    };
    Chain {
        shared: shared_light(prepared, point, incident, found),
        scales: point.path.scales,
        first_weight: point.path.first_weight,
        max_photon_radius: direction.max_photon_radius,
    }
}

/// Branch `k` of `branches`, which continue `path` from a vertex at which it arrives along the unit
/// vector `w`.
fn branch_path(
    tile: &mut TileGather,
    (path, w): (&PathState, Vec3),
    branches: &Branches,
    k: u32,
) -> PathState {
    let part = match path.part {
        PathPart::Prefix(prefix) if branches.count > 1 => PathPart::Prefix(Prefix {
            number: prefix.number.map(|number| PathNumber {
                index: number.index * branches.count + k,
                count: SPLIT,
            }),
            ..prefix
        }),
        PathPart::Direction(direction) => PathPart::Chain(chain_from(tile, &direction, w)),
        PathPart::Prefix(_) | PathPart::Chain(_) => path.part,
    };
    PathState {
        stage: path.stage.after(Lobes::SPECULAR),
        part,
        ..*path
    }
}

/// Gathers at the vertices in `lanes` where chains arrive.
#[inline(always)]
pub(super) fn end<'s, S: Width>(
    tile: &mut TileGather<'s, '_, '_>,
    at: &mut Arrived<'_, 's, S, PathState>,
    lanes: Bits,
) {
    let lanes = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
    let lanes = lanes_where(lanes, |i| at.paths.as_ref()[i].chain().is_some());
    if lanes == 0 {
        return;
    }
    let (scene, values) = (tile.prepared.scene, at.values());
    for i in set_bits(lanes) {
        let path = at.paths.as_ref()[i];
        let Some(chain) = path.chain() else {
            continue;
        };
        let fraction = chain.shared.surface_fraction();
        let survival = fraction.max_channel();
        if at.generators.draw(i, |sampler| sampler.next_1d()) >= survival {
            continue;
        }
        let vertex = at.vertex(scene, &values, i);
        let path = GatherPath {
            pixel: path.pixel,
            throughput: values.throughput(i) * (fraction / survival),
            eta_squared: values.eta_squared(i),
            segments: vertex.segments,
            stage: path.stage,
            max_photon_radius: chain.max_photon_radius,
            first_weight: chain.first_weight,
            scales: chain.scales,
        };
        let role = GatherRole::BehindSpecularChain;
        at.generators
            .draw(i, |sampler| tile.gather(&vertex, path, role, None, sampler));
    }
}
