//! The camera paths of the many-light methods up to their first gather points: through specular events, with the radiance
//! emitted on the way.

use super::gather_points::{PixelGather, TileGather, roulette_weight};
use super::gather_vertices::{DirectionNumbers, GatherPath, GatherRole, PixelNumbers};
use super::gathering::DIRECTIONS;
use super::next_event::EmitterLight;
use super::prepared::PreparedPasses;
use super::specular_chains::MAX_CHAIN;
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer};
use crate::gather::Subset;
use crate::integrators::context::PassContext;
use crate::integrators::first_event::{FirstEvent, SampleShare, add_first_event};
use crate::integrators::first_surface::add_first_surface;
use crate::integrators::partition::PathStage;
use crate::math::{UVec2, Vec2};
use crate::sampling::{Sampler, Stream};
use crate::transport::direct::EmitterSample;
use crate::transport::{CameraStep, Vertex, Walk, next_scattering_vertex};

/// Camera paths of a pixel after the first specular event. With fewer of them, low-roughness lobes and the choice between
/// reflection and refraction are noisy.
const SPLIT: u32 = 8;
/// Camera paths that look for emitters, per path that gathers. Lamps that are smaller than a pixel, and their edges and
/// reflections, have much noise, and these paths cost little. Measured at 1, 4 and 8, over 4 passes at 160x90: relMSE times time is
/// 1, 0.74 and 0.88 in the Kitchen, 1, 0.67 and 0.85 in the Disco, 1, 0.94 and 0.93 in the Garage.
const EMISSION_PATHS: u32 = 4;
/// Factor from the weight of a specular path to its probability of survival. Unmeasured: only the weakest paths are terminated.
const SURVIVAL_FACTOR: f32 = 64.0;

/// One of the camera paths of a pixel, on its specular prefix.
#[derive(Clone)]
struct SpecularPrefix<'s> {
    walk: Walk<'s>,
    /// Distance from the camera along the path, in m.
    length: f32,
    role: PathRole,
    numbers: PixelNumbers,
    /// Weight by the reconstruction filter.
    filter_weight: f32,
}

/// What a camera path is traced for, besides the radiance emitted on the way.
#[derive(Clone, Copy)]
enum PathRole {
    /// Its gather points.
    Gathers(PathNumber),
    /// Nothing else.
    LooksForEmitters,
}

/// The number of a camera path among those of its pixel.
#[derive(Clone, Copy)]
struct PathNumber {
    index: u32,
    count: u32,
}

impl<'s> SpecularPrefix<'s> {
    /// A path at the camera.
    fn new((walk, filter_weight): (Walk<'s>, f32), role: PathRole, numbers: PixelNumbers) -> Self {
        SpecularPrefix {
            walk,
            length: 0.0,
            role,
            numbers,
            filter_weight,
        }
    }
}

impl<'s> PreparedPasses<'s> {
    /// Traces the camera paths of one pixel, the one with `index` in the tile.
    pub(super) fn trace_pixel(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        (index, pixel): (usize, UVec2),
        lights: Subset,
        tile: &mut TileGather<'s, '_, '_>,
    ) {
        let number = positions.index(pixel);
        let mut sampler = run.pass.sampler(Stream::Pixel, number);
        let numbers = PixelNumbers::draw(&mut sampler);
        let starts = self.camera_paths;
        for start in 0..starts {
            // A render has few passes. Positions in the pixel are stratified over them, so that edges are smooth.
            let u = (run.pass).low_discrepancy_2d_in_parts(Stream::Pixel, number, start, starts);
            let path_number = PathNumber {
                index: start,
                count: starts,
            };
            let walk = self.camera_walk(positions, (pixel, u), starts, &mut sampler);
            let mut gather = PixelGather {
                prepared: self,
                lights,
                sampler: &mut sampler,
                pixel: index,
                tile,
                first_weight: 0.0,
            };
            gather.trace(SpecularPrefix::new(
                walk,
                PathRole::Gathers(path_number),
                numbers,
            ));
            for k in 1..EMISSION_PATHS {
                let (part, parts) = (start * EMISSION_PATHS + k, starts * EMISSION_PATHS);
                let u = (run.pass).low_discrepancy_2d_in_parts(Stream::Pixel, !number, part, parts);
                let walk = self.camera_walk(positions, (pixel, u), starts, gather.sampler);
                gather.trace(SpecularPrefix::new(
                    walk,
                    PathRole::LooksForEmitters,
                    numbers,
                ));
            }
        }
    }

