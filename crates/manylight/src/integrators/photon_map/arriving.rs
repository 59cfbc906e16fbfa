//! The vertices of a round: emitted radiance, density estimates and next-event estimation, and the
//! next segment, in packets of one material.

use super::camera_paths::{PathState, TilePaths};
use crate::bsdf::Lobes;
use crate::emitters::{EnvironmentLobes, LobesOfLanes};
use crate::ids::MaterialId;
use crate::integrators::camera_round::{Arrived, CameraRound};
use crate::integrators::connections::{EmitterQuery, EmitterReflection, ReflectingPath};
use crate::integrators::guiding::{environment_guide, guided_pdfs, sample_directions};
use crate::integrators::partition::PathStage;
use crate::lanes::{Color, Float, Mask, Width};
use crate::scene::LimitedScene;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::roulette::camera_survivals;
use crate::transport::stream::{Bits, PacketShader, Walks, lanes_where};

/// Directions, and emitter samples, for the lobes that end a camera path. At 1 and 4 (2 passes of
/// `photon-map` at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE +6.5 and -12 % (standard error 6
/// %), shadow rays -48 and +97 %.
const ENDING_DIRECTIONS: u32 = 2;
/// Factor from the weight of a camera path to its probability of survival before `rr_depth`: only
/// the weakest paths are terminated. At 4 and 16 (2 passes of `photon-map` at 72x40, 3 seeds;
/// Glossy Room, Kitchen): relMSE +8.3 and -5.4 % (standard error 2 %), shadow rays -8 and +12 %.
const SURVIVAL_FACTOR: f32 = 8.0;

/// The camera paths of a round, at the ends of their segments.
pub(super) struct Arriving<'a, 'p, 's, 'o, 't> {
    pub(super) round: CameraRound<'a, 's, PathState>,
    pub(super) next: &'a mut Walks<PathState>,
    pub(super) tile: &'a mut TilePaths<'p, 's, 'o, 't>,
}

/// How the lobes at a vertex are divided: those that gather, and the others, which are followed.
#[derive(Clone, Copy)]
struct Division {
    gathering: Lobes,
    followed: Lobes,
}

/// Lobes that reflect the light of an emitter, and the guide of directions sampled from them.
struct Reflection<'g, S: Width> {
    lobes: Lobes,
    guides: LobesOfLanes<'g, S>,
}

impl PacketShader for Arriving<'_, '_, '_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let round = self.round;
        let lanes = round.lanes(packet);
        if lanes.are_done() {
            return;
        }
        let mut v = round.vertices(s, material, packet);
        v.add_leaves(round.scene, material);
        let mut at = round.arrive(s, &v, material);
        let (pass, out) = (self.tile.pass, &mut *self.tile.out);
        round.see_emitters(at.v, lanes.emits, |path, seen| {
            pass.add_emitted(path, seen, out);
        });
        let scatters = round.describe_and_pass_through(&mut at, lanes, self.next, out);
        let scatters = lanes_where(scatters, |i| !at.paths.as_ref()[i].ends);
        if scatters == 0 {
            return;
        }
        let all_gather = scatters & self.all_gather(&at).bits();
        for (lanes, gathering) in [
            (all_gather, Lobes::NON_SPECULAR),
            (scatters & !all_gather, Lobes::DIFFUSE),
        ] {
            if lanes != 0 {
                let followed = Lobes(Lobes::ALL.0 & !gathering.0);
                let division = Division {
                    gathering,
                    followed,
                };
                self.scatter(s, &mut at, lanes, division);
            }
        }
    }
}

impl<'s> Arriving<'_, '_, 's, '_, '_> {
    /// The lanes in which all non-specular lobes gather.
    #[inline(always)]
    fn all_gather<S: Width>(&self, at: &Arrived<S, PathState>) -> Mask<S> {
        let roughness = at.v.bsdf.glossy_roughnesses();
        let method = self.tile.pass.method;
        let before = lanes_where(u32::MAX >> (32 - S::LANES), |i| {
            at.paths.as_ref()[i].stage == PathStage::BeforeX
        });
        let blurs = Mask::from_bits(roughness.width(), !before);
        method.glossy_gather(roughness) | blurs
    }

