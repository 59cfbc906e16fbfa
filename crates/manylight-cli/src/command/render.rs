//! `manylight render`: load, build, render, denoise, write, report.

mod frames;
mod preview;
mod share;

use crate::args::{DisplayArgs, RenderArgs};
use crate::denoiser::open_denoiser;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::kept_lights::{ShadingLights, request_with_lights};
use crate::output::{Console, print_data, print_message, print_warnings};
use crate::part::open_checkpoint;
use crate::picture::PictureSource;
use crate::pre_pass::{choose, print_choice};
use crate::prepared::{Prepared, RenderedFilm};
use crate::progress::{self, ProgressGoal};
use crate::repeat::reference_command;
use crate::report::RenderReport;
use crate::request::RenderRequest;
use crate::session::{SceneFile, Session, build_scene, thread_pool};
use crate::stated_error::error_bars;
use manylight::render::Stats;
use manylight_denoise::Oidn;
use manylight_io::image::ImageFormat;
use manylight_io::part::{LightsFile, check_part_writable};
use manylight_io::{check_replaceable, shown_path};
use preview::RenderPreview;
use rayon::ThreadPool;
use std::sync::{Arc, OnceLock};

/// Renders a scene to image files, or a share of it to a part file.
pub(crate) fn run(args: &RenderArgs) -> Result<u8, Failure> {
    let (request, lights) = request_with_lights(args)?;
    let checkpoint = request.parts.checkpoint.as_ref();
    let (images, parts) = match request.parts.shard {
        _ if request.frames.is_walkthrough() => ([].as_slice(), [].as_slice()),
        None => (request.outputs.as_slice(), [].as_slice()),
        Some(_) => ([].as_slice(), request.outputs.as_slice()),
    };
    for path in images {
        check_replaceable(path)?;
    }
    for path in parts.iter().chain(checkpoint) {
        check_part_writable(path)?;
    }
    // A wrong checkpoint is refused before the time of loading and of the pre-pass.
    open_checkpoint(&request)?;
    let interrupt = Interrupt::install()?;
    let oidn = open_denoiser(&request.denoise, request.run.threads())?;
    let run = Run {
        args,
        session: open((request, lights), oidn.as_ref(), args.display)?,
        interrupt: &interrupt,
        console: Console::default(),
    };
    match run.session.request.parts.shard {
        _ if run.session.request.frames.is_walkthrough() => run.frames(oidn.as_ref()),
        None => run.whole(oidn.as_ref()),
        Some(shard) => run.share(shard),
    }
}

/// Loads and builds the scene of `request`, to be denoised by `oidn`.
pub(super) fn open(
    (request, lights): (RenderRequest, Option<LightsFile>),
    oidn: Option<&Oidn>,
    display: DisplayArgs,
) -> Result<Session, Failure> {
    if let Some(oidn) = oidn.filter(|_| display.verbose) {
        print_message(format_args!(
            "denoiser: Open Image Denoise {} ({})",
            oidn.version(),
            oidn.file().display()
        ));
    }
    let (pool, stats) = (thread_pool(request.run.threads())?, Stats::default());
    let file = load(&request, &pool, &stats, display)?;
    let scene = build_scene(&request, file.desc, &pool, &stats)?;
    Ok(Session {
        request,
        scene: Arc::new(scene),
        digest: file.digest,
        scene_digest: file.scene_digest,
        lights,
        warnings: file.warnings,
        oidn: oidn.map(Oidn::version),
        pool,
        stats,
        choice: OnceLock::new(),
        guided: OnceLock::new(),
    })
}

/// Loads the scene of `request`, and prints its warnings.
fn load(
    request: &RenderRequest,
    pool: &ThreadPool,
    stats: &Stats,
    display: DisplayArgs,
) -> Result<SceneFile, Failure> {
    if display.verbose {
        print_message(format_args!("loading {}", shown_path(&request.scene)));
    }
    let file = SceneFile::load(request, &request.load_options(), pool, stats)?;
    file.check_outputs(request)?;
    if !display.quiet || request.run.strict {
        print_warnings(&file.warnings);
    }
    if let Some(warning) = request.lost_layers().filter(|_| !display.quiet) {
        print_warnings(&[warning]);
    }
    if request.run.strict && !file.warnings.is_empty() {
        return Err(Failure::Strict(file.warnings.len()));
    }
    Ok(file)
}

