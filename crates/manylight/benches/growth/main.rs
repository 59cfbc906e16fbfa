//! Growth of the time of one Rich-VPL pass with the numbers of lights, threads, pixels and
//! triangles.
//!
//! `cargo bench -p manylight --bench growth [-- FOLDER]` prints the seconds of each stage, and
//! writes `growth-*.svg` to FOLDER.
//!
//! The scene is `scenes/glossy-room`, or the file that `MANYLIGHT_BENCH_SCENE` names. The number of
//! triangles grows by splitting each triangle into four, which leaves the image unchanged.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "../shared/default_scene.rs"]
mod default_scene;
#[path = "../shared/plot.rs"]
mod plot;

use manylight::film::Film;
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::many_light::ManyLight;
use manylight::integrators::{ExtraLayers, Method, MethodKind};
use manylight::math::UVec2;
use manylight::render::{Budget, Observer, RenderJob, Stats, render};
use manylight::scene::{Scene, SceneDesc};
use manylight_io::{LoadOptions, load_scene};
use plot::PlotLine;
use rayon::ThreadPoolBuilder;
use std::collections::HashMap;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Runs per measurement; the median is reported.
const REPEATS: usize = 3;
/// Width of the image in pixels, except in the series over pixels.
const WIDTH: u32 = 256;
/// Number of virtual lights, except in the series over lights.
const LIGHTS: u32 = 512;

