//! A render that is ready to start.

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::memory::{OtherMemory, check_memory, image_memory, sums_of_render};
use crate::part::Resumed;
use crate::pre_pass::choice_time;
use crate::session::Session;
use manylight::film::Film;
use manylight::integrators::{KeptLights, StageMemory};
use manylight::render::RenderJob;
use serde_json::{Map, Value};

/// A render that is ready to start.
pub(crate) struct Prepared<'s> {
    pub(crate) job: RenderJob<'s>,
    /// What checkpoints must agree with to be continued.
    pub(crate) identity: Map<String, Value>,
    /// What the render continues with.
    pub(crate) resumed: Resumed,
    /// Features for the denoiser that the film will lack.
    pub(crate) features: Option<Film>,
}

impl<'s> Prepared<'s> {
    /// Prepares the render of `session`, with lights that were made before. `beside` is memory that lasts as long as the render.
    ///
    /// # Errors
    /// The memory limit is too small, or the checkpoint to continue from is not one of this render.
    pub(crate) fn new(
        session: &'s Session,
        lights: Option<&'s KeptLights<'s>>,
        beside: Option<StageMemory>,
        interrupt: &Interrupt,
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
            identity,
            resumed,
            features,
        })
    }
}
