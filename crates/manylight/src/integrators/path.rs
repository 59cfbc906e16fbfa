//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so that each of their terms can be checked by itself.
//!
//! The paths of a tile advance in stages: all plan an emitter sample, all follow their rays, all look up the surface, all
//! scatter, then all shadow rays are tested. Each stage keeps its code in the instruction cache and prefetches the memory
//! that the next stage reads.

use super::context::PassContext;
use super::first_event::{FirstEvent, SampleShare, add_first_event};
use super::first_surface::add_sampled_first_surface;
use super::partition::PathStage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::EmitterPlan;
use crate::film::{Film, Layer, TileSamples};
use crate::math::UVec2;
use crate::sampling::{Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::direct::{EmitterSample, draw_emitter_plan};
use crate::transport::{Arrival, SegmentEnd, Vertex, Walk, roulette};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, UVec2::ZERO, |samples| {
        let start = |(index, pixel)| {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let at = positions.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let throughput = Rgb::splat(camera.weight * at.weight);
            TracedPath {
                index,
                walk: Walk::from_sensor(scene, limits, camera.ray, throughput),
                stage: PathStage::BeforeX,
                sampler,
                filter_weight: at.weight,
            }
        };
        let paths: Vec<TracedPath> = samples.tile().pixels().enumerate().map(start).collect();
        Stats::count(&run.stats.camera_paths, paths.len() as u64);
        let shadow_rays = trace(scene, limits, paths, samples);
        Stats::count(&run.stats.shadow_rays, shadow_rays);
    })
}

/// Follows all paths to their ends and returns the number of shadow rays.
fn trace(
    scene: &Scene,
    limits: PathLimits,
    mut paths: Vec<TracedPath>,
    out: &mut TileSamples,
) -> u64 {
    let mut shadow_rays = 0;
    let mut plans = Vec::with_capacity(paths.len());
    let mut arrivals = Vec::with_capacity(paths.len());
    let mut ends = Vec::with_capacity(paths.len());
    let mut connections = Vec::with_capacity(paths.len());
    while !paths.is_empty() {
        plan_emitters(scene, &mut paths, &mut plans);
        follow_rays(scene, &mut paths, &mut plans, &mut arrivals);
        let surfaces = arrivals.drain(..).map(|a| SegmentEnd::new(scene, a));
        ends.extend(surfaces);
        for end in &ends {
            if let SegmentEnd::Surface(x, _) = end {
                scene.prefetch_bsdf(x);
            }
        }
        let mut here = ends.drain(..).zip(plans.drain(..));
        paths.retain_mut(|path| {
            here.next().is_some_and(|(end, plan)| {
                path.scatter(scene, limits, (end, &plan), &mut connections, out)
            })
        });
        drop(here);
        shadow_rays += connections.len() as u64;
        for connection in connections.drain(..) {
            connection.add(scene, out);
        }
    }
    shadow_rays
}

/// Plans one emitter sample for each path.
fn plan_emitters(scene: &Scene, paths: &mut [TracedPath], plans: &mut Vec<EmitterPlan>) {
    let draw = |path: &mut TracedPath| draw_emitter_plan(scene, &mut path.sampler);
    plans.extend(paths.iter_mut().map(draw));
    plans
        .iter_mut()
        .for_each(|plan| scene.emitters.prefetch_step(plan));
}

/// Intersects the rays of all paths, and prefetches what is there and what the emitter samples need.
fn follow_rays(
    scene: &Scene,
    paths: &mut [TracedPath],
    plans: &mut [EmitterPlan],
    arrivals: &mut Vec<Arrival>,
) {
    for path in paths {
        let arrival = path.walk.arrive();
        if let Arrival::Hit(at, _) = arrival {
            scene.geometry.prefetch(at);
        }
        arrivals.push(arrival);
    }
    plans
        .iter_mut()
        .for_each(|plan| scene.emitters.prefetch_step(plan));
    for (arrival, plan) in arrivals.iter().zip(plans) {
        if let Arrival::Hit(..) = arrival {
            scene.emitters.prefetch_step(plan);
        }
    }
    for arrival in arrivals {
        if let Arrival::Hit(at, _) = arrival {
            scene.geometry.prefetch_vertices(*at);
        }
    }
}