    /// A camera path through the point `u` of a pixel, one of `count`, and its weight by the reconstruction filter.
    fn camera_walk(
        &self,
        positions: &FilmSampler,
        (pixel, u): (UVec2, Vec2),
        count: u32,
        sampler: &mut Sampler,
    ) -> (Walk<'s>, f32) {
        let film = positions.sample(pixel, u);
        let camera = self.scene.sensor.ray(film.position, sampler.next_2d());
        let weight = Rgb::splat(camera.weight * film.weight / count as f32);
        let walk = Walk::from_sensor(self.scene, self.limits, camera.ray, weight);
        (walk, film.weight)
    }
}

impl<'s> PixelGather<'_, 's, '_, '_> {
    /// Follows specular events; every vertex with non-specular lobes becomes a gather point with those lobes alone, if the path
    /// gathers.
    fn trace(&mut self, mut path: SpecularPrefix<'s>) {
        while let Some(v) = self.next_prefix_vertex(&mut path) {
            if let PathRole::Gathers(number) = path.role {
                self.add_near_delta_direct(&path, &v);
                if v.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                    self.gather_first(&path, number, &v);
                }
                if number.count < SPLIT {
                    return self.split(path, number, &v);
                }
            }
            let numbers = self.sampler.next_bsdf();
            if !self.follow_specular(&mut path.walk, &v, numbers) {
                return;
            }
        }
    }

    /// Follows a path to the next vertex that scatters; adds the radiance emitted on the way, and what the path meets first if it
    /// gathers.
    fn next_prefix_vertex(&mut self, path: &mut SpecularPrefix<'s>) -> Option<Vertex<'s>> {
        let (scene, limits) = (self.prepared.scene, self.prepared.limits);
        let (out, pixel) = (&mut *self.tile.out, self.pixel);
        let (length, role) = (&mut path.length, path.role);
        let is_first = FirstEvent::is_ahead_of(&path.walk);
        let mut ends_by = FirstEvent::Nothing;
        let (walk, sampler) = (&mut path.walk, &mut *self.sampler);
        let visit = |step: &CameraStep, throughput, sampler: &mut Sampler| {
            if is_first {
                ends_by = FirstEvent::of_last_step(scene, limits, step);
            }
            if let Some(v) = &step.vertex {
                *length += v.distance;
                if let (1, PathRole::Gathers(number)) = (v.segments, role) {
                    add_first_surface(v, 1.0 / number.count as f32, sampler, pixel, out);
                }
            }
            let emitted = step.emitted / EMISSION_PATHS as f32;
            out.add(pixel, Layer::Emission, throughput * emitted);
            true
        };
        let found = next_scattering_vertex(limits, walk, None, sampler, visit);
        if let (true, PathRole::Gathers(number)) = (is_first, role) {
            let event = found.as_ref().map_or(ends_by, FirstEvent::scattering);
            let share = SampleShare {
                filter_weight: path.filter_weight,
                share: 1.0 / number.count as f32,
            };
            add_first_event(scene, event, share, pixel, self.tile.out);
        }
        found
    }

    /// Gathers at the vertex `v`, the end of the specular prefix `path` for its non-specular lobes.
    fn gather_first(&mut self, path: &SpecularPrefix<'s>, number: PathNumber, v: &Vertex<'s>) {
        let PathNumber { index, count } = number;
        // Before the first specular event, one of the paths of the pixel looks photons up, for all of them.
        let photon_weight = match number {
            PathNumber { count: SPLIT, .. } => 1.0,
            PathNumber { index: 0, count } => count as f32,
            PathNumber { .. } => 0.0,
        };
        self.first_weight = roulette_weight(&path.walk) * count as f32 / DIRECTIONS as f32;
        let numbers = DirectionNumbers::of_path(index, DIRECTIONS / count, path.numbers);
        let lights = self.lights.divided(index, count);
        let path = GatherPath {
            walk: path.walk.clone(),
            stage: PathStage::BeforeX,
            max_photon_radius: self.prepared.max_photon_radius(path.length),
        };
        let role = GatherRole::FirstVertex { photon_weight };
        self.gather(v, path, role, lights, numbers);
    }

    /// Continues from `v` by several specular events, so that the pixel has [`SPLIT`] paths.
    fn split(&mut self, mut path: SpecularPrefix<'s>, number: PathNumber, v: &Vertex<'s>) {
        if !v.bsdf.lobes().has(Lobes::SPECULAR) {
            return;
        }
        let branches = SPLIT / number.count;
        path.walk.scale(1.0 / branches as f32);
        let first = number.index * branches;
        for index in first..first + branches {
            let mut branch = path.clone();
            branch.role = PathRole::Gathers(PathNumber {
                index,
                count: SPLIT,
            });
            let (lobe, direction) = path.numbers.events.triple(index);
            let numbers = BsdfNumbers { lobe, direction };
            if self.follow_specular(&mut branch.walk, v, numbers) {
                self.trace(branch);
            }
        }
    }

    /// Adds direct light on near-delta lobes. It belongs to the emission layer: the walk that follows these lobes is the other
    /// half of MIS.
    fn add_near_delta_direct(&mut self, path: &SpecularPrefix, v: &Vertex) {
        if v.bsdf.lobes().has(Lobes::NEAR_DELTA) {
            let scene = self.prepared.scene;
            let numbers = self.sampler.next_emitter();
            let n = v.bsdf.receiving_normal(v.w_prev);
            let Some(sample) = EmitterSample::new(scene, &v.x, n, numbers) else {
                return;
            };
            let pdf_walk = |wi| v.bsdf.pdf_wi(wi, v.w_prev, Lobes::SPECULAR);
            let light = EmitterLight {
                lobes: Lobes::NEAR_DELTA,
                lit_from: None,
                direction_limit: f32::INFINITY,
            };
            if let Some(radiance) = self.next_event(v, light, sample, pdf_walk) {
                self.add(Layer::Emission, path.walk.throughput() * radiance);
            }
        }
    }

    /// Continues by a specular event; weak paths survive by roulette.
    fn follow_specular(&mut self, walk: &mut Walk<'s>, v: &Vertex<'s>, u: BsdfNumbers) -> bool {
        if v.segments >= MAX_CHAIN
            || !v.bsdf.lobes().has(Lobes::SPECULAR)
            || !walk.scatter(v, u, Lobes::SPECULAR)
        {
            return false;
        }
        let survival = (SURVIVAL_FACTOR * roulette_weight(walk)).min(1.0);
        survival > 0.0 && walk.survive(survival, self.sampler.next_1d())
    }
}
