//! The vertices of a round: emitted radiance, next-event estimation, and the next segment, in
//! packets of one material.

use super::numbers::VertexNumbers;
use super::state::PathState;
use crate::bsdf::{BsdfSamples, Lobes};
use crate::film::TileSamples;
use crate::ids::MaterialId;
use crate::integrators::camera_round::{Arrived, CameraRound, PathLanes};
use crate::integrators::connections::{
    Connections, EmitterQuery, EmitterReflection, ReflectingPath,
};
use crate::lanes::{Color, Float, Mask, Pair, Width};
use crate::scene::LimitedScene;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::roulette::camera_survivals;
use crate::transport::stream::{Bits, PacketShader, Walks, lanes_where};

/// Shades all vertices of a round.
pub(super) struct Shading<'a, 'o, 't> {
    pub(super) round: CameraRound<'a, 'a, PathState>,
    pub(super) next: &'o mut Walks<PathState>,
    pub(super) connections: &'o mut Connections,
    pub(super) out: &'o mut TileSamples<'t>,
}

impl PacketShader for Shading<'_, '_, '_> {
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
        round.see_emitters(at.v, lanes.emits, |path, seen| {
            path.add_emitted(round.scene, seen, self.out);
        });
        if lanes.firsts | (lanes.active & !lanes.ends) != 0 {
            self.advance(s, &mut at, lanes);
        }
    }
}

impl Shading<'_, '_, '_> {
    /// Connects the vertices to emitters, and appends the walks that go on.
    #[inline(always)]
    fn advance<S: Width>(&mut self, s: S, at: &mut Arrived<S, PathState>, lanes: PathLanes) {
        let round = self.round;
        let numbers = VertexNumbers::draw(s, at);
        let sample = (at.v.bsdf).sample_each_wi(at.v.w_prev, numbers.bsdf, Lobes::ALL);
        round.describe(at.v, || sample, lanes.firsts, self.out);
        let scatters = round.pass_through((at, numbers.transmission), lanes, self.next, self.out);
        self.connect(s, at, numbers.emitter, scatters);
        self.follow(s, (at, numbers.roulette), &sample, scatters);
    }

    /// Next-event estimation.
    #[inline(always)]
    fn connect<S: Width>(
        &mut self,
        s: S,
        at: &Arrived<S, PathState>,
        numbers: (Float<S>, Pair<S>),
        scatters: Bits,
    ) {
        let receives = scatters & at.v.bsdf.has(Lobes::FINITE).bits();
        if receives == 0 {
            return;
        }
        let query = EmitterQuery {
            numbers,
            guides: None,
            lanes: Mask::from_bits(s, receives),
        };
        let scene = LimitedScene {
            scene: self.round.scene,
            limits: self.round.limits,
        };
        (self.connections).connect_emitters(scene, at.v, query, &ByAllLobes { at });
    }

    /// Appends the walks that continue along the sampled directions; `u` are the numbers of Russian
    /// roulette.
    #[inline(always)]
    fn follow<S: Width>(
        &mut self,
        s: S,
        (at, u): (&Arrived<S, PathState>, Float<S>),
        sample: &BsdfSamples<S>,
        scatters: Bits,
    ) {
        let v = at.v;
        let mut alive = scatters & sample.valid.bits();
        let throughput = at.throughput * sample.weight;
        let eta_squared = at.eta_squared * sample.eta * sample.eta;
        let rr_depth = self.round.limits.rr_depth;
        let plays = lanes_where(alive, |i| v.segments.as_ref()[i] >= rr_depth);
        let mut survivor = throughput;
        if plays != 0 {
            let plays_in = Mask::from_bits(s, plays);
            let survival = camera_survivals(throughput, eta_squared);
            alive &= !plays | u.lt(survival).bits();
            survivor = throughput * plays_in.select(survival.recip(), 1.0);
        }
        let segments = v.next_camera_segments(sample, survivor, eta_squared);
        for i in set_bits(alive) {
            let path = at.paths.as_ref()[i];
            let path = PathState {
                stage: path.stage.after(segments.event(i)),
                ..path
            };
            self.next.push(segments.row(i, at.generators.get(i), path));
        }
    }
}

/// Reflection by all lobes, from which directions are sampled together.
struct ByAllLobes<'k, 'v, 's, S: Width> {
    at: &'k Arrived<'v, 's, S, PathState>,
}

impl<S: Width> EmitterReflection<S> for ByAllLobes<'_, '_, '_, S> {
    #[inline(always)]
    fn reflect(&self, lights: &EmitterSamples<S>) -> [Color<S>; 2] {
        let v = self.at.v;
        let seen = v.bsdf.direct_responses(lights.wi, v.w_prev);
        let scale = self.at.throughput * lights.weight * lights.mis_weight(seen.pdf);
        [scale * seen.non_specular, scale * seen.near_delta]
    }

    #[inline(always)]
    fn path(&self, i: usize) -> ReflectingPath {
        let path = &self.at.paths.as_ref()[i];
        ReflectingPath::before_event(path.first.pixel, path.stage)
    }
}
