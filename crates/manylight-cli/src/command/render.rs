//! `manylight render`: load, build, render, denoise, write, report.

mod denoise;
mod layer_names;
mod picture;
mod preview;

use crate::args::{DisplayArgs, RenderArgs};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::names::AovNames;
use crate::output::{Console, human_bytes, print_data, print_message, print_warnings};
use crate::progress::{self, ProgressGoal};
use crate::repeat::Settings;
use crate::report::{RenderReport, resident_bytes};
use crate::request::RenderRequest;
use manylight::integrators::StageMemory;
use manylight::render::{RenderJob, Stats, render};
use manylight::scene::Scene;
use manylight_denoise::Oidn;
use manylight_io::image::{ImageFormat, check_writable, write_image};
use manylight_io::scene_digest;
use picture::PictureSource;
use preview::RenderPreview;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::PathBuf;
use std::process::ExitCode;

/// Renders a scene to image files.
pub(crate) fn run(args: &RenderArgs) -> Result<ExitCode, Failure> {
    let request = RenderRequest::new(args)?;
    request
        .outputs
        .iter()
        .try_for_each(|path| check_writable(path))?;
    let interrupt = Interrupt::install()?;
    let pool = thread_pool(request.threads)?;
    let stats = Stats::default();
    let oidn = denoise::open(&request, args.display)?;
    let console = Console::default();
    let mut preview = RenderPreview::start(args, &request, &console);

    let Loaded {
        scene,
        mut warnings,
        files,
    } = pool.install(|| load(&request, &stats, args.display))?;
    let digest = stats.time("load", || {
        pool.install(|| scene_digest(&request.scene, &files))
    })?;
    let method = request.method(scene.limits);
    let mut job = RenderJob {
        scene: &scene,
        method,
        budget: request.budget,
        seed: request.seed,
    };
    let pictures = preview.memory(&job);
    pool.install(|| check_memory(&request, &job, pictures))?;
    let features = (oidn.is_some())
        .then(|| pool.install(|| denoise::features(&mut job, &stats, &interrupt)))
        .flatten();
    let goal = ProgressGoal::new(job.budget, args.display);
    let outcome = progress::show(goal, &stats, interrupt.cancel(), &console, |observer| {
        let observer = &mut preview.beside(observer);
        pool.install(|| render(&job, &stats, interrupt.cancel(), observer))
    });
    warnings.extend(dropped_samples(&stats, args.display));
    let (film, features) = (&outcome.film, features.as_ref());
    let denoised = denoise::denoise(oidn.as_ref(), film, features, &stats, &interrupt);
    pool.install(|| preview.finish(&outcome, denoised.image.as_ref(), &stats));

    let settings = Settings {
        request: &request,
        method: &job.method,
        film: film.desc(),
        threads: pool.current_num_threads(),
        oidn: oidn.as_ref().map(Oidn::version),
    };
    let report = RenderReport {
        settings,
        stats: &stats,
        passes: film.passes(),
        warnings: &warnings,
        scene_digest: &digest,
    };
    let source = PictureSource {
        film,
        denoised: denoised.image.as_ref(),
        names: &scene.names,
        sensor: &scene.sensor,
        metadata: report.metadata(),
    };
    write(&report, &source, &interrupt)?;
    finish(&report, args.display)?;
    preview.close();
    if let Some(failure) = denoised.failure {
        return Err(failure);
    }
    match interrupt.exit_code() {
        Some(code) => Ok(ExitCode::from(code)),
        None if request.strict && !warnings.is_empty() => Err(Failure::Strict(warnings.len())),
        None => Ok(ExitCode::SUCCESS),
    }
}

/// Refuses a render with an estimated memory above its limit.
fn check_memory(
    request: &RenderRequest,
    job: &RenderJob,
    pictures: Option<StageMemory>,
) -> Result<(), Failure> {
    let Some(limit) = request.memory_limit else {
        return Ok(());
    };
    let scene = StageMemory {
        stage: "scene",
        bytes: resident_bytes(),
    };
    let render = job.method.memory(job.scene, job.budget.passes, job.seed);
    let stages: Vec<StageMemory> = std::iter::once(scene)
        .chain(render)
        .chain(pictures)
        .collect();
    let total = stages.iter().map(|stage| stage.bytes).sum();
    if total <= limit {
        return Ok(());
    }
    let parts: Vec<String> = (stages.iter())
        .map(|stage| format!("{} {}", stage.stage, human_bytes(stage.bytes)))
        .collect();
    Err(Failure::usage(
        format!(
            "the render would take about {} ({}); --memory-limit is {}",
            human_bytes(total),
            parts.join(", "),
            human_bytes(limit)
        ),
        "reduce --lights, --photons, --table-size or --size, or use --emission vmf",
    ))
}

