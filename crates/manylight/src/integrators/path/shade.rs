//! The vertices of a round: emitted radiance, next-event estimation, and the next segment, in packets of one material.

use super::{PathState, add_emitted};
use crate::bsdf::{BsdfSamples, Lobes};
use crate::color::Rgb;
use crate::film::TileSamples;
use crate::ids::MaterialId;
use crate::integrators::connections::{Connection, Connections};
use crate::integrators::first_event::FirstEvent;
use crate::integrators::first_surface::{FirstSurface, add_first_surfaces};
use crate::lanes::{Color, Float, Mask, Pair, Width, lane};
use crate::math::Vec3;
use crate::scene::{PathLimits, Scene};
use crate::simd::set_bits;
use crate::transport::direct_lanes::{EmitterSamples, emitted_with_mis_lanes};
use crate::transport::roulette::camera_survivals;
use crate::transport::stream::{
    Arrivals, Bits, Generators, PacketShader, Vertices, WalkRow, Walks, lanes_where, used,
};

/// Shades all vertices of a round.
pub(super) struct Shading<'a, 'o, 't> {
    pub(super) scene: &'a Scene,
    pub(super) limits: PathLimits,
    pub(super) walks: &'a Walks<PathState>,
    pub(super) arrivals: &'a Arrivals,
    pub(super) next: &'o mut Walks<PathState>,
    pub(super) connections: &'o mut Connections,
    pub(super) out: &'o mut TileSamples<'t>,
}

impl PacketShader for Shading<'_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let (scene, limits, walks) = (self.scene, self.limits, self.walks);
        let active = used(packet.len());
        let primitives = scene.geometry.primitives();
        let emits = lanes_where(active, |i| {
            let hit = self.arrivals.hits[packet[i] as usize];
            hit.is_some_and(|hit| primitives[hit.at.primitive.index()].emitter.is_some())
        });
        let firsts = lanes_where(active, |i| walks.event(packet[i]) == Lobes::NONE);
        let ends = lanes_where(active, |i| {
            !limits.allow(walks.segments[packet[i] as usize] + 2)
        });
        let matters = firsts | (active & !ends);
        if emits | matters == 0 {
            return;
        }
        let vertices = Vertices::new(s, scene, walks, self.arrivals, material, packet);
        if emits != 0 {
            self.add_emission(&vertices, emits);
        }
        if matters != 0 {
            self.advance(s, &vertices, active, (firsts, ends));
        }
    }
}

