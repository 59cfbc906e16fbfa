//! Specular events: of the prefix of a camera path, and of chains that a glossy lobe sees.
//!
//! The direction from a gather point continues by specular events, and lights are gathered at the surfaces behind. Caustic photons carry the
//! same light; `caustic_shares.rs` says which part of it they account for. Light that emitters send through such a chain is estimated by
//! photons: emitters may be small.

use super::arriving::Arriving;
use super::caustic_shares::photon_fraction;
use super::compensation::MAX_SURVIVAL;
use super::gather_points::TileGather;
use super::gather_vertices::{DirectionNumbers, GatherPath, GatherRole};
use super::gathering::GatherTask;
use super::paths::{Chain, Direction, PathNumber, PathPart, PathState, Prefix, SPLIT};
use crate::bsdf::{Lobes, Numbers};
use crate::color::Rgb;
use crate::integrators::camera_round::Arrived;
use crate::integrators::partition::PathStage;
use crate::lanes::{Color, Float, Pair, Width, lane};
use crate::maps::density::DensityReceiver;
use crate::math::{Vec2, Vec3};
use crate::simd::set_bits;
use crate::transport::stream::{Bits, WalkRow, lanes_where};

/// Chains of more segments end: they would carry hardly any light.
pub(super) const MAX_CHAIN: u32 = 64;
/// Factor from the throughput of a chain at the first gather point to the probability of following it: low-roughness lobes see bright
/// surfaces there. Measured at 64, over 4 passes at 160x90: no change beyond 3 % in U-Shape, Garage and Disco.
const FIRST_SURVIVAL_FACTOR: f32 = 16.0;

/// Factor from the weight of a specular path to its probability of survival. Unmeasured: only the weakest paths are terminated.
const SURVIVAL_FACTOR: f32 = 64.0;

/// How a path continues from a vertex by specular events.
#[derive(Clone, Copy)]
struct Branches {
    /// Number of events, each of which continues a path.
    count: u32,
    /// Factor on the throughput.
    scale: Rgb,
    /// Factor from the roulette weight to the probability of survival, and its maximum.
    survival_factor: f32,
    max_survival: f32,
}

impl Branches {
    const NONE: Branches = Branches {
        count: 0,
        scale: Rgb::BLACK,
        survival_factor: 0.0,
        max_survival: 0.0,
    };
}

impl<'s> Arriving<'_, 's, '_, '_> {
    /// Appends the paths in `lanes` that continue by specular events; weak ones survive by roulette.
    #[inline(always)]
    pub(super) fn follow_specular<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<S, PathState>,
        lanes: Bits,
    ) {
        let lanes = lanes & at.v.bsdf.has(Lobes::SPECULAR).bits();
        let lanes = lanes_where(lanes, |i| at.v.segments.as_ref()[i] < MAX_CHAIN);
        if lanes == 0 {
            return;
        }
        let w_prev = at.v.w_prev.store();
        let branches = s.each(|i| match lanes >> i & 1 {
            0 => Branches::NONE,
            _ => {
                let wi = -Vec3::from(lane(&w_prev, i));
                self.tile.branches(&at.paths.as_ref()[i], wi)
            }
        });
        let branch = |i: usize| &branches.as_ref()[i];
        let scaled = at.throughput * Color::from_fn(s, |i| branch(i).scale);
        let survival_factor = Float::from_fn(s, |i| branch(i).survival_factor);
        let max_survival = Float::from_fn(s, |i| branch(i).max_survival);
        let normals = at.v.normals();
        let most = branches
            .as_ref()
            .iter()
            .fold(0, |most, b| b.count.max(most));
        for k in 0..most {
            let lanes = lanes_where(lanes, |i| k < branch(i).count);
            let numbers = self.event_numbers(s, at, &branches, k);
            let samples =
                at.v.bsdf
                    .sample_each_wi(at.v.w_prev, numbers, Lobes::SPECULAR);
            let throughput = scaled * samples.weight;
            let eta_squared = at.eta_squared * samples.eta * samples.eta;
            let weight = throughput.max_channel() * eta_squared;
            let survival = (survival_factor * weight).min(max_survival);
            let survives = at.generators.next().lt(survival) & samples.valid;
            let throughput = (throughput / survival).store();
            let eta_squared = eta_squared.store();
            let scattered = at.v.scattered(&samples);
            for i in set_bits(lanes & survives.bits()) {
                self.next.push(WalkRow {
                    ray: scattered.ray(i),
                    throughput: lane(&throughput, i),
                    eta_squared: eta_squared.as_ref()[i],
                    segments: at.v.segments.as_ref()[i],
                    previous: scattered.previous(i, normals.get(i)),
                    sampler: at.generators.draw(i, |sampler| sampler.branch()),
                    kept: self.tile.branch(&at.paths.as_ref()[i], branch(i), k),
                });
            }
        }
    }

    /// Random numbers of event `k` of the branches. Paths that the prefix of a pixel splits into fill their domains evenly.
    #[inline(always)]
    fn event_numbers<S: Width>(
        &self,
        s: S,
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
                self.tile.numbers[pixel].events.triple(index)
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

    /// Gathers at the vertices in `lanes` where chains arrive.
    #[inline(always)]
    pub(super) fn end_chains<S: Width>(
        &mut self,
        at: &mut Arrived<'_, 's, S, PathState>,
        lanes: Bits,
    ) {
        let lanes = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
        let lanes = lanes_where(lanes, |i| at.paths.as_ref()[i].chain().is_some());
        if lanes == 0 {
            return;
        }
        let values = at.values();
        for i in set_bits(lanes) {
            let path = at.paths.as_ref()[i];
            let Some(chain) = path.chain() else {
                continue;
            };
            let vertex = at.vertex(self.round.scene, &values, i);
            let path = GatherPath {
                pixel: path.pixel,
                throughput: values.throughput(i),
                eta_squared: values.eta_squared(i),
                stage: path.stage,
                max_photon_radius: chain.max_photon_radius,
                first_weight: chain.first_weight,
            };
            let lights = self.tile.sparse_lights();
            at.generators.draw(i, |sampler| {
                let task = GatherTask {
                    path,
                    role: GatherRole::BehindSpecularChain,
                    lights,
                    numbers: DirectionNumbers::single(sampler),
                };
                self.tile.gather(&vertex, task, sampler);
            });
        }
    }
}

