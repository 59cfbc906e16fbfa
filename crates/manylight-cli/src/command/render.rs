//! `manylight render`: load, build, render, denoise, write, report.

mod denoise;
mod preview;
mod share;

use crate::args::{DisplayArgs, RenderArgs};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{Console, human_bytes, print_data, print_message, print_warnings};
use crate::part::{Checkpoints, Resumed};
use crate::picture::{PictureFacts, PictureSource};
use crate::progress::{self, ProgressGoal};
use crate::repeat::Settings;
use crate::report::{RenderReport, resident_bytes};
use crate::request::RenderRequest;
use manylight::integrators::StageMemory;
use manylight::render::{Observer, Outcome, RenderJob, Stats, resume};
use manylight::scene::Scene;
use manylight_denoise::{Oidn, Version};
use manylight_io::{FileError, check_replaceable, scene_digest};
use preview::RenderPreview;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde_json::{Map, Value};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Renders a scene to image files, or a share of it to a part file.
pub(crate) fn run(args: &RenderArgs) -> Result<ExitCode, Failure> {
    let request = RenderRequest::new(args)?;
    let checkpoint = request.checkpoint.as_ref().map(|plan| &plan.path);
    for path in request.outputs.iter().chain(checkpoint) {
        check_replaceable(path)?;
    }
    let interrupt = Interrupt::install()?;
    let pool = thread_pool(request.threads)?;
    let stats = Stats::default();
    let oidn = denoise::open(&request, args.display)?;

    let loaded = pool.install(|| load(&request, &stats, args.display))?;
    let digest = stats.time("load", || {
        pool.install(|| scene_digest(&request.scene, &loaded.files))
    })?;
    let mut run = Run {
        args,
        request: &request,
        interrupt: &interrupt,
        pool: &pool,
        stats: &stats,
        oidn: oidn.as_ref().map(Oidn::version),
        scene: &loaded.scene,
        digest: &digest,
        warnings: loaded.warnings,
        console: Console::default(),
    };
    match request.shard {
        None => run.whole(oidn.as_ref()),
        Some(shard) => run.share(shard),
    }
}

/// A render of a loaded scene.
struct Run<'r> {
    args: &'r RenderArgs,
    request: &'r RenderRequest,
    interrupt: &'r Interrupt,
    pool: &'r ThreadPool,
    stats: &'r Stats,
    /// Version of Open Image Denoise, if the image is to be denoised.
    oidn: Option<Version>,
    scene: &'r Scene,
    /// SHA-256 of the files of the scene.
    digest: &'r str,
    /// Warnings without repetitions.
    warnings: Vec<String>,
    console: Console,
}

impl<'r> Run<'r> {
    fn job(&self) -> RenderJob<'r> {
        RenderJob {
            scene: self.scene,
            method: self.request.method(self.scene.limits),
            budget: self.request.budget,
            seed: self.request.seed,
            block: self.request.block,
        }
    }

    /// Settings of a render of `job`.
    fn settings<'s>(&'s self, job: &'s RenderJob<'r>) -> Settings<'s> {
        Settings {
            request: self.request,
            method: &job.method,
            film: &self.scene.sensor.desc().film,
            threads: self.pool.current_num_threads(),
            oidn: self.oidn,
        }
    }

    /// Renders an image, and denoises it by `oidn`.
    fn whole(&mut self, oidn: Option<&Oidn>) -> Result<ExitCode, Failure> {
        let (stats, interrupt, display) = (self.stats, self.interrupt, self.args.display);
        let mut preview = RenderPreview::start(self.args, self.request, &self.console);
        let mut job = self.job();
        let sums = if job.budget.passes.is_some_and(|n| n <= job.block.get()) {
            1
        } else {
            2
        };
        let pictures = preview.memory(&job);
        self.pool
            .install(|| check_memory(self.request, &job, sums, pictures))?;
        let identity = self.settings(&job).identity(self.digest);
        let resumed = Resumed::load(self.request, &job, &identity)?;
        let features = (oidn.is_some())
            .then(|| {
                self.pool
                    .install(|| denoise::features(&mut job, stats, interrupt))
            })
            .flatten();
        resumed.state.add_to(stats);
        let goal = ProgressGoal::new(job.budget, display);
        let (outcome, checkpoint) =
            progress::show(goal, stats, interrupt.cancel(), &self.console, |observer| {
                let observer = &mut preview.beside(observer);
                self.pool
                    .install(|| self.render(&job, resumed, &identity, observer))
            });
        self.warnings.extend(dropped_samples(stats, display));
        let (film, features) = (&outcome.film, features.as_ref());
        let denoised = denoise::denoise(oidn, film, features, stats, interrupt);
        self.pool
            .install(|| preview.finish(&outcome, denoised.image.as_ref(), stats));

        let report = self.report(&job, film.passes());
        let facts = PictureFacts::new(self.scene, film.id_layers(), report.metadata());
        let source = PictureSource {
            film,
            denoised: denoised.image.as_ref(),
            facts: &facts,
        };
        stats.time("write", || {
            source.write(&self.request.outputs, &self.request.picture.file, interrupt)
        })?;
        finish(&report, display)?;
        preview.close();
        match checkpoint.err().map(Failure::from).or(denoised.failure) {
            Some(failure) => Err(failure),
            None => self.exit_code(),
        }
    }

    /// Renders the passes that `resumed` lacks. Also says whether the last checkpoint was written.
    fn render(
        &self,
        job: &RenderJob,
        resumed: Resumed,
        identity: &Map<String, Value>,
        observer: &mut dyn Observer,
    ) -> (Outcome, Result<(), FileError>) {
        let (stats, cancel, elapsed) =
            (self.stats, self.interrupt.cancel(), resumed.state.elapsed());
        let Some(plan) = &self.request.checkpoint else {
            return (
                resume(job, resumed.film, elapsed, stats, cancel, observer),
                Ok(()),
            );
        };
        let mut checkpoints = Checkpoints {
            plan,
            identity,
            interrupt: self.interrupt,
            console: &self.console,
            last: Instant::now(),
            failure: None,
            observer,
        };
        let outcome = resume(job, resumed.film, elapsed, stats, cancel, &mut checkpoints);
        (outcome, checkpoints.failure.map_or(Ok(()), Err))
    }

    fn report<'s>(&'s self, job: &'s RenderJob<'r>, passes: u32) -> RenderReport<'s> {
        RenderReport {
            settings: self.settings(job),
            stats: self.stats,
            passes,
            warnings: &self.warnings,
            scene_digest: self.digest,
        }
    }

    fn exit_code(&self) -> Result<ExitCode, Failure> {
        match self.interrupt.exit_code() {
            Some(code) => Ok(ExitCode::from(code)),
            None if self.request.strict && !self.warnings.is_empty() => {
                Err(Failure::Strict(self.warnings.len()))
            }
            None => Ok(ExitCode::SUCCESS),
        }
    }
}

/// Refuses a render with an estimated memory above its limit. It holds `sums` sums over passes at once.
fn check_memory(
    request: &RenderRequest,
    job: &RenderJob,
    sums: usize,
    pictures: Option<StageMemory>,
) -> Result<(), Failure> {
    let Some(limit) = request.memory_limit else {
        return Ok(());
    };
    let scene = StageMemory {
        stage: "scene",
        bytes: resident_bytes(),
    };
    let render = (job.method).memory(job.scene, job.budget.passes, sums, job.seed);
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
    if request.shard.is_some() {
        print_message(
            "next: manylight merge PART... -o image.exr   (with the parts of all shares)",
        );
        return;
    }
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
