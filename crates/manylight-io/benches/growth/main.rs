//! How the time of a pass of Rich-VPLs grows with lights, pixels, triangles and threads:
//! `cargo bench -p manylight-io --bench growth [-- FOLDER]` writes `growth-*.svg` there, or only prints.
//!
//! The scene is `scenes/glossy-room`, or the file that `MANYLIGHT_BENCH_SCENE` names. Triangles grow by division in four, which changes no
//! picture.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

mod plot;

use manylight::film::Film;
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::many_light::ManyLight;
use manylight::integrators::{Method, MethodKind};
use manylight::math::UVec2;
use manylight::render::{Budget, Observer, RenderJob, Stats, render};
use manylight::scene::{Scene, SceneDesc};
use manylight_io::{LoadOptions, load_scene};
use plot::Line;
use rayon::ThreadPoolBuilder;
use std::collections::HashMap;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const REPEATS: usize = 3;
/// Width of the picture, and lights, where these do not grow.
const WIDTH: u32 = 256;
const LIGHTS: u32 = 512;

/// One setting, what grows along the other axis, and the seconds of each stage.
struct Point {
    x: f64,
    seconds: Vec<(&'static str, f64)>,
}

struct Unassigned;

impl Observer for Unassigned {
    fn pass_done(&mut self, _: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().skip(1).find(|a| a != "--bench");
    let folder = folder.map(PathBuf::from);
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/glossy-room/scene.xml");
    let path = std::env::var_os("MANYLIGHT_BENCH_SCENE").map_or(own, PathBuf::from);
    let desc = load_scene(&path, &LoadOptions::default())?.desc;
    let all = std::thread::available_parallelism()?.get();
    let show = |name: &str, points: &[Point]| show(folder.as_deref(), name, points);

    let scene = Scene::build(with_width(&desc, WIDTH), 0)?;
    let by_lights = (8..=14).step_by(2).map(|log| Point {
        x: f64::from(1u32 << log),
        seconds: stages(&scene, 1 << log, all),
    });
    show("lights", &by_lights.collect::<Vec<_>>())?;
    let by_threads = (0..)
        .map(|log| 1 << log)
        .take_while(|&threads| threads <= all)
        .map(|threads| Point {
            x: threads as f64,
            seconds: stages(&scene, LIGHTS, threads),
        });
    show("threads", &by_threads.collect::<Vec<_>>())?;
    let mut by_pixels = Vec::new();
    for width in [64, 128, 256, 512] {
        let scene = Scene::build(with_width(&desc, width), 0)?;
        let size = scene.sensor.desc().film.size;
        by_pixels.push(Point {
            x: f64::from(size.x * size.y),
            seconds: stages(&scene, LIGHTS, all),
        });
    }
    show("pixels", &by_pixels)?;
    let mut by_triangles = Vec::new();
    let mut desc = with_width(&desc, WIDTH);
    for _ in 0..4 {
        let start = Instant::now();
        let scene = Scene::build(desc.clone(), 0)?;
        let mut seconds = vec![("build", start.elapsed().as_secs_f64())];
        seconds.extend(stages(&scene, LIGHTS, all));
        by_triangles.push(Point {
            x: scene.geometry.triangle_count() as f64,
            seconds,
        });
        for shape in &mut desc.shapes {
            if let Shape::Mesh(mesh) = shape {
                *mesh = divided(mesh);
            }
        }
    }
    show("triangles", &by_triangles)
}

fn with_width(desc: &SceneDesc, width: u32) -> SceneDesc {
    let mut desc = desc.clone();
    let film = &mut desc.sensors[0].film;
    let height = (f64::from(film.size.y) / f64::from(film.size.x) * f64::from(width)).round();
    *film = film.with_size(UVec2::new(width, height as u32));
    desc
}

/// Median seconds of the stages of one pass.
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
        },
        budget: Budget {
            passes: Some(1),
            time: None,
            relative_error: None,
        },
        seed: 0,
    };
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap_or_else(|error| panic!("no threads: {error}"));
    let mut seconds: HashMap<&'static str, Vec<f64>> = HashMap::new();
    let mut order = Vec::new();
    for _ in 0..REPEATS {
        let stats = Stats::default();
        pool.install(|| render(&job, &stats, &AtomicBool::new(false), &mut Unassigned));
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

/// Each triangle as four.
fn divided(mesh: &Mesh) -> Mesh {
    let mut out = Mesh {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uvs: mesh.uvs.clone(),
        triangles: Vec::with_capacity(4 * mesh.triangles.len()),
    };
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
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
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        out.triangles
            .extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    out
}

/// Prints the seconds, and draws them if there is a folder.
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
        Line {
            name: stage.into(),
            points: points.iter().filter_map(at).collect(),
        }
    });
    let file = folder.join(format!("growth-{name}.svg"));
    plot::draw(&file, name, "s", &lines.collect::<Vec<_>>())
}
