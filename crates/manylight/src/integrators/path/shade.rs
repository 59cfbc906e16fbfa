//! The vertices of a round: emitted radiance, next-event estimation, and the next segment, in packets of one material.

use super::PathState;
use crate::bsdf::{BsdfSamples, Lobes};
use crate::color::Rgb;
use crate::film::TileSamples;
use crate::ids::MaterialId;
use crate::integrators::camera_round::{Arrived, CameraRound, PathLanes};
use crate::integrators::connections::{Connection, Connections};
use crate::lanes::{Float, Mask, Pair, Width, lane};
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::roulette::camera_survivals;
use crate::transport::stream::{Bits, PacketShader, WalkRow, Walks, lanes_where};

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
        if !lanes.matter() {
            return;
        }
        let v = round.vertices(s, material, packet);
        let mut at = round.arrive(s, &v, material);
        round.see_emitters(at.v, lanes.emits, |path, radiance| {
            self.out
                .add(path.pixel as usize, path.stage.layer(), radiance);
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
        let u_emitter = (at.generators.next(), at.generators.next_pair());
        let numbers = at.generators.next_bsdf();
        let sample = at.v.bsdf.sample_each_wi(at.v.w_prev, numbers, Lobes::ALL);
        round.describe(at.v, || sample, lanes.firsts, self.out);
        let scatters = round.go_on(at, lanes, self.next, self.out);
        self.connect(s, at, u_emitter, scatters);
        self.follow(s, at, &sample, scatters);
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
        let v = at.v;
        let receives = scatters & v.bsdf.has(Lobes::FINITE).bits();
        if receives == 0 {
            return;
        }
        let normals = v.bsdf.receiving_normals(v.w_prev);
        let receives = Mask::from_bits(s, receives);
        let lights = EmitterSamples::new(self.round.scene, &v.x, normals, numbers, None, receives);
        if lights.valid.none() {
            return;
        }
        let seen = v.bsdf.direct_responses(lights.wi, v.w_prev);
        let scale = at.throughput * lights.weight * lights.mis_weight(seen.pdf);
        let terms = [scale * seen.non_specular, scale * seen.near_delta];
        let is_lit = !(terms[0].is_black() & terms[1].is_black());
        let [non_specular, near_delta] = [terms[0].store(), terms[1].store()];
        let connection = |i: usize| {
            let path = at.paths.as_ref()[i];
            let layer = |event| path.stage.after(event).layer();
            Connection {
                pixel: path.pixel,
                max_crossings: self.round.limits.left_after(v.segments.as_ref()[i] + 1),
                terms: [
                    (layer(Lobes::DIFFUSE), Rgb::from(lane(&non_specular, i))),
                    (layer(Lobes::NEAR_DELTA), Rgb::from(lane(&near_delta, i))),
                ],
            }
        };
        let lanes = (lights.valid & is_lit).bits();
        self.connections.push_lanes(&lights, lanes, connection);
    }

    /// Appends the walks that continue along the sampled directions.
    #[inline(always)]
    fn follow<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<S, PathState>,
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
            let u = at.generators.next_within(plays_in);
            alive &= !plays | u.lt(survival).bits();
            survivor = throughput * plays_in.select(survival.recip(), 1.0);
        }
        let normals = v.normals();
        let (throughput, eta_squared) = (survivor.store(), eta_squared.store());
        let scattered = v.scattered(sample);
        for i in set_bits(alive) {
            let path = at.paths.as_ref()[i];
            self.next.push(WalkRow {
                ray: scattered.ray(i),
                throughput: lane(&throughput, i),
                eta_squared: eta_squared.as_ref()[i],
                segments: v.segments.as_ref()[i],
                previous: scattered.previous(i, normals.get(i)),
                sampler: at.generators.get(i),
                kept: PathState {
                    stage: path.stage.after(scattered.event(i)),
                    ..path
                },
            });
        }
    }
}
