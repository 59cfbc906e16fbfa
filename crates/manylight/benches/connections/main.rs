//! Rate of whole connections between surface points and Rich-VPLs (visibility, BSDF and table
//! look-up), per second and thread.
//!
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight --bench connections [-- LIGHTS...]`;
//! by default 4096, 32768 and 262144 virtual lights.
//!
//! Random tiles of 8 x 8 pixels of a 512 x 512 image gather all lights. "Pairs" counts pixels times
//! lights; "connections" counts pairs of a pixel and a light that face each other, which need a
//! shadow ray.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "../shared/clock.rs"]
mod clock;
#[path = "../shared/scene_list.rs"]
mod scene_list;
#[path = "../shared/tiles.rs"]
mod tiles;

use manylight::gather::{Clamp, Gather, Gathered, Kernel, LightIndex, ShadingPoint, Strategy};
use manylight::integrators::many_light::ManyLight;
use manylight::scene::Scene;
use tiles::{TILE, prepare, tiles};

/// Runs per measurement; the median is reported.
const REPEATS: usize = 5;
/// Approximate number of pairs of a pixel and a light in one run.
const PAIRS: usize = 1 << 26;

fn main() {
    let counts = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = tiles::counts_or_default(counts);
    scene_list::for_each_scene(|path| {
        let scene = tiles::load(path);
        counts.iter().for_each(|&count| bench(&scene, count));
    });
}

fn bench(scene: &Scene, count: u32) {
    let (set, stats) = prepare(scene, count, ManyLight::rich_vpl());
    let stages: Vec<String> = (stats.stages().iter())
        .map(|(name, time)| format!("{name} {:.2} s", time.as_secs_f64()))
        .collect();
    let lights = set.lights.set.lights().len();
    let bytes = set.lights.set.bytes() as f64 / lights as f64;
    println!(
        "{lights} lights of {bytes:.0} B; {} (all threads)",
        stages.join(", ")
    );
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy: Strategy::All,
        clamp: Clamp::Auto(1.0),
        refinement: 1.0,
        roulette: 0.0,
    };
    let tiles = tiles(scene, (PAIRS / (lights * TILE * TILE)).max(8));
    measure(scene, &gather, &set.lights, &tiles);
}

fn measure(scene: &Scene, gather: &Gather, lights: &LightIndex, tiles: &[Vec<ShadingPoint>]) {
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
