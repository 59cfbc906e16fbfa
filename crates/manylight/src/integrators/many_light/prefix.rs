//! Prefixes: camera paths through specular events up to their first gather points, with the
//! radiance emitted on the way.

use super::density_estimates::max_photon_radius;
use super::gather_point::{DIRECTIONS, GatherPath, GatherRole, TileGather};
use super::paths::ScaleRow;
use super::paths::{EMISSION_PATHS, PathNumber, PathPart, PathState, PixelNumbers, Prefix};
use crate::bsdf::Lobes;
use crate::film::{FilmSampler, Layer};
use crate::integrators::camera_round::Arrived;
use crate::integrators::camera_starts::{CameraView, StartNumbers};
use crate::integrators::connections::{EmitterQuery, EmitterReflection, ReflectingPath};
use crate::integrators::context::PassContext;
use crate::integrators::partition::PathStage;
use crate::lanes::{Color, Mask, Width};
use crate::sampling::Stream;
use crate::scene::LimitedScene;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::{Bits, Walks, lanes_where};

/// The camera paths of a tile, at the camera.
pub(super) fn start(
    run: &PassContext,
    positions: &FilmSampler,
    tile: &mut TileGather,
) -> Walks<PathState> {
    let prepared = tile.prepared;
    let camera_paths = prepared.camera_paths;
    let count = tile.out.tile().count() * (camera_paths * EMISSION_PATHS) as usize;
    let mut paths = Vec::with_capacity(count);
    for (index, pixel) in tile.out.tile().pixels().enumerate() {
        let number = positions.index(pixel);
        let mut sampler = run.pass.sampler(Stream::Pixel, number);
        tile.numbers.push(PixelNumbers::draw(&mut sampler));
        // A render has few passes. Positions in the pixel are stratified over them, so that edges
        // are smooth.
        let position = |number, k, parts| {
            (run.pass).low_discrepancy_2d_in_parts(Stream::Pixel, number, k, parts)
        };
        let mut add = |film, number| {
            let lens = sampler.next_2d();
            let numbers = StartNumbers { pixel, film, lens };
            paths.push((numbers, (index as u32, number, sampler.branch())));
        };
        for start in 0..camera_paths {
            let gathers = PathNumber {
                index: start,
                count: camera_paths,
            };
            add(position(number, start, camera_paths), Some(gathers));
            for k in 1..EMISSION_PATHS {
                let (k, parts) = (start * EMISSION_PATHS + k, camera_paths * EMISSION_PATHS);
                add(position(!number, k, parts), None);
            }
        }
    }
    let view = CameraView {
        scene: prepared.scene,
        limits: prepared.limits,
        camera: run.camera,
        positions,
    };
    let mut walks = Walks::with_capacity(count);
    let numbers = paths.iter().map(|(numbers, _)| *numbers);
    view.each_start(numbers, |i, start| {
        let &(_, (pixel, number, ref sampler)) = &paths[i];
        let path = PathState {
            pixel,
            stage: PathStage::BeforeX,
            part: PathPart::Prefix(Prefix {
                number,
                length: start.hidden,
                filter_weight: start.filter_weight,
            }),
        };
        walks.push(start.walk(camera_paths, sampler.clone(), path));
    });
    walks
}

/// Gathers at the vertices in `lanes` where prefixes arrive.
#[inline(always)]
pub(super) fn end<'s, S: Width>(
    s: S,
    tile: &mut TileGather<'s, '_, '_>,
    at: &mut Arrived<'_, 's, S, PathState>,
    lanes: Bits,
) {
    let lanes = lanes_where(lanes, |i| at.paths.as_ref()[i].number().is_some());
    if lanes == 0 {
        return;
    }
    connect_near_delta(s, tile, at, lanes);
    let gathers = lanes & at.v.bsdf.has(Lobes::NON_SPECULAR).bits();
    if gathers == 0 {
        return;
    }
    let (scene, values) = (tile.prepared.scene, at.values());
    for i in set_bits(gathers) {
        let path = at.paths.as_ref()[i];
        let (Some(prefix), Some(number)) = (path.prefix(), path.number()) else {
            continue;
        };
        let vertex = at.vertex(scene, &values, i);
        let path = GatherPath {
            pixel: path.pixel,
            throughput: values.throughput(i),
            eta_squared: values.eta_squared(i),
            segments: vertex.segments,
            stage: PathStage::BeforeX,
            max_photon_radius: max_photon_radius(tile.pixel, prefix.length),
            first_weight: 0.0,
            scales: ScaleRow::ONE,
        };
        let path = GatherPath {
            first_weight: path.roulette_weight() * number.count as f32 / DIRECTIONS as f32,
            ..path
        };
        let role = GatherRole::FirstVertex(number);
        at.generators
            .draw(i, |sampler| tile.gather(&vertex, path, role, None, sampler));
    }
}

/// Next-event estimation on near-delta lobes. The light belongs to the emission layer: the prefix
/// that follows these lobes is the other half of MIS.
#[inline(always)]
fn connect_near_delta<S: Width>(
    s: S,
    tile: &mut TileGather,
    at: &mut Arrived<S, PathState>,
    lanes: Bits,
) {
    let lanes = Mask::from_bits(s, lanes) & at.v.bsdf.has(Lobes::NEAR_DELTA);
    if lanes.none() {
        return;
    }
    let query = EmitterQuery {
        numbers: (at.generators.next(), at.generators.next_pair()),
        guides: None,
        lanes,
    };
    let scene = LimitedScene {
        scene: tile.prepared.scene,
        limits: tile.prepared.limits,
    };
    (tile.connections).connect_emitters(scene, at.v, query, &ByNearDelta { at });
}

/// Reflection by near-delta lobes; directions are sampled from all specular ones.
struct ByNearDelta<'k, 'v, 's, S: Width> {
    at: &'k Arrived<'v, 's, S, PathState>,
}

impl<S: Width> EmitterReflection<S> for ByNearDelta<'_, '_, '_, S> {
    #[inline(always)]
    fn reflect(&self, lights: &EmitterSamples<S>) -> [Color<S>; 2] {
        let v = self.at.v;
        let (f_cos, _) = v.bsdf.responses(lights.wi, v.w_prev, Lobes::NEAR_DELTA);
        let (_, pdf) = v.bsdf.responses(lights.wi, v.w_prev, Lobes::SPECULAR);
        let radiance = self.at.throughput * lights.weight * f_cos * lights.mis_weight(pdf);
        [radiance, Color::black(lights.pdf.width())]
    }

    #[inline(always)]
    fn path(&self, i: usize) -> ReflectingPath {
        ReflectingPath {
            pixel: self.at.paths.as_ref()[i].pixel,
            layers: [Layer::Emission; 2],
        }
    }
}
