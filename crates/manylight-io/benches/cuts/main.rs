//! Cuts through a tree of lights beside sums over all of them, at the same points under the same lights:
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight-io --bench cuts [-- LIGHTS... [error=X...] [cut=N...]]`, by default 4096, 32768
//! and 262144 lights and the limits of the methods.
//!
//! Points are the pixels of random tiles of 8 x 8 of a picture of 512 x 512. Times are of one thread. Errors are those of single points, in parts of what all lights send there, or of a
//! twentieth of the mean where that is more.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

#[path = "../visibility/clock.rs"]
mod clock;
#[path = "../connections/tiles.rs"]
mod tiles;

use manylight::gather::{
    Clamp, CutLimits, Gather, Gathered, Kernel, Lights, ShadingPoint, Strategy,
};
use manylight::integrators::light_set::DARK;
use manylight::integrators::many_light::ManyLight;
use manylight::scene::Scene;
use tiles::{TILE, prepare, tiles};

/// Pairs of points and lights in a sum over all lights, about.
const PAIRS: usize = 1 << 27;
const MOST_TILES: usize = 64;
/// Cuts are shown without a limit to their size up to so many lights.
const MOST_UNLIMITED: usize = 1 << 16;

fn main() {
    let (mut counts, mut errors, mut cuts) = (Vec::new(), Vec::new(), Vec::new());
    for argument in std::env::args().skip(1) {
        match argument.split_once('=') {
            Some(("cut", number)) => cuts.extend(number.parse::<u32>()),
            Some(("error", number)) => errors.extend(number.parse::<f32>()),
            _ => counts.extend(argument.parse::<u32>()),
        }
    }
    if errors.is_empty() {
        errors = vec![CutLimits::default().max_error];
    }
    if cuts.is_empty() {
        cuts = vec![1000];
    }
    tiles::for_all(counts, |scene, count| bench(scene, count, &errors, &cuts));
}

/// What some way to sum lights brings at each point, and the seconds that it takes.
struct Run {
    sums: Vec<Gathered>,
    seconds: f64,
}

fn bench(scene: &Scene, count: u32, errors: &[f32], cuts: &[u32]) {
    let (set, stats) = prepare(scene, count, ManyLight::rich_lightcuts());
    let mut lights = set.lights;
    let lights_used = lights.field.lights().len();
    let stage = |name| {
        let stages = stats.stages();
        let found = stages.iter().find(|(stage, _)| *stage == name);
        found.map_or(0.0, |(_, time)| time.as_secs_f64())
    };
    let tiles = tiles(
        scene,
        (PAIRS / (lights_used * TILE * TILE)).clamp(2, MOST_TILES),
    );
    let all = sum(scene, &lights, Strategy::All, &tiles);
    let points = all.sums.len();
    let mean = all.sums.iter().map(luminance).sum::<f32>() / points as f32;
    println!(
        "{lights_used} lights: made in {:.1} s, tree in {:.2} s (all threads); {points} points; all: {:.3} s",
        stage("lights"),
        stage("tree"),
        all.seconds,
    );
    let sum_by_cuts = |limits: CutLimits, lights: &Lights| {
        // As in a picture: a pixel counts as no darker than this.
        let tolerance = limits.max_error * DARK * mean;
        let tiles: Vec<Vec<ShadingPoint>> = (tiles.iter())
            .map(|points| {
                let points = points.iter().map(|point| ShadingPoint {
                    tolerance,
                    ..*point
                });
                points.collect()
            })
            .collect();
        sum(scene, lights, Strategy::Cuts(limits), &tiles)
    };
    for &max_lights in cuts {
        for &max_error in errors {
            let limits = CutLimits {
                max_error,
                max_lights,
                ..CutLimits::default()
            };
            let cut = sum_by_cuts(limits, &lights);
            println!("  {max_error}, {max_lights}: {}", compared(&cut, &all));
        }
    }
    if lights_used <= MOST_UNLIMITED {
        let unlimited = CutLimits {
            max_lights: u32::MAX,
            ..CutLimits::default()
        };
        let cut = sum_by_cuts(unlimited, &lights);
        println!("  no limit: {}", compared(&cut, &all));
        lights.forget_directions();
        let blind = sum_by_cuts(unlimited, &lights);
        println!("  blind to directions: {}", compared(&blind, &all));
    }
}

fn sum(scene: &Scene, lights: &Lights, strategy: Strategy, tiles: &[Vec<ShadingPoint>]) -> Run {
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy,
        clamp: Clamp::Auto(1.0),
        finer: 1.0,
    };
    let start = clock::thread_seconds();
    let sums = tiles.iter().flat_map(|t| gather.sum(scene, lights, t));
    let sums = sums.collect();
    Run {
        sums,
        seconds: clock::thread_seconds() - start,
    }
}

fn luminance(sum: &Gathered) -> f32 {
    sum.radiance.luminance()
}

/// The time and the errors of a cut beside those of a sum over all lights.
fn compared(cut: &Run, all: &Run) -> String {
    let points = all.sums.len() as f32;
    let mean = all.sums.iter().map(luminance).sum::<f32>() / points;
    let pairs = cut.sums.iter().zip(&all.sums);
    let signed = pairs.map(|(c, a)| (luminance(c) - luminance(a)) / luminance(a).max(0.05 * mean));
    let signed: Vec<f32> = signed.collect();
    let mut errors: Vec<f32> = signed.iter().map(|e| e.abs()).collect();
    errors.sort_by(f32::total_cmp);
    let size = cut.sums.iter().map(|c| c.terms as f32).sum::<f32>() / points;
    let ratio = cut.sums.iter().map(luminance).sum::<f32>() / points / mean;
    format!(
        "{:.3} s = 1/{:.1}; {size:.0} terms; mean {:+.2} %; error mean {:.2} %, median {:.2} %, 99 of 100 below {:.1} %",
        cut.seconds,
        all.seconds / cut.seconds,
        100.0 * (ratio - 1.0),
        100.0 * errors.iter().sum::<f32>() / points,
        100.0 * errors[errors.len() / 2],
        100.0 * errors[errors.len() * 99 / 100],
    )
}
