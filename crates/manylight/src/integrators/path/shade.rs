//! The vertices of a round: emitted radiance, next-event estimation, and the next segment, in packets of one material.

use super::connections::{Connection, Connections};
use super::{PathState, add_emitted};
use crate::bsdf::{Bsdf, BsdfSamples, Lobes};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::geometry::{Hit, Ray, SurfacePoint, SurfacePoints};
use crate::ids::MaterialId;
use crate::integrators::first_event::FirstEvent;
use crate::lanes::{Color, Float, LaneKernel, Mask, Vector, Width};
use crate::math::{Vec2, Vec3};
use crate::scene::{PathLimits, Scene};
use crate::simd::set_bits;
use crate::transport::direct::{EmitterSample, emitted_with_mis};
use crate::transport::stream::{Arrivals, Generators, WalkRow, Walks};
use crate::transport::walk::Previous;

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

impl LaneKernel for Shading<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Width>(mut self, s: S) {
        let arrivals = self.arrivals;
        for (material, walks) in arrivals.runs() {
            for packet in walks.chunks(S::LANES) {
                self.shade(s, material, packet);
            }
        }
    }
}

/// The vertices of a packet.
struct Vertices<'a, S: Width> {
    /// The walks; in unused lanes the first.
    index: S::Each<u32>,
    hits: S::Each<Hit>,
    points: S::Each<SurfacePoint>,
    x: SurfacePoints<S>,
    bsdf: Bsdf<'a, S>,
    w_prev: Vector<S>,
    /// Segments up to here, by lane.
    segments: S::Each<u32>,
}

/// Lanes of a packet, one bit each.
type Bits = u32;

impl<'a> Shading<'a, '_, '_> {
    /// Shades a packet of walks that hit one material.
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let (scene, limits, walks) = (self.scene, self.limits, self.walks);
        let active: Bits = u32::MAX >> (32 - packet.len());
        let index = s.each(|i| packet[if i < packet.len() { i } else { 0 }]);
        let walk = |i: usize| index.as_ref()[i] as usize;
        let hits = s.each(|i| self.arrivals.hits[walk(i)].expect("invariant: walks of runs hit"));
        let points = s.each(|i| scene.surface_point(hits.as_ref()[i].at));
        let w_prev = Vector::from_fn(s, |i| -walks.rays[walk(i)].d);
        self.add_emission(&index, &points, active);

