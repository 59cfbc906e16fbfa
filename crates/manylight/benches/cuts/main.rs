//! Light-tree cuts compared with the sum over all lights, at the same points and with the same
//! lights: time and error.
//!
//! `MANYLIGHT_BENCH_SCENES=a.xml:b.xml cargo bench -p manylight --bench cuts [-- LIGHTS... [error=X...] [cut=N...] [plot=FOLDER]]`;
//! by default 4096, 32768 and 262144 virtual lights and the default limits of a cut. `plot` writes
//! time over number of lights to `FOLDER/cuts-SCENE.svg`.
//!
//! The points are the pixels of random 8 x 8 tiles of a 512 x 512 image. Times are of one thread.
//! The error of a point is relative to the luminance that all lights give there, or to 1/20 of the
//! mean luminance if that is larger.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "../shared/clock.rs"]
mod clock;
#[path = "../shared/plot.rs"]
mod plot;
#[path = "../shared/scene_list.rs"]
mod scene_list;
#[path = "../shared/tiles.rs"]
mod tiles;

use manylight::gather::{
    Clamp, CutLimits, Gather, Gathered, Kernel, LightIndex, ShadingPoint, Strategy,
};
use manylight::integrators::many_light::DARKEST_PIXEL;
use manylight::integrators::many_light::ManyLight;
use manylight::scene::Scene;
use plot::PlotLine;
use std::path::{Path, PathBuf};
use tiles::{TILE, prepare, tiles};

/// Approximate number of pairs of a point and a light in one sum over all lights.
const PAIRS: usize = 1 << 31;
/// Upper limit of the number of tiles.
const MAX_TILES: usize = 64;
/// Largest number of lights for which cuts without a size limit are measured as well.
const MAX_LIGHTS_UNLIMITED: usize = 1 << 17;
/// Points darker than this fraction of the mean luminance count as that bright in relative errors.
const ERROR_FLOOR: f32 = 0.05;

/// Options of the command line.
#[derive(Default)]
struct Options {
    counts: Vec<u32>,
    errors: Vec<f32>,
    cuts: Vec<u32>,
    plot: Option<PathBuf>,
}

impl Options {
    fn from_args() -> Options {
        let mut options = Options::default();
        for argument in std::env::args().skip(1) {
            match argument.split_once('=') {
                Some(("cut", number)) => options.cuts.extend(number.parse::<u32>()),
                Some(("error", number)) => options.errors.extend(number.parse::<f32>()),
                Some(("plot", folder)) => options.plot = Some(folder.into()),
                _ => options.counts.extend(argument.parse::<u32>()),
            }
        }
        options.counts = tiles::counts_or_default(options.counts);
        if options.errors.is_empty() {
            options.errors = vec![CutLimits::default().max_error];
        }
        if options.cuts.is_empty() {
            options.cuts = vec![CutLimits::default().max_lights];
        }
        options
    }

    /// Every combination of the limits.
    fn limits(&self) -> impl Iterator<Item = CutLimits> {
        self.cuts.iter().flat_map(|&max_lights| {
            self.errors.iter().map(move |&max_error| CutLimits {
                max_error,
                max_lights,
            })
        })
    }
}

fn main() {
    let options = Options::from_args();
    scene_list::for_each_scene(|path| {
        let scene = tiles::load(path);
        let mut lines: Vec<PlotLine> = Vec::new();
        for &count in &options.counts {
            let (lights, times) = bench(&scene, count, &options);
            for (name, milliseconds) in times {
                let point = (lights as f64, milliseconds);
                match lines.iter_mut().find(|line| line.name == name) {
                    Some(line) => line.points.push(point),
                    None => lines.push(PlotLine {
                        name,
                        points: vec![point],
                    }),
                }
            }
        }
        if let Some(folder) = &options.plot {
            let file = folder.join(format!("cuts-{}.svg", scene_name(path)));
            plot::draw(&file, "lights", "ms per point", &lines)
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        }
    });
}