/// A pool of `threads` threads; `None` for one per processor.
pub(super) fn thread_pool(threads: Option<usize>) -> Result<ThreadPool, Failure> {
    ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|error| Failure::Internal(format!("cannot start threads: {error}")))
}

/// A scene that is ready to be rendered.
pub(super) struct Loaded {
    /// The scene.
    pub(super) scene: Scene,
    /// Warnings without repetitions.
    pub(super) warnings: Vec<String>,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
}

/// Loads and builds the scene. Its warnings are printed too.
pub(super) fn load(
    request: &RenderRequest,
    stats: &Stats,
    display: DisplayArgs,
) -> Result<Loaded, Failure> {
    if display.verbose {
        print_message(format_args!("loading {}", request.scene.display()));
    }
    let loaded = stats.time("load", || {
        manylight_io::load_scene(&request.scene, &request.load_options())
    })?;
    let mut warnings: Vec<String> = Vec::new();
    for warning in loaded.warnings.iter().map(ToString::to_string) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    if !display.quiet || request.strict {
        print_warnings(&warnings);
    }
    if request.strict && !warnings.is_empty() {
        return Err(Failure::Strict(warnings.len()));
    }
    let mut desc = loaded.desc;
    request.adjust_camera(&mut desc)?;
    let scene = stats.time("build", || Scene::build(desc, request.sensor));
    let scene = scene.map_err(|error| Failure::Scene {
        scene: request.scene.clone(),
        message: error.message,
    })?;
    Ok(Loaded {
        scene,
        warnings,
        files: loaded.files,
    })
}

/// A warning if samples were not finite, which is printed too.
fn dropped_samples(stats: &Stats, display: DisplayArgs) -> Option<String> {
    let dropped = Stats::get(&stats.dropped_samples);
    if dropped == 0 {
        return None;
    }
    let warning = format!("{dropped} samples were not finite and were replaced by black");
    if !display.quiet {
        print_warnings(std::slice::from_ref(&warning));
    }
    Some(warning)
}

fn write(
    report: &RenderReport,
    source: &PictureSource,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let request = report.settings.request;
    let plain = source.picture(AovNames::Manylight);
    // Only EXR files have layers with names.
    let renamed = match request.picture.aov_names {
        AovNames::Manylight => None,
        other => Some(source.picture(other)),
    };
    report.stats.time("write", || {
        request.outputs.iter().try_for_each(|path| {
            let is_exr = ImageFormat::from_path(path)? == ImageFormat::Exr;
            let picture = renamed.as_ref().filter(|_| is_exr).unwrap_or(&plain);
            let _complete_file = interrupt.writing();
            write_image(path, picture, request.picture.display())
        })
    })?;
    Ok(())
}

fn finish(report: &RenderReport, display: DisplayArgs) -> Result<(), Failure> {
    let outputs = &report.settings.request.outputs;
    if !display.quiet {
        if display.verbose {
            for (name, value) in report.settings.to_json() {
                print_message(format_args!("  {name}: {value}"));
            }
        }
        report.print_times(display);
        for path in outputs {
            print_message(format_args!("wrote {}", path.display()));
        }
        print_next_step(report);
    }
    if display.json {
        print_data(report.to_json())
    } else {
        Ok(())
    }
}

/// Prints a suggestion for the next command.
fn print_next_step(report: &RenderReport) {
    let request = report.settings.request;
    let exr = request
        .outputs
        .iter()
        .find(|path| path.extension().is_some_and(|e| e == "exr"));
    let scene = request.scene.display();
    match exr {
        Some(image) if request.method != "path" => {
            print_message(format_args!(
                "next: manylight render {scene} -m path --spp 256 -o reference.exr\n      \
                 manylight compare {} reference.exr",
                image.display()
            ));
        }
        Some(image) => print_message(format_args!(
            "next: manylight compare IMAGE.exr {}",
            image.display()
        )),
        None => print_message(format_args!(
            "next: manylight render {scene} -o image.exr   (all layers, for `manylight compare`)"
        )),
    }
}