impl TileGather<'_, '_, '_> {
    /// How a path continues from a vertex with specular lobes, at which it arrives along the unit direction `w`.
    fn branches(&mut self, path: &PathState, w: Vec3) -> Branches {
        match &path.part {
            PathPart::Prefix(prefix) => {
                let count = match prefix.number {
                    Some(PathNumber { count, .. }) if count < SPLIT => SPLIT / count,
                    _ => 1,
                };
                Branches {
                    count,
                    scale: Rgb::splat(1.0 / count as f32),
                    survival_factor: SURVIVAL_FACTOR,
                    max_survival: 1.0,
                }
            }
            PathPart::Direction(direction) => self.first_of_chain(path.stage, direction, w),
            PathPart::Chain(chain) => Branches {
                count: 1,
                scale: Rgb::WHITE,
                survival_factor: 1.0 / chain.first_weight,
                max_survival: MAX_SURVIVAL,
            },
        }
    }

    /// The first event of a chain that a glossy lobe sees. Directions account for the part that is reflected by glossy lobes, less that of
    /// photons.
    fn first_of_chain(&mut self, stage: PathStage, direction: &Direction, w: Vec3) -> Branches {
        let point = &self.points[direction.from as usize];
        let (bsdf, wo) = (&point.at.bsdf, point.at.wo);
        if !bsdf.lobes().has(Lobes::GLOSSY) {
            return Branches::NONE;
        }
        let f = |lobes| bsdf.f(w, wo, lobes);
        let glossy_fraction = f(Lobes::GLOSSY).zip(f(Lobes::NON_SPECULAR), |part, all| {
            if all > 0.0 { part / all } else { 0.0 }
        });
        let receiver = DensityReceiver {
            p: point.at.x.p,
            n: point.at.x.normal_towards(w),
        };
        let (segments, radius) = (point.segments, point.max_photon_radius);
        let found = &mut self.found_caustics;
        let are_dense = (self.prepared).caustics_are_dense(receiver, segments, radius, found);
        let by_photons = match are_dense {
            true => photon_fraction(direction.f_cos),
            false => 0.0,
        };
        let first_weight = self.vertices[direction.from as usize].path.first_weight;
        let (survival_factor, max_survival) = match stage {
            PathStage::AfterX => (FIRST_SURVIVAL_FACTOR, 1.0),
            _ => (1.0, MAX_SURVIVAL),
        };
        Branches {
            count: 1,
            scale: glossy_fraction * (1.0 - by_photons),
            survival_factor: survival_factor / first_weight,
            max_survival,
        }
    }

    /// Branch `k` of `branches`, which continue `path`.
    fn branch(&self, path: &PathState, branches: &Branches, k: u32) -> PathState {
        let part = match path.part {
            PathPart::Prefix(prefix) if branches.count > 1 => PathPart::Prefix(Prefix {
                number: prefix.number.map(|number| PathNumber {
                    index: number.index * branches.count + k,
                    count: SPLIT,
                }),
                ..prefix
            }),
            PathPart::Direction(direction) => PathPart::Chain(Chain {
                first_weight: self.vertices[direction.from as usize].path.first_weight,
                max_photon_radius: direction.max_photon_radius,
            }),
            PathPart::Prefix(_) | PathPart::Chain(_) => path.part,
        };
        PathState {
            stage: path.stage.after(Lobes::SPECULAR),
            part,
            ..*path
        }
    }
}
