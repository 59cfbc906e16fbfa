//! Cuts through a tree of lights beside sums over all of them, at the same points under the same lights:
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight-io --bench cuts [-- LIGHTS... [error=X...] [cut=N...]
//! [plot=FOLDER]]`, by default 4096, 32768 and 262144 lights and the limits of the methods. In the folder, a plot of times over lights is left.
//!
//! Points are the pixels of random tiles of 8 x 8 of a picture of 512 x 512. Times are of one thread. Errors are those of single points, in parts of what all lights send there, or of a
//! twentieth of the mean where that is more.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

#[path = "../visibility/clock.rs"]
mod clock;
#[path = "../growth/plot.rs"]
mod plot;
#[path = "../connections/tiles.rs"]
mod tiles;

use manylight::gather::{
    Clamp, CutLimits, Gather, Gathered, Kernel, LightIndex, ShadingPoint, Strategy,
};
use manylight::integrators::light_set::DARK;
use manylight::integrators::many_light::ManyLight;
use manylight::scene::Scene;
use plot::Line;
use std::path::{Path, PathBuf};
use tiles::{TILE, prepare, tiles};

/// Pairs of points and lights in a sum over all lights, about.
const PAIRS: usize = 1 << 31;
const MOST_TILES: usize = 64;
/// Cuts are shown without a limit to their size up to so many lights.
const MOST_UNLIMITED: usize = 1 << 17;

/// What the command line asks for.
#[derive(Default)]
struct Asked {
    counts: Vec<u32>,
    errors: Vec<f32>,
    cuts: Vec<u32>,
    plot: Option<PathBuf>,
}

impl Asked {
    fn from_args() -> Asked {
        let mut asked = Asked::default();
        for argument in std::env::args().skip(1) {
            match argument.split_once('=') {
                Some(("cut", number)) => asked.cuts.extend(number.parse::<u32>()),
                Some(("error", number)) => asked.errors.extend(number.parse::<f32>()),
                Some(("plot", folder)) => asked.plot = Some(folder.into()),
                _ => asked.counts.extend(argument.parse::<u32>()),
            }
        }
        asked.counts = tiles::counts_or_default(asked.counts);
        if asked.errors.is_empty() {
            asked.errors = vec![CutLimits::default().max_error];
        }
        if asked.cuts.is_empty() {
            asked.cuts = vec![CutLimits::default().max_lights];
        }
        asked
    }
}

fn main() {
    let asked = Asked::from_args();
    tiles::for_all(|path, scene| {
        let mut lines: Vec<Line> = Vec::new();
        for &count in &asked.counts {
            let (lights, times) = bench(scene, count, &asked);
            for (name, milliseconds) in times {
                let point = (lights as f64, milliseconds);
                match lines.iter_mut().find(|line| line.name == name) {
                    Some(line) => line.points.push(point),
                    None => lines.push(Line {
                        name,
                        points: vec![point],
                    }),
                }
            }
        }
        if let Some(folder) = &asked.plot {
            let file = folder.join(format!("cuts-{}.svg", name_of(path)));
            plot::draw(&file, "lights", "ms per point", &lines)
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        }
    });
}

/// The folder that a scene is in: files are often called alike.
fn name_of(path: &Path) -> String {
    let folder = path.parent().and_then(Path::file_name);
    folder.map_or_else(
        || "scene".into(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// What some way to sum lights brings at each point, and the seconds that it takes.
struct Run {
    sums: Vec<Gathered>,
    seconds: f64,
}

/// The number of lights, and milliseconds per point of each way to sum them.
fn bench(scene: &Scene, count: u32, asked: &Asked) -> (usize, Vec<(String, f64)>) {
    let (set, stats) = prepare(scene, count, ManyLight::rich_lightcuts());
    let mut lights = set.lights;
    let lights_used = lights.set.lights().len();
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
    let sum_by_cuts = |limits: CutLimits, lights: &LightIndex| {
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
    let per_point = |run: &Run| 1e3 * run.seconds / points as f64;
    let mut times = vec![("all".to_owned(), per_point(&all))];
    for &max_lights in &asked.cuts {
        for &max_error in &asked.errors {
            let limits = CutLimits {
                max_error,
                max_lights,
                ..CutLimits::default()
            };
            let cut = sum_by_cuts(limits, &lights);
            println!("  {max_error}, {max_lights}: {}", compared(&cut, &all));
            let name = format!("cut, {} %, {max_lights}", 100.0 * max_error);
            times.push((name, per_point(&cut)));
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
    (lights_used, times)
}

fn sum(scene: &Scene, lights: &LightIndex, strategy: Strategy, tiles: &[Vec<ShadingPoint>]) -> Run {
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy,
        clamp: Clamp::Auto(1.0),
        refinement: 1.0,
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
