//! Inputs of a gather: virtual lights of a scene, and the surface points of random image tiles.

use manylight::gather::ShadingPoint;
use manylight::integrators::many_light::{Compensation, ManyLight};
use manylight::integrators::{PassContext, PreparedPasses};
use manylight::math::{UVec2, Vec2};
use manylight::sampling::{Pass, rng::Pcg};
use manylight::scene::Scene;
use manylight::stats::Stats;
use manylight_io::{LoadOptions, load_scene};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Width and height of the image in pixels.
const SIDE: usize = 512;
/// Width and height of a tile in pixels.
pub(crate) const TILE: usize = 8;

/// `counts` of virtual lights, or 4096, 32768 and 262144 if it is empty.
pub(crate) fn counts_or_default(counts: Vec<u32>) -> Vec<u32> {
    if counts.is_empty() {
        return vec![1 << 12, 1 << 15, 1 << 18];
    }
    counts
}

/// The scene of a file with a [`SIDE`] x [`SIDE`] image of its first sensor.
pub(crate) fn load(path: &Path) -> Scene {
    let mut desc = load_scene(path, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .desc;
    let film = &mut desc.sensors[0].film;
    *film = film.with_size(UVec2::splat(SIDE as u32));
    Scene::build(desc, 0).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// About `count` virtual lights made by `method` without compensation, and the times of the stages.
pub(crate) fn prepare(scene: &Scene, count: u32, method: ManyLight) -> (PreparedPasses<'_>, Stats) {
    let (stats, cancel) = (Stats::default(), AtomicBool::new(false));
    let guide = scene.infinite_light_guide();
    let run = PassContext::of_picture(scene, Pass { seed: 1, index: 0 }, &guide, &stats, &cancel);
    let method = ManyLight {
        light_count: count,
        photon_paths: (4 * count).max(1 << 18),
        compensation: Compensation::None,
        interleaving: 1,
        ..method
    };
    let set = method.prepare(scene, scene.limits, &method.pass_group(0), &run);
    (set, stats)
}

/// The surface points seen through the pixel centers of `count` random tiles that see at least one
/// surface.
pub(crate) fn tiles(scene: &Scene, count: usize) -> Vec<Vec<ShadingPoint<'_>>> {
    let mut random = Pcg::new(4);
    let mut below = |n: usize| random.next_u32() as usize % n * TILE;
    let mut tiles = Vec::new();
    while tiles.len() < count {
        let corner = (below(SIDE / TILE), below(SIDE / TILE));
        let pixels = (0..TILE * TILE).map(|i| (corner.0 + i % TILE, corner.1 + i / TILE));
        let points: Vec<_> = pixels
            .filter_map(|(x, y)| visible_point(scene, x, y))
            .collect();
        if !points.is_empty() {
            tiles.push(points);
        }
    }
    tiles
}

fn visible_point(scene: &Scene, x: usize, y: usize) -> Option<ShadingPoint<'_>> {
    let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let ray = scene.sensor.ray(center, Vec2::splat(0.5));
    let (_, x) = scene.intersect(&ray)?;
    Some(ShadingPoint::unlimited(x, -ray.d, scene.bsdf(&x)))
}