impl Shading<'_, '_, '_> {
    /// Adds the radiance that the surfaces emit towards the walks.
    #[inline(always)]
    fn add_emission<S: Width>(&mut self, v: &Vertices<S>, emits: Bits) {
        let previous = self.walks.previous_events(v.w_prev.x.width(), &v.index);
        let emits = v.mask(emits);
        let radiance = emitted_with_mis_lanes(self.scene, &previous, &v.x, v.w_prev, emits);
        let radiance = radiance.store();
        for i in set_bits(emits.bits()) {
            let radiance = Rgb::from(lane(&radiance, i));
            add_emitted(self.walks, v.index.as_ref()[i], radiance, self.out);
        }
    }

    /// Connects the vertices to emitters, and appends the walks that go on.
    #[inline(always)]
    fn advance<S: Width>(
        &mut self,
        s: S,
        v: &Vertices<S>,
        active: Bits,
        (firsts, ends): (Bits, Bits),
    ) {
        let walks = self.walks;
        let mut generators = v.generators(s, walks);
        let u_emitter = (generators.next(), generators.next_pair());
        let sample = v
            .bsdf
            .sample_each_wi(v.w_prev, generators.next_bsdf(), Lobes::ALL);
        self.describe(v, &sample, active);
        for i in set_bits(active & firsts & ends) {
            self.add_event(v, i, v.opacity(i));
        }
        let goes_on = active & !ends;
        let mut throughput = walks.throughput(s, &v.index);
        let u_through = generators.next_within(Mask::from_bits(s, goes_on));
        let mut passes = 0;
        if let Some((through, factor)) = v.passes(u_through, goes_on) {
            passes = through;
            throughput = throughput * factor;
            let kept = (passes, |i| v.kept(walks, i));
            v.pass_through(walks, self.next, throughput, &generators, kept);
        }
        let scatters = goes_on & !passes;
        for i in set_bits(scatters & firsts) {
            self.add_event(v, i, 1.0);
        }
        self.connect(s, v, throughput, u_emitter, scatters);
        self.follow(s, v, throughput, &sample, generators, scatters);
    }

    /// Adds the layers that describe the first surface of the camera paths that arrive at their first vertex.
    #[inline(always)]
    fn describe<S: Width>(&mut self, v: &Vertices<S>, samples: &BsdfSamples<S>, active: Bits) {
        let lanes = lanes_where(active, |i| v.segments.as_ref()[i] == 1);
        if lanes == 0 {
            return;
        }
        let first = |i: usize| {
            let path = v.kept(self.walks, i);
            FirstSurface {
                pixel: path.pixel as usize,
                depth: path.hidden + v.hits.as_ref()[i].t,
                share: 1.0,
            }
        };
        add_first_surfaces(v, samples, lanes, first, self.out);
    }

    /// Adds the vertex in lane `i` as the first event of its path.
    #[inline(always)]
    fn add_event<S: Width>(&mut self, v: &Vertices<S>, i: usize, opacity: f32) {
        let event = FirstEvent::surface(v, i, opacity);
        let path = v.kept(self.walks, i);
        path.add_event(self.scene, event, self.out);
    }

    /// Next-event estimation.
    #[inline(always)]
    fn connect<S: Width>(
        &mut self,
        s: S,
        v: &Vertices<S>,
        throughput: Color<S>,
        numbers: (Float<S>, Pair<S>),
        scatters: Bits,
    ) {
        let receives = scatters & v.bsdf.has(Lobes::FINITE).bits();
        if receives == 0 {
            return;
        }
        let normals = v.bsdf.receiving_normals(v.w_prev);
        let receives = Mask::from_bits(s, receives);
        let lights = EmitterSamples::new(self.scene, &v.x, normals, numbers, None, receives);
        if lights.valid.none() {
            return;
        }
        let seen = v.bsdf.direct_responses(lights.wi, v.w_prev);
        let scale = throughput * lights.weight * lights.mis_weight(seen.pdf);
        let terms = [scale * seen.non_specular, scale * seen.near_delta];
        let is_lit = !(terms[0].is_black() & terms[1].is_black());
        let [non_specular, near_delta] = [terms[0].store(), terms[1].store()];
        let connection = |i: usize| {
            let path = v.kept(self.walks, i);
            let layer = |event| path.stage.after(event).layer();
            Connection {
                pixel: path.pixel,
                max_crossings: self.limits.left_after(v.segments.as_ref()[i] + 1),
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
        v: &Vertices<S>,
        throughput: Color<S>,
        sample: &BsdfSamples<S>,
        mut generators: Generators<S>,
        scatters: Bits,
    ) {
        let walks = self.walks;
        let mut alive = scatters & sample.valid.bits();
        let throughput = throughput * sample.weight;
        let eta_squared = v.eta_squared(s, walks) * sample.eta * sample.eta;
        let rr_depth = self.limits.rr_depth;
        let plays = lanes_where(alive, |i| v.segments.as_ref()[i] >= rr_depth);
        let mut survivor = throughput;
        if plays != 0 {
            let plays_in = Mask::from_bits(s, plays);
            let survival = camera_survivals(throughput, eta_squared);
            let u = generators.next_within(plays_in);
            alive &= !plays | u.lt(survival).bits();
            survivor = throughput * plays_in.select(survival.recip(), 1.0);
        }
        let n = v.bsdf.receiving_normals(v.w_prev);
        let (normal, one_sided) = (n.0.store(), n.1.bits());
        let (throughput, eta_squared) = (survivor.store(), eta_squared.store());
        let scattered = v.scattered(sample);
        for i in set_bits(alive) {
            let path = v.kept(walks, i);
            let n = (one_sided >> i & 1 != 0).then(|| Vec3::from(lane(&normal, i)));
            self.next.push(WalkRow {
                ray: scattered.ray(i),
                throughput: lane(&throughput, i),
                eta_squared: eta_squared.as_ref()[i],
                segments: v.segments.as_ref()[i],
                previous: scattered.previous(i, n),
                sampler: generators.get(i),
                kept: PathState {
                    stage: path.stage.after(scattered.event(i)),
                    ..path
                },
            });
        }
    }
}