        let segments = s.each(|i| walks.segments[walk(i)] + 1);
        let lanes = |test: &dyn Fn(usize) -> bool| {
            set_bits(active).fold(0, |bits, i| bits | u32::from(test(i)) << i)
        };
        let firsts = lanes(&|i| walks.event(index.as_ref()[i]) == Lobes::NONE);
        let ends = lanes(&|i| !limits.allow(segments.as_ref()[i] + 1));
        if active & (firsts | !ends) == 0 {
            return;
        }
        let x = SurfacePoints::load(s, &points);
        let vertices = Vertices {
            bsdf: scene.materials.bsdfs(material, &x, &scene.textures),
            index,
            hits,
            points,
            x,
            w_prev,
            segments,
        };
        self.advance(s, &vertices, active, (firsts, ends));
    }

    /// Adds the radiance that the surfaces emit towards the walks.
    #[inline(always)]
    fn add_emission<I, P>(&mut self, index: &I, points: &P, active: Bits)
    where
        I: AsRef<[u32]>,
        P: AsRef<[SurfacePoint]>,
    {
        for i in set_bits(active) {
            let (walk, y) = (index.as_ref()[i], &points.as_ref()[i]);
            let primitive = &self.scene.geometry.primitives()[y.at.primitive.index()];
            if primitive.emitter.is_some() {
                let previous = &self.walks.previous[walk as usize];
                let wo = -self.walks.rays[walk as usize].d;
                let radiance = emitted_with_mis(self.scene, previous, y, wo);
                add_emitted(self.walks, walk, radiance, self.out);
            }
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
        let walk = |i: usize| v.index.as_ref()[i] as usize;
        let mut generators = Generators::from_fn(s, |i| &walks.samplers[walk(i)]);
        let u_emitter = (generators.next(), generators.next_pair());
        let sample = v
            .bsdf
            .sample_each_wi(v.w_prev, generators.next_bsdf(), Lobes::ALL);
        self.add_first_surfaces(v, &sample, active);
        for i in set_bits(active & firsts & ends) {
            let opacity = 1.0 - v.transmittance(i);
            self.add_event(v, i, opacity);
        }
        let goes_on = active & !ends;
        let mut throughput = walks.throughput(s, &v.index);
        let u_through = generators.next_within(Mask::from_bits(s, goes_on));
        let mut passes = 0;
        if let Some(transmittance) = v.bsdf.transmittances(v.w_prev) {
            let p = transmittance.max_channel().min(1.0);
            let is_open = p.gt(0.0);
            let through = is_open & u_through.lt(p);
            passes = through.bits() & goes_on;
            let factor = Color::select(through, transmittance / p, Color::grey((1.0 - p).recip()));
            let factor = Color::select(is_open, factor, Color::grey(p.same(1.0)));
            throughput = throughput * factor;
            self.pass_through(s, v, throughput, &generators, passes);
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
    fn add_first_surfaces<S: Width>(
        &mut self,
        v: &Vertices<S>,
        sample: &BsdfSamples<S>,
        active: Bits,
    ) {
        if v.segments.as_ref().iter().all(|&count| count > 1) {
            return;
        }
        let albedo = sample.weight.within(sample.valid).store();
        for i in set_bits(active).filter(|&i| v.segments.as_ref()[i] == 1) {
            let path = self.walks.kept[v.index.as_ref()[i] as usize];
            let pixel = path.pixel as usize;
            let n = v.points.as_ref()[i].frame.n;
            let depth = path.hidden + v.hits.as_ref()[i].t;
            let albedo = albedo.each_ref().map(|channel| channel.as_ref()[i]);
            self.out.add(pixel, Layer::Normal, Rgb::new(n.x, n.y, n.z));
            self.out.add(pixel, Layer::Depth, Rgb::splat(depth));
            self.out.add(pixel, Layer::Albedo, albedo.into());
        }
    }

    /// Adds the vertex in lane `i` as the first event of its path.
    #[inline(always)]
    fn add_event<S: Width>(&mut self, v: &Vertices<S>, i: usize, opacity: f32) {
        let x = &v.points.as_ref()[i];
        let event = FirstEvent::Surface {
            at: x.at,
            p: x.p,
            opacity,
        };
        let path = self.walks.kept[v.index.as_ref()[i] as usize];
        path.add_event(self.scene, event, self.out);
    }

    /// Appends the walks that continue straight through.
    #[inline(always)]
    fn pass_through<S: Width>(
        &mut self,
        _s: S,
        v: &Vertices<S>,
        throughput: Color<S>,
        generators: &Generators<S>,
        passes: Bits,
    ) {
        let throughput = throughput.store();
        for i in set_bits(passes) {
            let walk = v.index.as_ref()[i] as usize;
            let ray = &self.walks.rays[walk];
            self.next.push(WalkRow {
                ray: Ray {
                    t_max: ray.t_max - v.hits.as_ref()[i].t,
                    ..v.points.as_ref()[i].spawn(ray.d)
                },
                throughput: throughput.each_ref().map(|channel| channel.as_ref()[i]),
                eta_squared: self.walks.eta_squared[walk],
                segments: v.segments.as_ref()[i],
                previous: self.walks.previous[walk],
                sampler: generators.get(i),
                kept: self.walks.kept[walk],
            });
        }
    }

    /// Next-event estimation.
    #[inline(always)]
    fn connect<S: Width>(
        &mut self,
        s: S,
        v: &Vertices<S>,
        throughput: Color<S>,
        (u_choice, u): (Float<S>, crate::lanes::Pair<S>),
        scatters: Bits,
    ) {
        let receives = scatters & v.bsdf.has(Lobes::FINITE).bits();
        if receives == 0 {
            return;
        }
        let (n, is_one_sided) = v.bsdf.receiving_normals(v.w_prev);
        let (n, one_sided) = (n.store(), is_one_sided.bits());
        let (u_choice, u_x, u_y) = (u_choice.store(), u.x.store(), u.y.store());
        let lights: S::Each<Option<EmitterSample>> = s.each(|i| {
            if receives >> i & 1 == 0 {
                return None;
            }
            let n = Vec3::from(n.each_ref().map(|component| component.as_ref()[i]));
            let n = (one_sided >> i & 1 != 0).then_some(n);
            let u = Vec2::new(u_x.as_ref()[i], u_y.as_ref()[i]);
            let plan = self.scene.emitters.plan(u_choice.as_ref()[i], u);
            EmitterSample::new(self.scene, &v.points.as_ref()[i], n, &plan)
        });
        let light = |i: usize| lights.as_ref()[i].as_ref();
        let wi = Vector::from_fn(s, |i| light(i).map_or(Vec3::Z, |light| light.wi));
        let seen = v.bsdf.direct_responses(wi, v.w_prev);
        let pdf = Float::from_fn(s, |i| light(i).map_or(1.0, |light| light.pdf));
        let weight = Color::from_fn(s, |i| light(i).map_or(Rgb::BLACK, |light| light.weight));
        let (pdf2, walk2) = (pdf * pdf, seen.pdf * seen.pdf);
        let mis = pdf.gt(0.0).select(pdf2 / (pdf2 + walk2), 1.0);
        let scale = throughput * weight * mis;
        let terms = [scale * seen.non_specular, scale * seen.near_delta];
        let is_lit = !(terms[0].is_black() & terms[1].is_black());
        let terms = terms.map(Color::store);
        for i in set_bits(receives & is_lit.bits()) {
            let Some(&light) = light(i) else {
                continue;
            };
            let walk = v.index.as_ref()[i] as usize;
            let path = self.walks.kept[walk];
            let value = |k: usize| {
                let channels: &[S::Each<f32>; 3] = &terms[k];
                Rgb::from(channels.each_ref().map(|channel| channel.as_ref()[i]))
            };
            self.connections.push(Connection {
                pixel: path.pixel,
                light,
                max_crossings: self.limits.left_after(v.segments.as_ref()[i] + 1),
                terms: [
                    (path.stage.after(Lobes::DIFFUSE).layer(), value(0)),
                    (path.stage.after(Lobes::NEAR_DELTA).layer(), value(1)),
                ],
            });
        }
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
        let walk = |i: usize| v.index.as_ref()[i] as usize;
        let mut alive = scatters & sample.valid.bits();
        let throughput = throughput * sample.weight;
        let eta_squared =
            Float::from_fn(s, |i| walks.eta_squared[walk(i)]) * sample.eta * sample.eta;
        let rr_depth = self.limits.rr_depth;
        let plays = set_bits(alive)
            .filter(|&i| v.segments.as_ref()[i] >= rr_depth)
            .fold(0u32, |bits, i| bits | 1 << i);
        let mut survivor = throughput;
        if plays != 0 {
            let plays_in = Mask::from_bits(s, plays);
            let survival = (throughput.max_channel() * eta_squared).clamp(0.0, 0.95);
            let u = generators.next_within(plays_in);
            alive &= !plays | u.lt(survival).bits();
            survivor = throughput * plays_in.select(survival.recip(), 1.0);
        }
        let n = v.bsdf.receiving_normals(v.w_prev);
        let (normal, one_sided) = (n.0.store(), n.1.bits());
        let (throughput, eta_squared) = (survivor.store(), eta_squared.store());
        let origin = v.x.offset_towards(sample.w).store();
        let (w, pdf, lobe) = (sample.w.store(), sample.pdf.store(), sample.lobe.store());
        let vector = |v: &[S::Each<f32>; 3], i: usize| {
            Vec3::from(v.each_ref().map(|component| component.as_ref()[i]))
        };
        for i in set_bits(alive) {
            let event = Lobes(lobe.as_ref()[i] as u8);
            let path = walks.kept[walk(i)];
            self.next.push(WalkRow {
                ray: Ray::new(vector(&origin, i), vector(&w, i)),
                throughput: throughput.each_ref().map(|channel| channel.as_ref()[i]),
                eta_squared: eta_squared.as_ref()[i],
                segments: v.segments.as_ref()[i],
                previous: Previous {
                    p: v.points.as_ref()[i].p,
                    n: (one_sided >> i & 1 != 0).then(|| vector(&normal, i)),
                    event,
                    pdf: pdf.as_ref()[i],
                },
                sampler: generators.get(i),
                kept: PathState {
                    stage: path.stage.after(event),
                    ..path
                },
            });
        }
    }
}

impl<S: Width> Vertices<'_, S> {
    /// Largest channel of the straight-through transmittance of lane `i`, at most 1.
    fn transmittance(&self, i: usize) -> f32 {
        let transmittance = self.bsdf.transmittances(self.w_prev);
        transmittance.map_or(0.0, |t| t.max_channel().min(1.0).store().as_ref()[i])
    }
}
