//! A render that is ready to start, and its film.

use crate::denoiser::Denoised;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::memory::{OtherMemory, check_memory, image_memory, sums_of_render};
use crate::output::Console;
use crate::part::Resumed;
use crate::pre_pass::choice_time;
use crate::session::Session;
use crate::target_error::StatingError;
use manylight::film::Film;
use manylight::integrators::{KeptLights, StageMemory};
use manylight::render::{Observer, Outcome, RenderJob};
use manylight_denoise::Oidn;
use manylight_io::FileError;
use serde_json::{Map, Value};
use std::time::Duration;

/// A render that is ready to start.
pub(crate) struct Prepared<'s> {
    pub(crate) job: RenderJob<'s>,
    denoising: Denoising<'s>,
    /// What checkpoints must agree with to be continued.
    identity: Map<String, Value>,
    /// What the render continues with.
    resumed: Resumed,
}

/// The film of a render.
pub(crate) struct RenderedFilm<'s> {
    pub(crate) job: RenderJob<'s>,
    pub(crate) outcome: Outcome,
    /// Whether the last checkpoint was written.
    pub(crate) checkpoint: Result<(), FileError>,
    denoising: Denoising<'s>,
}

/// What the film of a session is denoised with.
struct Denoising<'s> {
    session: &'s Session,
    oidn: Option<&'s Oidn>,
    /// Features that the film lacks.
    features: Option<Film>,
    interrupt: &'s Interrupt,
}

impl<'s> Prepared<'s> {
    /// Prepares the render of `session`, with lights that were made before, to be denoised by
    /// `oidn`, if there is one. `beside` is memory that lasts as long as the render.
    ///
    /// # Errors
    /// The memory limit is too small, or the checkpoint to continue from is not one of this render.
    pub(crate) fn new(
        session: &'s Session,
        oidn: Option<&'s Oidn>,
        lights: Option<&'s KeptLights<'s>>,
        beside: Option<StageMemory>,
        interrupt: &'s Interrupt,
    ) -> Result<Self, Failure> {
        let mut job = RenderJob {
            lights,
            ..session.job()
        };
        let other = OtherMemory {
            sums: sums_of_render(&job),
            beside,
            at_end: Some(image_memory(&session.request, &job)),
        };
        let limit = session.request.memory_limit;
        (session.pool).install(|| check_memory(limit, &job, other))?;
        let identity = session
            .settings(&job)
            .identity(&session.digest, session.digest_of_lights());
        let resumed = Resumed::load(&session.request, &job, &identity)?;
        job.budget.time = (job.budget.time).map(|limit| limit.saturating_sub(choice_time(session)));
        let features = session.features(&mut job, interrupt);
        resumed.state.add_to(&session.stats);
        Ok(Prepared {
            job,
            denoising: Denoising {
                session,
                oidn,
                features,
                interrupt,
            },
            identity,
            resumed,
        })
    }

    /// Time of the runs that it continues.
    pub(crate) fn elapsed_before(&self) -> Duration {
        self.resumed.state.elapsed()
    }

    /// Renders the passes.
    pub(crate) fn render(
        self,
        console: &Console,
        observer: &mut (dyn Observer + Send),
    ) -> RenderedFilm<'s> {
        let Prepared {
            job,
            denoising,
            identity,
            resumed,
        } = self;
        let Denoising {
            session, interrupt, ..
        } = denoising;
        let observer = &mut StatingError {
            session,
            oidn: denoising.oidn,
            features: denoising.features.as_ref(),
            interrupt,
            observer,
        };
        let (outcome, checkpoint) =
            resumed.render(session, &job, &identity, interrupt, console, observer);
        RenderedFilm {
            job,
            outcome,
            checkpoint,
            denoising,
        }
    }
}

impl RenderedFilm<'_> {
    /// The denoised picture, if there is to be one.
    pub(crate) fn denoise(&self) -> Denoised {
        let Denoising {
            session,
            oidn,
            features,
            interrupt,
        } = &self.denoising;
        session.denoise(*oidn, &self.outcome.film, features.as_ref(), interrupt)
    }
}