    /// Estimates the light at the vertices in `lanes`, and appends the paths that go on.
    #[inline(always)]
    fn scatter<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<'_, 's, S, PathState>,
        lanes: Bits,
        division: Division,
    ) {
        let Division {
            gathering,
            followed,
        } = division;
        let guides = self.gather(at, lanes, gathering);
        let has_guides = !guides.is_empty();
        let guides = s.each(|i| guides.get(i).and_then(Option::as_ref));
        let guides = has_guides.then_some(&guides);
        let ends = match self.tile.pass.gathers_emitters() {
            true => 0,
            false => lanes & at.v.bsdf.has(gathering).bits(),
        };
        let follows = Reflection {
            lobes: followed,
            guides: None,
        };
        if ends != 0 {
            let gathers = Reflection {
                lobes: gathering,
                guides,
            };
            let throughput = at.throughput * (1.0 / ENDING_DIRECTIONS as f32);
            for k in 0..ENDING_DIRECTIONS {
                self.connect(s, at, (ends, throughput), &[&gathers, &follows]);
                self.end(s, at, (ends, throughput), &gathers, k);
            }
        }
        if lanes & !ends != 0 {
            let throughput = at.throughput;
            self.connect(s, at, (lanes & !ends, throughput), &[&follows]);
        }
        self.follow(s, at, lanes, followed);
    }

    /// Adds the density estimates at the vertices in `lanes`. Returns the guides of directions from
    /// lobes that gather, by lane; an empty list if there is none.
    #[inline(always)]
    fn gather<S: Width>(
        &mut self,
        at: &mut Arrived<'_, 's, S, PathState>,
        lanes: Bits,
        gathering: Lobes,
    ) -> Vec<Option<EnvironmentLobes>> {
        let mut guides = Vec::new();
        let lanes = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
        if lanes == 0 {
            return guides;
        }
        let values = at.values();
        for i in set_bits(lanes) {
            let vertex = at.vertex(self.round.scene, &values, i);
            let (path, throughput) = (at.paths.as_ref()[i], values.throughput(i));
            self.tile.gather((&path, throughput), &vertex, gathering);
            let (incident, found) = (&self.tile.pass.incident, &mut self.tile.found_incident);
            if let Some(guide) = environment_guide(incident, &vertex, found) {
                guides.resize_with(S::LANES, || None);
                guides[i] = Some(guide);
            }
        }
        guides
    }

    /// Next-event estimation for sets of lobes, from each of which directions are sampled as well.
    #[inline(always)]
    fn connect<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<S, PathState>,
        (lanes, throughput): (Bits, Color<S>),
        sets: &[&Reflection<S>],
    ) {
        let lobes = sets.iter().fold(Lobes::NONE, |all, set| all.or(set.lobes));
        let lanes = lanes & at.v.bsdf.has(lobes.and(Lobes::FINITE)).bits();
        let numbers = (at.generators.next(), at.generators.next_pair());
        if lanes == 0 {
            return;
        }
        let query = EmitterQuery {
            numbers,
            guides: None,
            lanes: Mask::from_bits(s, lanes),
        };
        let reflection = BySets {
            at,
            sets,
            throughput,
            camera_paths: self.tile.pass.camera_paths,
            lanes,
        };
        let scene = LimitedScene {
            scene: self.round.scene,
            limits: self.round.limits,
        };
        (self.tile.connections).connect_emitters(scene, at.v, query, &reflection);
    }

    /// Appends paths along direction `k` sampled from lobes that gather: they end at emitters.
    #[inline(always)]
    fn end<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<S, PathState>,
        (lanes, throughput): (Bits, Color<S>),
        set: &Reflection<S>,
        k: u32,
    ) {
        let numbers = at.generators.next_bsdf();
        let u = (at.generators.next() + k as f32) * (1.0 / ENDING_DIRECTIONS as f32);
        let samples = sample_directions(at.v, set.guides, set.lobes, numbers, u);
        let alive = samples.valid & !samples.weight.is_black() & Mask::from_bits(s, lanes);
        let one = Float::splat(s, 1.0);
        let segments = (at.v).next_camera_segments(&samples, throughput * samples.weight, one);
        for i in set_bits(alive.bits()) {
            let path = at.paths.as_ref()[i].after(set.lobes).ending();
            let sampler = at.generators.draw(i, |sampler| sampler.branch());
            self.next.push(segments.row(i, sampler, path));
        }
    }

    /// Appends the paths that continue by an event of `lobes`.
    #[inline(always)]
    fn follow<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<S, PathState>,
        lanes: Bits,
        lobes: Lobes,
    ) {
        let lanes = lanes & at.v.bsdf.has(lobes).bits();
        if lanes == 0 {
            return;
        }
        let numbers = at.generators.next_bsdf();
        let samples = at.v.bsdf.sample_each_wi(at.v.w_prev, numbers, lobes);
        let throughput = at.throughput * samples.weight;
        let eta_squared = at.eta_squared * samples.eta * samples.eta;
        let rr_depth = self.round.limits.rr_depth;
        let plays = lanes_where(lanes, |i| at.v.segments.as_ref()[i] >= rr_depth);
        let weight = throughput.max_channel() * eta_squared;
        let survival = Mask::from_bits(s, plays).select(
            camera_survivals(throughput, eta_squared),
            (weight * SURVIVAL_FACTOR).min(1.0),
        );
        let alive = samples.valid & at.generators.next().lt(survival);
        let segments = (at.v).next_camera_segments(&samples, throughput / survival, eta_squared);
        for i in set_bits(lanes & alive.bits()) {
            let path = at.paths.as_ref()[i].after(segments.event(i));
            self.next.push(segments.row(i, at.generators.get(i), path));
        }
    }
}