/// A camera path.
struct TracedPath<'s> {
    /// Index of its pixel in the tile.
    index: usize,
    walk: Walk<'s>,
    stage: PathStage,
    sampler: Sampler,
    /// Weight by the reconstruction filter.
    filter_weight: f32,
}

/// Light from an emitter that a path reflects, visibility not yet tested. Low-roughness lobes belong to another layer than
/// non-specular ones, so that there are two terms.
struct EmitterConnection {
    index: usize,
    light: EmitterSample,
    /// Transparent surfaces that the shadow ray may cross.
    max_crossings: u32,
    terms: [(Layer, Rgb); 2],
}

impl EmitterConnection {
    fn add(&self, scene: &Scene, out: &mut TileSamples) {
        let arriving = self.light.transmittance(scene, self.max_crossings);
        if arriving.is_black() {
            return;
        }
        for (layer, value) in self.terms {
            if !value.is_black() {
                out.add(self.index, layer, arriving * value);
            }
        }
    }
}

impl TracedPath<'_> {
    /// Adds the radiance emitted at the segment's end, connects to an emitter, and scatters. `false` at the path's end.
    fn scatter(
        &mut self,
        scene: &Scene,
        limits: PathLimits,
        (end, plan): (SegmentEnd, &EmitterPlan),
        connections: &mut Vec<EmitterConnection>,
        out: &mut TileSamples,
    ) -> bool {
        self.add(end.emitted(scene, &self.walk, None), out);
        let is_first = FirstEvent::is_ahead_of(&self.walk);
        let SegmentEnd::Surface(x, distance) = end else {
            if is_first {
                self.add_event(scene, FirstEvent::of_end(scene, &end), out);
            }
            return false;
        };
        let ends = !limits.allow(self.walk.segments() + 1);
        if ends && !is_first {
            return false;
        }
        let v = self.walk.vertex(x, distance);
        let sample = v
            .bsdf
            .sample_wi(v.w_prev, self.sampler.next_bsdf(), Lobes::ALL);
        if v.segments == 1 {
            add_sampled_first_surface(&v, 1.0, sample.as_ref(), self.index, out);
        }
        if ends {
            self.add_event(scene, FirstEvent::end(&v), out);
            return false;
        }
        if self.walk.pass_through(&v, self.sampler.next_1d()) {
            return true;
        }
        if is_first {
            self.add_event(scene, FirstEvent::scattering(&v), out);
        }
        connections.extend(self.next_event(scene, limits, &v, plan));
        if !self.walk.follow(&v, sample) {
            return false;
        }
        self.stage = self.stage.after(self.walk.previous().event);
        if v.segments < limits.rr_depth {
            return true;
        }
        let survival = roulette::camera_survival(self.walk.throughput(), self.walk.eta_squared());
        self.walk.survive(survival, self.sampler.next_1d())
    }

    /// Adds radiance emitted towards the path.
    #[inline]
    fn add(&self, emitted: Rgb, out: &mut TileSamples) {
        if !emitted.is_black() {
            let value = self.walk.throughput() * emitted;
            out.add(self.index, self.stage.layer(), value);
        }
    }

    /// Adds what the path has met first.
    fn add_event(&self, scene: &Scene, event: FirstEvent, out: &mut TileSamples) {
        let share = SampleShare {
            filter_weight: self.filter_weight,
            share: 1.0,
        };
        add_first_event(scene, event, share, self.index, out);
    }

    /// Next-event estimation at `v`.
    fn next_event(
        &self,
        scene: &Scene,
        limits: PathLimits,
        v: &Vertex,
        plan: &EmitterPlan,
    ) -> Option<EmitterConnection> {
        if !v.bsdf.lobes().has(Lobes::FINITE) {
            return None;
        }
        let n = v.bsdf.receiving_normal(v.w_prev);
        let light = EmitterSample::new(scene, &v.x, n, plan)?;
        let seen = v.bsdf.direct_response(light.wi, v.w_prev)?;
        let scale = self.walk.throughput() * light.weight * light.mis_weight(seen.pdf);
        let term = |event, value| (self.stage.after(event).layer(), scale * value);
        Some(EmitterConnection {
            index: self.index,
            light,
            max_crossings: limits.left_after(v.segments + 1),
            terms: [
                term(Lobes::DIFFUSE, seen.non_specular),
                term(Lobes::NEAR_DELTA, seen.near_delta),
            ],
        })
    }
}
