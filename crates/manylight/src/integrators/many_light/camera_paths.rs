//! The camera paths of the many-light methods up to their first gather points: through specular events, with the radiance
//! emitted on the way.

use super::arriving::Arriving;
use super::gather_points::TileGather;
use super::gather_vertices::{DirectionNumbers, GatherPath, GatherRole};
use super::gathering::{DIRECTIONS, GatherTask};
use super::paths::{EMISSION_PATHS, PathNumber, PathPart, PathState, PixelNumbers, Prefix, SPLIT};
use super::prepared::PreparedPasses;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer};
use crate::integrators::camera_round::{Arrived, CameraStart};
use crate::integrators::connections::Connection;
use crate::integrators::context::PassContext;
use crate::integrators::partition::PathStage;
use crate::lanes::{Mask, Width, lane};
use crate::math::{UVec2, Vec2};
use crate::sampling::{Sampler, Stream};
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::{Bits, WalkRow, Walks, lanes_where};

impl PreparedPasses<'_> {
    /// The camera paths of a tile, at the camera.
    pub(super) fn start_paths(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        tile: &mut TileGather,
    ) -> Walks<PathState> {
        let (pass, starts) = (run.pass, self.camera_paths);
        let window = tile.out.tile();
        let mut walks = Walks::with_capacity(window.count() * (starts * EMISSION_PATHS) as usize);
        for (index, pixel) in window.pixels().enumerate() {
            let number = positions.index(pixel);
            let mut sampler = pass.sampler(Stream::Pixel, number);
            tile.numbers.push(PixelNumbers::draw(&mut sampler));
            // A render has few passes. Positions in the pixel are stratified over them, so that edges are smooth.
            let position = |number, k, parts| {
                pass.low_discrepancy_2d_in_parts(Stream::Pixel, number, k, parts)
            };
            for start in 0..starts {
                let gathers = Some(PathNumber {
                    index: start,
                    count: starts,
                });
                let u = position(number, start, starts);
                let at = (index, pixel, u);
                walks.push(self.camera_walk(positions, at, gathers, &mut sampler));
                for k in 1..EMISSION_PATHS {
                    let u = position(!number, start * EMISSION_PATHS + k, starts * EMISSION_PATHS);
                    let at = (index, pixel, u);
                    walks.push(self.camera_walk(positions, at, None, &mut sampler));
                }
            }
        }
        walks
    }

    /// A camera path through the point `u` of a pixel, with the index of the pixel in the tile; `number` as in [`Prefix`].
    fn camera_walk(
        &self,
        positions: &FilmSampler,
        (index, pixel, u): (usize, UVec2, Vec2),
        number: Option<PathNumber>,
        sampler: &mut Sampler,
    ) -> WalkRow<PathState> {
        let scene = (self.scene, self.limits);
        let start = CameraStart::new(scene, positions, (pixel, u), sampler.next_2d());
        let path = PathState {
            pixel: index as u32,
            stage: PathStage::BeforeX,
            part: PathPart::Prefix(Prefix {
                number,
                length: start.hidden,
                filter_weight: start.filter_weight,
            }),
        };
        start.walk(self.camera_paths, sampler.branch(), path)
    }
}

impl<'s> Arriving<'_, 's, '_, '_> {
    /// Gathers at the vertices in `lanes` where specular prefixes arrive.
    #[inline(always)]
    pub(super) fn end_prefixes<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<'_, 's, S, PathState>,
        lanes: Bits,
    ) {
        let lanes = lanes_where(lanes, |i| at.paths.as_ref()[i].number().is_some());
        if lanes == 0 {
            return;
        }
        self.add_near_delta_direct(s, at, lanes);
        let gathers = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
        if gathers == 0 {
            return;
        }
        let values = at.values();
        for i in set_bits(gathers) {
            let path = at.paths.as_ref()[i];
            let Some(prefix) = path.prefix() else {
                continue;
            };
            let vertex = at.vertex(self.round.scene, &values, i);
            let path = GatherPath {
                pixel: path.pixel,
                throughput: values.throughput(i),
                eta_squared: values.eta_squared(i),
                stage: PathStage::BeforeX,
                max_photon_radius: self.tile.prepared.max_photon_radius(prefix.length),
                first_weight: 0.0,
            };
            let task = self.tile.first_task(path, prefix);
            at.generators
                .draw(i, |sampler| self.tile.gather(&vertex, task, sampler));
        }
    }

    /// Adds direct light on near-delta lobes. It belongs to the emission layer: the walk that follows these lobes is the other
    /// half of MIS.
    #[inline(always)]
    fn add_near_delta_direct<S: Width>(
        &mut self,
        s: S,
        at: &mut Arrived<'_, 's, S, PathState>,
        lanes: Bits,
    ) {
        let v = at.v;
        let lanes = Mask::from_bits(s, lanes) & v.bsdf.has(Lobes::NEAR_DELTA);
        if lanes.none() {
            return;
        }
        let prepared = self.tile.prepared;
        let numbers = (at.generators.next(), at.generators.next_pair());
        let normals = v.bsdf.receiving_normals(v.w_prev);
        let lights = EmitterSamples::new(prepared.scene, &v.x, normals, numbers, None, lanes);
        if lights.valid.none() {
            return;
        }
        let (f_cos, _) = v.bsdf.responses(lights.wi, v.w_prev, Lobes::NEAR_DELTA);
        let (_, pdf) = v.bsdf.responses(lights.wi, v.w_prev, Lobes::SPECULAR);
        let radiance = at.throughput * lights.weight * f_cos * lights.mis_weight(pdf);
        let is_lit = lights.valid & !radiance.is_black();
        let radiance = radiance.store();
        let connection = |i: usize| Connection {
            pixel: at.paths.as_ref()[i].pixel,
            max_crossings: prepared.limits.left_after(v.segments.as_ref()[i] + 1),
            terms: [
                (Layer::Emission, Rgb::from(lane(&radiance, i))),
                (Layer::Emission, Rgb::BLACK),
            ],
        };
        let connections = &mut self.tile.connections;
        connections.push_lanes(&lights, is_lit.bits(), connection);
    }
}

impl TileGather<'_, '_, '_> {
    /// What is gathered at the end of a specular prefix.
    fn first_task(&self, path: GatherPath, prefix: &Prefix) -> GatherTask {
        let PathNumber { index, count } = (prefix.number).expect("invariant: the prefix gathers");
        // Before the first specular event, one of the paths of the pixel looks photons up, for all of them.
        let photon_weight = match (count, index) {
            (SPLIT, _) => 1.0,
            (_, 0) => count as f32,
            _ => 0.0,
        };
        let numbers = self.numbers[path.pixel as usize];
        GatherTask {
            path: GatherPath {
                first_weight: path.roulette_weight() * count as f32 / DIRECTIONS as f32,
                ..path
            },
            role: GatherRole::FirstVertex { photon_weight },
            lights: self.lights.divided(index, count),
            numbers: DirectionNumbers {
                count: DIRECTIONS / count,
                first: index * (DIRECTIONS / count),
                emitters: numbers.emitters,
                directions: numbers.directions,
            },
        }
    }
}
