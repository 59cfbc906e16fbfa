//! `--frames`, `--cameras`: renders the frames of a walkthrough and writes their image files.

use super::Run;
use crate::args::FrameArgs;
use crate::denoiser::Denoised;
use crate::failure::Failure;
use crate::frame_files::FrameFiles;
use crate::kept_lights::ShadingLights;
use crate::memory::{OtherMemory, check_memory, image_memory, sums_of_render};
use crate::output::{print_data, print_message};
use crate::picture::PictureSource;
use crate::progress::{self, ProgressGoal};
use crate::report::RenderReport;
use crate::request::RenderRequest;
use crate::session::Session;
use crate::stated_error::{error_bars, sentence};
use crate::values::FrameRange;
use manylight::film::Film;
use manylight::render::{RenderJob, Stats, Stop, Walkthrough};
use manylight_denoise::Oidn;
use manylight_io::{check_replaceable, shown_path};
use serde_json::json;
use std::path::PathBuf;

impl Run<'_> {
    /// Renders the frames one by one. An interrupted frame is not written.
    pub(super) fn frames(&self, oidn: Option<&Oidn>) -> Result<u8, Failure> {
        let (session, interrupt, display) = (&self.session, self.interrupt, self.args.display);
        let (request, pool, stats) = (&session.request, &session.pool, &session.stats);
        let frames = frames_to_render(request, session.scene.frames().len() as u32)?;
        for file in frames.iter().flat_map(|&frame| files(request, frame)) {
            check_replaceable(&file)?;
        }
        let lights = ShadingLights::of(session, interrupt)?;
        if lights.are_interrupted() {
            return self.interrupted_lights();
        }
        let job = RenderJob {
            frame: Some(0),
            lights: lights.kept(),
            ..session.job()
        };
        pool.install(|| check_memory_of_frames(request, &job))?;
        let mut walkthrough = pool.install(|| Walkthrough::new(&job, stats));
        let mut written = Vec::new();
        let mut passes = 0;
        for (done, &frame) in frames.iter().enumerate() {
            let index = frame - 1;
            let mut of_frame = RenderJob {
                frame: Some(index),
                ..job.clone()
            };
            let features = session.features(&mut of_frame, interrupt);
            let goal = ProgressGoal {
                before: Stats::get(&stats.passes),
                ..ProgressGoal::new(job.budget, "this frame will not be written", display)
            };
            let outcome =
                progress::show(goal, stats, interrupt.cancel(), &self.console, |observer| {
                    pool.install(|| walkthrough.render(index, interrupt.cancel(), observer))
                });
            if outcome.stop == Stop::Cancelled {
                print_message(format_args!(
                    "interrupted: {done} of {} frames are written; --skip-existing leaves them as they are",
                    frames.len()
                ));
                break;
            }
            let film = &outcome.film;
            let denoised = session.denoise(oidn, film, features.as_ref(), interrupt);
            denoised.warn_if_interrupted();
            passes = film.passes();
            written.extend(self.write_frame(&of_frame, film, denoised)?);
        }
        self.warn_of_samples();
        if display.json {
            let mut report = session.report(&job, passes).to_json();
            report["outputs"] = (written.iter())
                .map(|file| json!(file.display().to_string()))
                .collect();
            print_data(report)?;
        }
        self.exit_code()
    }

    /// Writes the frame of `job`. Returns its files.
    fn write_frame(
        &self,
        job: &RenderJob,
        film: &Film,
        denoised: Denoised,
    ) -> Result<Vec<PathBuf>, Failure> {
        let (session, interrupt) = (&self.session, self.interrupt);
        let frame = job.frame.map_or(1, |index| index + 1);
        let request = of_frame(session, frame);
        let bars = error_bars(film, denoised.picture.as_ref());
        let mut report: RenderReport = session.report(job, film.passes());
        report.settings.request = &request;
        let facts = session.facts(film, job, &report);
        let source = PictureSource {
            film,
            denoised: denoised.picture.as_ref(),
            bars: bars.as_deref(),
            facts: &facts,
        };
        let files = files(&session.request, frame);
        session.stats.time("write", || {
            source.write(&files, &session.request.picture.file, interrupt)
        })?;
        if !self.args.display.quiet {
            if let Some(bars) = &bars {
                let sentence = sentence(&bars.stated, film.passes());
                print_message(format_args!("frame {frame}: {sentence}"));
            }
            for path in &files {
                print_message(format_args!("wrote {}", shown_path(path)));
            }
        }
        denoised.failure.map_or(Ok(files), Err)
    }
}

/// Refuses frames that take more memory than there is: the picture of one frame lies beside the
/// sums of the next.
fn check_memory_of_frames(request: &RenderRequest, job: &RenderJob) -> Result<(), Failure> {
    let other = OtherMemory {
        sums: sums_of_render(job),
        beside: Some(image_memory(request, job)),
        ..OtherMemory::default()
    };
    check_memory(request.memory_limit, job, other)
}

/// The request that repeats a frame.
fn of_frame(session: &Session, frame: u32) -> RenderRequest {
    let range = FrameRange {
        first: frame,
        last: Some(frame),
    };
    RenderRequest {
        frames: FrameArgs {
            frames: Some(range),
            ..session.request.frames.clone()
        },
        ..session.request.clone()
    }
}

/// The frames that are asked for, out of `count`, without those that are to be skipped.
fn frames_to_render(request: &RenderRequest, count: u32) -> Result<Vec<u32>, Failure> {
    let is_kept = |frame: &u32| {
        request.frames.skip_existing && files(request, *frame).iter().all(|file| file.exists())
    };
    let frames = request.frames_of(count)?;
    Ok(frames.filter(|frame| !is_kept(frame)).collect())
}

/// The files of a frame.
fn files(request: &RenderRequest, frame: u32) -> Vec<PathBuf> {
    request
        .outputs
        .iter()
        .map(|path| FrameFiles::of(path).file(frame))
        .collect()
}