/// One measurement of a series.
struct Point {
    /// The quantity that grows.
    x: f64,
    /// Name and seconds of each stage.
    seconds: Vec<(&'static str, f64)>,
}

/// An observer that does nothing.
struct Silent;

impl Observer for Silent {
    fn pass_done(&mut self, _: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().skip(1).find(|a| a != "--bench");
    let folder = folder.map(PathBuf::from);
    let desc = load_scene(&default_scene::default_scene(), &LoadOptions::default())?.desc;
    let all_threads = std::thread::available_parallelism()?.get();
    let show = |name: &str, points: &[Point]| show(folder.as_deref(), name, points);

    let scene = Scene::build(with_width(&desc, WIDTH), 0)?;
    show("lights", &over_lights(&scene, all_threads))?;
    show("threads", &over_threads(&scene, all_threads))?;
    show("pixels", &over_pixels(&desc, all_threads)?)?;
    show("triangles", &over_triangles(&desc, all_threads)?)
}

fn over_lights(scene: &Scene, threads: usize) -> Vec<Point> {
    let counts = (8..=14).step_by(2).map(|log| 1 << log);
    let point = |lights: u32| Point {
        x: f64::from(lights),
        seconds: stages(scene, lights, threads),
    };
    counts.map(point).collect()
}

fn over_threads(scene: &Scene, all_threads: usize) -> Vec<Point> {
    let counts = (0..).map(|log| 1 << log);
    let counts = counts.take_while(|&threads| threads <= all_threads);
    let point = |threads: usize| Point {
        x: threads as f64,
        seconds: stages(scene, LIGHTS, threads),
    };
    counts.map(point).collect()
}

fn over_pixels(desc: &SceneDesc, threads: usize) -> Result<Vec<Point>, Box<dyn Error>> {
    let mut points = Vec::new();
    for width in [64, 128, 256, 512] {
        let scene = Scene::build(with_width(desc, width), 0)?;
        let size = scene.sensor.desc().film.size;
        points.push(Point {
            x: f64::from(size.x * size.y),
            seconds: stages(&scene, LIGHTS, threads),
        });
    }
    Ok(points)
}

fn over_triangles(desc: &SceneDesc, threads: usize) -> Result<Vec<Point>, Box<dyn Error>> {
    let mut points = Vec::new();
    let mut desc = with_width(desc, WIDTH);
    for _ in 0..4 {
        let start = Instant::now();
        let scene = Scene::build(desc.clone(), 0)?;
        let mut seconds = vec![("build", start.elapsed().as_secs_f64())];
        seconds.extend(stages(&scene, LIGHTS, threads));
        points.push(Point {
            x: scene.geometry.triangle_count() as f64,
            seconds,
        });
        for shape in &mut desc.shapes {
            if let Shape::Mesh(mesh) = shape {
                *mesh = subdivided(mesh);
            }
        }
    }
    Ok(points)
}

/// The scene with an image of this width and about the same aspect ratio.
fn with_width(desc: &SceneDesc, width: u32) -> SceneDesc {
    let mut desc = desc.clone();
    let film = &mut desc.sensors[0].film;
    let height = (f64::from(film.size.y) / f64::from(film.size.x) * f64::from(width)).round();
    *film = film.with_size(UVec2::new(width, height as u32));
    desc
}

/// Median seconds of each stage of one pass.
fn stages(scene: &Scene, lights: u32, threads: usize) -> Vec<(&'static str, f64)> {
    let preset = ManyLight::rich_vpl();
    let job = RenderJob {
        scene,
        method: Method {
            kind: MethodKind::ManyLight(ManyLight {
                light_count: lights,
                photon_paths: preset.photon_paths.max(16 * lights),
                ..preset
            }),
            limits: scene.limits,
            extra: ExtraLayers::default(),
        },
        budget: Budget {
            passes: Some(1),
            time: None,
            relative_error: None,
        },
        seed: 0,
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    };
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap_or_else(|error| panic!("cannot start {threads} threads: {error}"));
    let mut seconds: HashMap<&'static str, Vec<f64>> = HashMap::new();
    let mut order = Vec::new();
    for _ in 0..REPEATS {
        let stats = Stats::default();
        pool.install(|| render(&job, &stats, &AtomicBool::new(false), &mut Silent));
        for (stage, time) in stats.stages() {
            if !order.contains(&stage) {
                order.push(stage);
            }
            seconds.entry(stage).or_default().push(time.as_secs_f64());
        }
    }
    let median = |stage: &'static str| {
        let mut times = seconds[stage].clone();
        times.sort_by(f64::total_cmp);
        (stage, times[times.len() / 2])
    };
    order.into_iter().map(median).collect()
}

/// The mesh with each triangle split at the midpoints of its edges.
fn subdivided(mesh: &Mesh) -> Mesh {
    let mut out = Mesh {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        tangents: Vec::new(),
        uvs: mesh.uvs.clone(),
        triangles: Vec::with_capacity(4 * mesh.triangles.len()),
    };
    let mut midpoints: HashMap<(u32, u32), u32> = HashMap::new();
    let mut midpoint = |a: u32, b: u32| {
        *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (i, j) = (a as usize, b as usize);
            out.positions
                .push((out.positions[i] + out.positions[j]) * 0.5);
            if !out.normals.is_empty() {
                out.normals
                    .push((out.normals[i] + out.normals[j]).normalize_or_zero());
            }
            if !out.uvs.is_empty() {
                out.uvs.push((out.uvs[i] + out.uvs[j]) * 0.5);
            }
            (out.positions.len() - 1) as u32
        })
    };
    for &[a, b, c] in &mesh.triangles {
        let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
        out.triangles
            .extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    out
}

/// Prints a series, and plots it to `folder/growth-NAME.svg` if there is a folder.
fn show(folder: Option<&Path>, name: &str, points: &[Point]) -> Result<(), Box<dyn Error>> {
    println!("\n{name}");
    for point in points {
        let stages: Vec<String> = (point.seconds.iter())
            .map(|(stage, seconds)| format!("{stage} {seconds:.3} s"))
            .collect();
        println!("{:>9}: {}", point.x, stages.join(", "));
    }
    let Some(folder) = folder else {
        return Ok(());
    };
    let stages = points[0].seconds.iter().map(|&(stage, _)| stage);
    let lines = stages.map(|stage| {
        let at = |point: &Point| {
            let found = point.seconds.iter().find(|s| s.0 == stage);
            found.map(|s| (point.x, s.1))
        };
        PlotLine {
            name: stage.into(),
            points: points.iter().filter_map(at).collect(),
        }
    });
    let file = folder.join(format!("growth-{name}.svg"));
    plot::draw(&file, name, "s", &lines.collect::<Vec<_>>())
}
