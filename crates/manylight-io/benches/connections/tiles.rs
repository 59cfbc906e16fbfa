//! What is summed, and where: lights, and tiles of a picture, drawn at random.

use manylight::gather::{ShadingPoint, Subset};
use manylight::integrators::many_light::{Compensation, ManyLight};
use manylight::integrators::{PassContext, PreparedPasses};
use manylight::math::{UVec2, Vec2};
use manylight::sampling::{Pass, rng::Pcg};
use manylight::scene::Scene;
use manylight::stats::Stats;
use manylight_io::{LoadOptions, load_scene};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Width and height of the picture, and of a tile.
const SIDE: usize = 512;
pub(crate) const TILE: usize = 8;

/// The numbers of lights that are asked for; without any 4096, 32768 and 262144.
pub(crate) fn counts_or_default(counts: Vec<u32>) -> Vec<u32> {
    if counts.is_empty() {
        return vec![1 << 12, 1 << 15, 1 << 18];
    }
    counts
}

/// Calls `bench` for every scene that `MANYLIGHT_BENCH_SCENES` names.
pub(crate) fn for_all(mut bench: impl FnMut(&Path, &Scene)) {
    let Some(scenes) = std::env::var_os("MANYLIGHT_BENCH_SCENES") else {
        println!("MANYLIGHT_BENCH_SCENES names no scene files (separated by colons)");
        return;
    };
    for path in std::env::split_paths(&scenes) {
        println!("\n# {}", path.display());
        bench(&path, &load(&path));
    }
}

/// The scene of a file, seen by its first camera.
fn load(path: &Path) -> Scene {
    let mut desc = load_scene(path, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .desc;
    let film = &mut desc.sensors[0].film;
    *film = film.with_size(UVec2::splat(SIDE as u32));
    Scene::build(desc, 0).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// About `count` lights as `method` makes them, and how long that took.
pub(crate) fn prepare(scene: &Scene, count: u32, method: ManyLight) -> (PreparedPasses<'_>, Stats) {
    let (stats, cancel) = (Stats::default(), AtomicBool::new(false));
    let run = PassContext {
        pass: Pass { seed: 1, index: 0 },
        stats: &stats,
        cancel: &cancel,
    };
    let method = ManyLight {
        light_count: count,
        photon_paths: (4 * count).max(1 << 18),
        compensation: Compensation::None,
        ..method
    };
    let set = method.prepare(scene, scene.limits, 0..1, &run);
    (set, stats)
}

/// What the camera sees in random tiles, as far as it sees anything.
pub(crate) fn tiles(scene: &Scene, count: usize) -> Vec<Vec<ShadingPoint<'_>>> {
    let mut random = Pcg::new(4);
    let mut below = |n: usize| random.next_u32() as usize % n * TILE;
    let mut tiles = Vec::new();
    while tiles.len() < count {
        let corner = (below(SIDE / TILE), below(SIDE / TILE));
        let pixels = (0..TILE * TILE).map(|i| (corner.0 + i % TILE, corner.1 + i / TILE));
        let points: Vec<_> = pixels.filter_map(|(x, y)| seen(scene, x, y)).collect();
        if !points.is_empty() {
            tiles.push(points);
        }
    }
    tiles
}

fn seen(scene: &Scene, x: usize, y: usize) -> Option<ShadingPoint<'_>> {
    let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let ray = scene.sensor.ray(center, Vec2::splat(0.5)).ray;
    let (_, x) = scene.intersect(&ray)?;
    Some(ShadingPoint {
        x,
        wo: -ray.d,
        bsdf: scene.bsdf(&x),
        max_photon_depth: None,
        u: 0.5,
        lights: Subset::ALL,
        tolerance: 0.0,
        lit_from: None,
    })
}