/// A render of a loaded scene.
struct Run<'r> {
    args: &'r RenderArgs,
    session: Session,
    interrupt: &'r Interrupt,
    console: Console,
}

impl Run<'_> {
    /// Renders an image, and denoises it if that is asked for.
    fn whole(&self, oidn: Option<&Oidn>) -> Result<u8, Failure> {
        let (session, interrupt, display) = (&self.session, self.interrupt, self.args.display);
        let (pool, stats) = (&session.pool, &session.stats);
        self.choose(oidn)?;
        let lights = ShadingLights::of(session, interrupt)?;
        if lights.are_interrupted() {
            return self.interrupted_lights();
        }
        let mut preview = RenderPreview::start(self.args, session, &self.console);
        let beside = preview.memory(&session.job());
        let prepared = Prepared::new(session, oidn, lights.kept(), beside, interrupt)?;
        let on_interrupt = "the image of the complete passes will be written";
        let goal = ProgressGoal {
            elapsed_before: prepared.elapsed_before(),
            ..ProgressGoal::new(prepared.job.budget, on_interrupt, display)
        };
        let rendered = progress::show(goal, stats, interrupt.cancel(), &self.console, |observer| {
            prepared.render(&self.console, &mut preview.beside(observer))
        });
        let denoised = rendered.denoise();
        denoised.warn_if_interrupted();
        let RenderedFilm {
            job,
            outcome,
            checkpoint,
            ..
        } = rendered;
        pool.install(|| preview.finish(&outcome, denoised.picture.as_ref(), stats));
        self.warn_of_samples();

        let film = &outcome.film;
        let bars = error_bars(film, denoised.picture.as_ref());
        let report = RenderReport {
            error: bars.as_ref().map(|bars| bars.stated),
            ..session.report(&job, film.passes())
        };
        let facts = session.facts(film, &job, &report);
        let source = PictureSource {
            film,
            denoised: denoised.picture.as_ref(),
            bars: bars.as_deref(),
            facts: &facts,
        };
        session.stats.time("write", || {
            source.write(
                &session.request.outputs,
                &session.request.picture.file,
                interrupt,
            )
        })?;
        finish(&report, display)?;
        preview.close();
        match checkpoint.err().map(Failure::from).or(denoised.failure) {
            Some(failure) => Err(failure),
            None => self.exit_code(),
        }
    }

    /// Makes the choice of a method that is chosen, and prints it.
    fn choose(&self, oidn: Option<&Oidn>) -> Result<(), Failure> {
        choose(&self.session, oidn)?;
        if !self.args.display.quiet {
            print_choice(&self.session);
        }
        Ok(())
    }

    /// Ends a render that was interrupted before all lights were made.
    fn interrupted_lights(&self) -> Result<u8, Failure> {
        print_message("interrupted: neither lights nor a picture are written");
        self.exit_code()
    }

    /// Prints what is wrong with the samples.
    fn warn_of_samples(&self) {
        if !self.args.display.quiet {
            print_warnings(&self.session.sample_warnings());
        }
    }

    fn exit_code(&self) -> Result<u8, Failure> {
        let warnings = self.session.all_warnings().len();
        match self.interrupt.exit_code() {
            Some(code) => Ok(code),
            None if self.session.request.run.strict && warnings > 0 => {
                Err(Failure::Strict(warnings))
            }
            None => Ok(DONE),
        }
    }
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
        report.print_error();
        for path in outputs {
            print_message(format_args!("wrote {}", shown_path(path)));
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
    if request.parts.shard.is_some() {
        print_message(
            "next: manylight merge PART... -o image.exr   (with the parts of all shares)",
        );
        return;
    }
    // A path tracer shows more light than these methods: its picture is no reference for them.
    if ["aov", "direct"].contains(&request.paths.method.name) {
        return;
    }
    let exr = (request.outputs.iter())
        .find(|path| ImageFormat::from_path(path).is_ok_and(|format| format == ImageFormat::Exr));
    match exr {
        Some(image) if request.paths.method.name != "path" => {
            print_message(format_args!(
                "next: {}\n      manylight compare {} reference.exr",
                reference_command(request),
                shown_path(image)
            ));
        }
        Some(image) => print_message(format_args!(
            "next: manylight compare IMAGE.exr {}",
            shown_path(image)
        )),
        None => print_message(format_args!(
            "next: manylight render {} -o image.exr   (all layers, for `manylight compare`)",
            shown_path(&request.scene)
        )),
    }
}