/// Reflection by sets of lobes, from each of which directions are sampled as well.
struct BySets<'k, 'v, 's, 'g, S: Width> {
    at: &'k Arrived<'v, 's, S, PathState>,
    sets: &'k [&'k Reflection<'g, S>],
    throughput: Color<S>,
    /// Camera paths per pixel.
    camera_paths: u32,
    lanes: Bits,
}

impl<S: Width> EmitterReflection<S> for BySets<'_, '_, '_, '_, S> {
    #[inline(always)]
    fn reflect(&self, lights: &EmitterSamples<S>) -> [Color<S>; 2] {
        let (v, s) = (self.at.v, lights.pdf.width());
        // After a non-specular event, photons estimate what emitters send by near-delta lobes.
        let is_first = lanes_where(self.lanes, |i| {
            self.at.paths.as_ref()[i].stage == PathStage::BeforeX
        });
        let classes = [
            (Lobes::NON_SPECULAR, Mask::from_bits(s, self.lanes)),
            (Lobes::NEAR_DELTA, Mask::from_bits(s, is_first)),
        ];
        let mut terms = [Color::black(s); 2];
        for set in self.sets {
            let (_, pdf) = v.bsdf.responses(lights.wi, v.w_prev, set.lobes);
            let weight = lights.mis_weight(guided_pdfs(pdf, set.guides, lights.wi));
            for ((class, within), term) in classes.into_iter().zip(&mut terms) {
                let lobes = set.lobes.and(class);
                if v.bsdf.has(lobes).any() {
                    let (f_cos, _) = v.bsdf.responses(lights.wi, v.w_prev, lobes);
                    *term += (f_cos * weight).within(within);
                }
            }
        }
        let arriving = self.throughput * lights.weight * (1.0 / self.camera_paths as f32);
        [terms[0] * arriving, terms[1] * arriving]
    }

    #[inline(always)]
    fn path(&self, i: usize) -> ReflectingPath {
        let path = &self.at.paths.as_ref()[i];
        ReflectingPath::before_event(path.first.pixel, path.stage)
    }
}
