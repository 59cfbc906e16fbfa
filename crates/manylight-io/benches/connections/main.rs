//! Whole connections per second and thread: visibility, scattering function and table look-up.
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight-io --bench connections [-- LIGHTS...]`, by default 4096, 32768
//! and 262144 lights.
//!
//! Tiles of 8 x 8 pixels of a picture of 512 x 512, drawn at random, are shaded by all Rich-VPLs of the scene. A connection is a pair of a
//! pixel and a piece of a light whose visibility must be tested, because both sides face each other; pairs are all pixels
//! times all lights.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

#[path = "../visibility/clock.rs"]
mod clock;

use manylight::gather::{
    Clamp, Gather, Gathered, Kernel, Lights, Selection, ShadingPoint, Strategy,
};
use manylight::integrators::PassContext;
use manylight::integrators::many_light::{Complement, ManyLight};
use manylight::math::{UVec2, Vec2};
use manylight::sampling::{Pass, rng::Pcg};
use manylight::scene::Scene;
use manylight::stats::Stats;
use manylight_io::{LoadOptions, load_scene};
use std::path::Path;
use std::sync::atomic::AtomicBool;

const REPEATS: usize = 5;
/// Width and height of the picture, and of a tile.
const SIDE: usize = 512;
const TILE: usize = 8;
/// Pairs of pixels and lights in a measurement, about.
const PAIRS: usize = 1 << 26;

fn main() {
    let counts: Vec<u32> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if counts.is_empty() {
        vec![1 << 12, 1 << 15, 1 << 18]
    } else {
        counts
    };
    let Some(scenes) = std::env::var_os("MANYLIGHT_BENCH_SCENES") else {
        println!("MANYLIGHT_BENCH_SCENES names no scene files (separated by colons)");
        return;
    };
    for path in std::env::split_paths(&scenes) {
        println!("\n# {}", path.display());
        let scene = load(&path);
        for &count in &counts {
            bench(&scene, count);
        }
    }
}

fn load(path: &Path) -> Scene {
    let mut desc = load_scene(path, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .desc;
    let film = &mut desc.sensors[0].film;
    *film = film.with_size(UVec2::splat(SIDE as u32));
    Scene::build(desc, 0).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn bench(scene: &Scene, count: u32) {
    let (stats, cancel) = (Stats::default(), AtomicBool::new(false));
    let run = PassContext {
        pass: Pass { seed: 1, index: 0 },
        stats: &stats,
        cancel: &cancel,
    };
    let method = ManyLight {
        light_count: count,
        photon_paths: (4 * count).max(1 << 18),
        complement: Complement::None,
        ..ManyLight::rich_vpl()
    };
    let set = method.prepare(scene, scene.limits, 0..1, &run);
    let stages: Vec<String> = (stats.stages().iter())
        .map(|(name, time)| format!("{name} {:.2} s", time.as_secs_f64()))
        .collect();
    let lights = set.lights.field.lights().len();
    let bytes = set.lights.field.bytes() as f64 / lights as f64;
    println!(
        "{lights} lights of {bytes:.0} B; {} (all threads)",
        stages.join(", ")
    );
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy: Strategy::All,
        clamp: Clamp::Auto(1.0),
        finer: 1.0,
    };
    let tiles = tiles(scene, (PAIRS / (lights * TILE * TILE)).max(8));
    measure(scene, &gather, &set.lights, &tiles);
}

fn measure(scene: &Scene, gather: &Gather, lights: &Lights, tiles: &[Vec<ShadingPoint>]) {
    let mut seconds = Vec::new();
    let mut total = Gathered::default();
    for _ in 0..REPEATS {
        total = Gathered::default();
        let start = clock::thread_seconds();
        for sum in tiles.iter().flat_map(|t| gather.sum(scene, lights, t)) {
            total.radiance += sum.radiance;
            total.connections += sum.connections;
            total.shadow_rays += sum.shadow_rays;
        }
        seconds.push(clock::thread_seconds() - start);
    }
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let rate = |count: u64| count as f64 / median * 1e-6;
    println!(
        "  {} tiles: {:.1} M connections/s, {:.1} M pairs/s; mean radiance {:.6}",
        tiles.len(),
        rate(total.shadow_rays),
        rate(total.connections),
        total.radiance.luminance() / (tiles.len() * TILE * TILE) as f32,
    );
}

/// What the camera sees in random tiles, as far as it sees anything.
fn tiles(scene: &Scene, count: usize) -> Vec<Vec<ShadingPoint<'_>>> {
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
        lights: Selection::ALL,
        lit_from: None,
    })
}
