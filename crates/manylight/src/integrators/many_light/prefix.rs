//! Prefixes: camera paths through specular events up to their first gather points, with the
//! radiance emitted on the way.

use super::PreparedPasses;
use super::density_estimates::max_photon_radius;
use super::gather_point::{DIRECTIONS, GatherPath, GatherRole, TileGather};
use super::paths::ScaleRow;
use super::paths::{EMISSION_PATHS, PathNumber, PathPart, PathState, PixelNumbers, Prefix};
use crate::bsdf::Lobes;
use crate::film::{FilmSampler, Layer};
use crate::integrators::camera_round::{Arrived, CameraStart};
use crate::integrators::connections::{EmitterQuery, EmitterReflection, ReflectingPath};
use crate::integrators::context::PassContext;
use crate::integrators::partition::PathStage;
use crate::lanes::{Color, Mask, Width};
use crate::math::{UVec2, Vec2};
use crate::sampling::{Sampler, Stream};
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::{Bits, WalkRow, Walks, lanes_where};

/// The camera paths of a tile, at the camera.
pub(super) fn start(
    run: &PassContext,
    positions: &FilmSampler,
    tile: &mut TileGather,
) -> Walks<PathState> {
    let (pass, prepared) = (run.pass, tile.prepared);
    let starts = prepared.camera_paths;
    let window = tile.out.tile();
    let mut walks = Walks::with_capacity(window.count() * (starts * EMISSION_PATHS) as usize);
    for (index, pixel) in window.pixels().enumerate() {
        let number = positions.index(pixel);
        let mut sampler = pass.sampler(Stream::Pixel, number);
        tile.numbers.push(PixelNumbers::draw(&mut sampler));
        // A render has few passes. Positions in the pixel are stratified over them, so that edges
        // are smooth.
        let position =
            |number, k, parts| pass.low_discrepancy_2d_in_parts(Stream::Pixel, number, k, parts);
        for start in 0..starts {
            let gathers = Some(PathNumber {
                index: start,
                count: starts,
            });
            let at = (index, pixel, position(number, start, starts));
            walks.push(camera_walk(
                run,
                prepared,
                positions,
                at,
                gathers,
                &mut sampler,
            ));
            for k in 1..EMISSION_PATHS {
                let u = position(!number, start * EMISSION_PATHS + k, starts * EMISSION_PATHS);
                let at = (index, pixel, u);
                walks.push(camera_walk(
                    run,
                    prepared,
                    positions,
                    at,
                    None,
                    &mut sampler,
                ));
            }
        }
    }
    walks
}

/// A camera path through the point `u` of a pixel, with the index of the pixel in the tile;
/// `number` as in [`Prefix`].
fn camera_walk(
    run: &PassContext,
    prepared: &PreparedPasses,
    positions: &FilmSampler,
    (index, pixel, u): (usize, UVec2, Vec2),
    number: Option<PathNumber>,
    sampler: &mut Sampler,
) -> WalkRow<PathState> {
    let scene = (prepared.scene, prepared.limits);
    let start = CameraStart::new(scene, run.camera, positions, (pixel, u), sampler.next_2d());
    let path = PathState {
        pixel: index as u32,
        stage: PathStage::BeforeX,
        part: PathPart::Prefix(Prefix {
            number,
            length: start.hidden,
            filter_weight: start.filter_weight,
        }),
    };
    start.walk(prepared.camera_paths, sampler.branch(), path)
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
    let scene = (tile.prepared.scene, tile.prepared.limits);
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