/// The name of the folder of a scene file; many scene files have the same name.
fn scene_name(path: &Path) -> String {
    let folder = path.parent().and_then(Path::file_name);
    folder.map_or_else(
        || "scene".into(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// The sums at all points, and their processor time in seconds.
struct Measurement {
    sums: Vec<Gathered>,
    seconds: f64,
}

impl Measurement {
    fn mean_luminance(&self) -> f32 {
        self.sums.iter().map(luminance).sum::<f32>() / self.sums.len() as f32
    }

    fn milliseconds_per_point(&self) -> f64 {
        1e3 * self.seconds / self.sums.len() as f64
    }
}

/// Measures one number of lights. Returns the number of lights made, and milliseconds per point of
/// each strategy.
fn bench(scene: &Scene, count: u32, options: &Options) -> (usize, Vec<(String, f64)>) {
    let (set, stats) = prepare(scene, count, ManyLight::rich_lightcuts());
    let lights = set.lights;
    let light_count = lights.set.lights().len();
    let stage = |name| {
        let stages = stats.stages();
        let found = stages.iter().find(|(stage, _)| *stage == name);
        found.map_or(0.0, |(_, time)| time.as_secs_f64())
    };
    let tile_count = (PAIRS / (light_count * TILE * TILE)).clamp(2, MAX_TILES);
    let tiles = tiles(scene, tile_count);
    let all = sum(scene, &lights, Strategy::All, &tiles);
    println!(
        "{light_count} lights: made in {:.1} s, tree in {:.2} s (all threads); {} points; all: {:.3} s",
        stage("lights"),
        stage("tree"),
        all.sums.len(),
        all.seconds,
    );
    let mean = all.mean_luminance();
    let mut times = vec![("all".to_owned(), all.milliseconds_per_point())];
    for limits in options.limits() {
        let CutLimits {
            max_error,
            max_lights,
            ..
        } = limits;
        let cut = sum_by_cuts(scene, &lights, limits, &tiles, mean);
        println!("  {max_error}, {max_lights}: {}", comparison(&cut, &all));
        let name = format!("cut, {} %, {max_lights}", 100.0 * max_error);
        times.push((name, cut.milliseconds_per_point()));
    }
    if light_count <= MAX_LIGHTS_UNLIMITED {
        let unlimited = CutLimits {
            max_lights: u32::MAX,
            ..CutLimits::default()
        };
        let cut = sum_by_cuts(scene, &lights, unlimited, &tiles, mean);
        println!("  no limit: {}", comparison(&cut, &all));
    }
    (light_count, times)
}

/// Sums by cuts. As in rendering, the tolerated error of a point is relative to at least
/// [`DARKEST_PIXEL`] times the `mean` luminance.
fn sum_by_cuts(
    scene: &Scene,
    lights: &LightIndex,
    limits: CutLimits,
    tiles: &[Vec<ShadingPoint>],
    mean: f32,
) -> Measurement {
    let tolerance = limits.max_error * DARKEST_PIXEL * mean;
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
}

fn sum(
    scene: &Scene,
    lights: &LightIndex,
    strategy: Strategy,
    tiles: &[Vec<ShadingPoint>],
) -> Measurement {
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy,
        clamp: Clamp::Auto(1.0),
        refinement: 1.0,
        roulette: 0.0,
    };
    let start = clock::thread_seconds();
    let sums = tiles.iter().flat_map(|t| gather.sum(scene, lights, t));
    let sums = sums.collect();
    Measurement {
        sums,
        seconds: clock::thread_seconds() - start,
    }
}

fn luminance(sum: &Gathered) -> f32 {
    sum.radiance.luminance()
}

/// Time and errors of `cut` relative to `all`, as one line of text.
fn comparison(cut: &Measurement, all: &Measurement) -> String {
    let points = all.sums.len() as f32;
    let mean = all.mean_luminance();
    let pairs = cut.sums.iter().zip(&all.sums);
    let errors = pairs.map(|(cut, all)| {
        let (cut, all) = (luminance(cut), luminance(all));
        ((cut - all) / all.max(ERROR_FLOOR * mean)).abs()
    });
    let mut errors: Vec<f32> = errors.collect();
    errors.sort_by(f32::total_cmp);
    let terms = cut.sums.iter().map(|c| c.terms as f32).sum::<f32>() / points;
    format!(
        "{:.3} s = 1/{:.1}; {terms:.0} terms; mean {:+.2} %; error mean {:.2} %, median {:.2} %, 99th percentile {:.1} %",
        cut.seconds,
        all.seconds / cut.seconds,
        100.0 * (cut.mean_luminance() / mean - 1.0),
        100.0 * errors.iter().sum::<f32>() / points,
        100.0 * errors[errors.len() / 2],
        100.0 * errors[errors.len() * 99 / 100],
    )
}
