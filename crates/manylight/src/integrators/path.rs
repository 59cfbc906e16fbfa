//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so each of their terms can be checked by itself.
//!
//! The paths of a tile advance in step: all choose emitters, all follow their rays, all find out where they are, all scatter, then
//! all connections to emitters are tested. Each stage finds its code in the cache, and asks for the memory that the next will read
//! while the other paths are at work.

use super::partition::Stage;
use super::{PassContext, first_surface_sampled};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, Layer, TileSamples};
use crate::geometry::SurfacePoint;
use crate::math::{UVec2, Vec3};
use crate::sampling::{Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::direct::{
    EmitterPlan, EmitterSample, emitted_with_mis, environment_with_mis,
};
use crate::transport::{Arrival, Vertex, Walk, roulette};

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
            Path {
                index,
                walk: Walk::from_sensor(scene, limits, camera.ray, throughput),
                stage: Stage::BeforeX,
                sampler,
            }
        };
        let paths: Vec<Path> = samples.tile().pixels().enumerate().map(start).collect();
        Stats::count(&run.stats.camera_paths, paths.len() as u64);
        let shadow_rays = trace(scene, limits, paths, samples);
        Stats::count(&run.stats.shadow_rays, shadow_rays);
    })
}

/// Follows all paths to their ends and returns the number of shadow rays.
fn trace(scene: &Scene, limits: PathLimits, mut paths: Vec<Path>, out: &mut TileSamples) -> u64 {
    let mut shadow_rays = 0;
    let mut lights = Vec::with_capacity(paths.len());
    let mut arrivals = Vec::with_capacity(paths.len());
    let mut places = Vec::with_capacity(paths.len());
    let mut connections = Vec::with_capacity(paths.len());
    while !paths.is_empty() {
        lights.extend(
            paths
                .iter_mut()
                .map(|path| EmitterPlan::draw(scene, &mut path.sampler)),
        );
        lights.iter_mut().for_each(|light| light.refine(scene));
        for path in &mut paths {
            let arrival = path.walk.arrive();
            if let Arrival::Hit(at, _) = arrival {
                scene.geometry.prefetch(at);
            }
            arrivals.push(arrival);
        }
        lights.iter_mut().for_each(|light| light.refine(scene));
        for (arrival, light) in arrivals.iter().zip(&mut lights) {
            if let Arrival::Hit(..) = arrival {
                light.refine(scene);
            }
        }
        for arrival in &arrivals {
            if let Arrival::Hit(at, _) = arrival {
                scene.geometry.prefetch_vertices(*at);
            }
        }
        places.extend(arrivals.drain(..).map(|arrival| Place::new(scene, arrival)));
        for place in &places {
            if let Place::Surface(x, _) = place {
                scene.prefetch_bsdf(x);
            }
        }
        let mut here = places.drain(..).zip(lights.drain(..));
        paths.retain_mut(|path| {
            here.next().is_some_and(|(place, light)| {
                path.continues(scene, limits, (place, &light), &mut connections, out)
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

/// Where a path arrived.
enum Place {
    /// A point of a surface, and the length of the last segment.
    Surface(SurfacePoint, f32),
    /// The surroundings, along this unit direction.
    Surroundings(Vec3),
    /// Nothing that the path may see.
    Nowhere,
}

impl Place {
    #[inline]
    fn new(scene: &Scene, arrival: Arrival) -> Self {
        match arrival {
            Arrival::Hit(at, distance) => Place::Surface(scene.surface_point(at), distance),
            Arrival::Escaped(wi) => Place::Surroundings(wi),
            Arrival::Hidden => Place::Nowhere,
        }
    }
}

/// A camera path under way.
struct Path<'s> {
    /// Of its pixel in the tile.
    index: usize,
    walk: Walk<'s>,
    stage: Stage,
    sampler: Sampler,
}

/// Light from an emitter that a path reflects if nothing lies between, by the lobe that reflects it: the classes belong to
/// different layers.
struct Connection {
    index: usize,
    light: EmitterSample,
    /// Transparent surfaces that may lie between.
    max_crossings: u32,
    terms: [(Layer, Rgb); 2],
}

impl Connection {
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

impl Path<'_> {
    /// Takes what is found where the path arrived, asks for light from emitters, and scatters. `false` at the path's end.
    fn continues(
        &mut self,
        scene: &Scene,
        limits: PathLimits,
        (place, light): (Place, &EmitterPlan),
        connections: &mut Vec<Connection>,
        out: &mut TileSamples,
    ) -> bool {
        let (x, distance) = match place {
            Place::Nowhere => return false,
            Place::Surroundings(wi) => {
                self.add(environment_with_mis(scene, self.walk.previous(), wi), out);
                return false;
            }
            Place::Surface(x, distance) => (x, distance),
        };
        let found = emitted_with_mis(scene, self.walk.previous(), &x, self.walk.w_prev());
        self.add(found, out);
        let ends = !limits.allow(self.walk.segments() + 1);
        if ends && self.walk.segments() > 1 {
            return false;
        }
        let v = self.walk.vertex(x, distance);
        let sample = v
            .bsdf
            .sample_wi(v.w_prev, self.sampler.next_bsdf(), Lobes::ALL);
        if v.segments == 1 {
            first_surface_sampled(&v, 1.0, sample.as_ref(), self.index, out);
        }
        if ends {
            return false;
        }
        if self.walk.pass_through(&v, self.sampler.next_1d()) {
            return true;
        }
        connections.extend(self.next_event(scene, limits, &v, light));
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

    /// Light that the path ran into.
    #[inline]
    fn add(&self, found: Rgb, out: &mut TileSamples) {
        if !found.is_black() {
            let value = self.walk.throughput() * found;
            out.add(self.index, self.stage.layer(), value);
        }
    }

    fn next_event(
        &self,
        scene: &Scene,
        limits: PathLimits,
        v: &Vertex,
        light: &EmitterPlan,
    ) -> Option<Connection> {
        if !v.bsdf.lobes().has(Lobes::FINITE) {
            return None;
        }
        let n = v.bsdf.receiving_normal(v.w_prev);
        let light = EmitterSample::planned(scene, &v.x, n, light)?;
        let seen = v.bsdf.direct_response(light.wi, v.w_prev)?;
        let scale = self.walk.throughput() * light.weight * light.mis_weight(seen.pdf);
        let term = |event, value| (self.stage.after(event).layer(), scale * value);
        Some(Connection {
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
