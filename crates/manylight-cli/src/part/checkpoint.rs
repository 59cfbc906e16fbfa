//! `--checkpoint` and `--resume`: the state of a render in a file.

use super::identity::check_identity;
use super::run_state::RunState;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::Console;
use crate::request::RenderRequest;
use crate::session::Session;
use manylight::film::Film;
use manylight::film::arrays::arrays_of_sums;
use manylight::render::{Budget, Observer, Outcome, RenderJob, Stats, resume};
use manylight_io::FileError;
use manylight_io::part::{PartFile, PartHeader, write_part};
use serde_json::{Map, Value, json};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// Prefix of the arrays of completed blocks.
const COMPLETED: &str = "completed.";
/// Prefix of the arrays of the current block.
const CURRENT: &str = "current.";

/// An observer that writes checkpoints and calls another observer.
struct Checkpoints<'a> {
    path: &'a Path,
    /// Time between two checkpoints.
    interval: Duration,
    /// What the checkpoint must agree with to be continued.
    identity: &'a Map<String, Value>,
    interrupt: &'a Interrupt,
    console: &'a Console,
    /// When the last checkpoint was written.
    last: Instant,
    /// Why the last one was not written.
    failure: Option<FileError>,
    observer: &'a mut dyn Observer,
}

impl Checkpoints<'_> {
    fn write(&mut self, film: &Film, stats: &Stats, elapsed: Duration) {
        let written = stats.time("checkpoint", || {
            let _complete_file = self.interrupt.writing();
            write(
                self.path,
                self.identity,
                film,
                &RunState::new(stats, elapsed),
            )
        });
        self.last = Instant::now();
        self.failure = written.err();
    }
}

impl Observer for Checkpoints<'_> {
    fn begins(&mut self, budget: &Budget) {
        self.observer.begins(budget);
    }

    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()> {
        let flow = self.observer.pass_done(film, stats, elapsed);
        if self.last.elapsed() >= self.interval {
            self.write(film, stats, elapsed);
            // A full disk may have room again later: the render goes on.
            if let Some(failure) = &self.failure {
                self.console.print(format_args!("warning: {failure}"));
            }
        }
        flow
    }

    fn error(&mut self, film: &Film) -> Option<f32> {
        self.observer.error(film)
    }

    fn ended(&mut self, film: &Film, stats: &Stats, elapsed: Duration) {
        self.observer.ended(film, stats, elapsed);
        self.write(film, stats, elapsed);
    }
}

fn write(
    path: &Path,
    identity: &Map<String, Value>,
    film: &Film,
    state: &RunState,
) -> Result<(), FileError> {
    let header = PartHeader::new(film, identity.clone(), json!(state), Value::Null);
    let completed = film
        .completed()
        .map(|sums| (COMPLETED.to_owned(), arrays_of_sums(film, sums)));
    let current = (CURRENT.to_owned(), arrays_of_sums(film, film.current()));
    let groups: Vec<_> = completed.into_iter().chain([current]).collect();
    write_part(path, &header, &groups)
}

/// The checkpoint that `request` asks to continue from; `None` to start from the beginning.
///
/// # Errors
/// The file cannot be read, or is no checkpoint.
pub(crate) fn open_checkpoint(request: &RenderRequest) -> Result<Option<PartFile>, Failure> {
    let Some(path) = &request.parts.resume else {
        return Ok(None);
    };
    let is_own = request.parts.checkpoint.as_ref() == Some(path);
    if is_own && !path.exists() {
        return Ok(None);
    }
    let part = PartFile::open(path)?;
    check_kind(&part)?;
    Ok(Some(part))
}

/// What a render continues with.
pub(crate) struct Resumed {
    /// The film with its passes.
    pub(crate) film: Film,
    /// Time and counts of earlier runs.
    pub(crate) state: RunState,
}

impl Resumed {
    /// Nothing: a render from its beginning.
    pub(crate) fn nothing(job: &RenderJob) -> Self {
        Resumed {
            film: job.film(0),
            state: RunState::default(),
        }
    }

    /// What `request` asks to continue with.
    ///
    /// # Errors
    /// The checkpoint cannot be read, is damaged, or is one of another render, or the render is
    /// complete.
    pub(crate) fn load(
        request: &RenderRequest,
        job: &RenderJob,
        identity: &Map<String, Value>,
    ) -> Result<Self, Failure> {
        let Some(part) = open_checkpoint(request)? else {
            return Ok(Resumed::nothing(job));
        };
        check_identity(&part, identity, "this command")?;
        part.verify()?;
        let film = read_film(&part, job)?;
        let state = serde_json::from_value(part.header().state.clone()).map_err(|error| {
            FileError::malformed(part.path(), format!("the header is damaged: {error}"))
        })?;
        let asked = job.budget.passes;
        if asked.is_some_and(|passes| passes < film.passes()) {
            return Err(Failure::usage(
                format!(
                    "{} has {} passes already",
                    part.path().display(),
                    film.passes()
                ),
                "ask for as many --passes or more: they count from the beginning of the render",
            ));
        }
        Ok(Resumed { film, state })
    }

    /// Renders the passes of `job` that follow, and keeps checkpoints if `session` asks for them.
    /// Also says whether the last one was written.
    pub(crate) fn render(
        self,
        session: &Session,
        job: &RenderJob,
        identity: &Map<String, Value>,
        interrupt: &Interrupt,
        console: &Console,
        observer: &mut (dyn Observer + Send),
    ) -> (Outcome, Result<(), FileError>) {
        let (pool, stats, cancel) = (&session.pool, &session.stats, interrupt.cancel());
        let (film, elapsed) = (self.film, self.state.elapsed());
        let parts = &session.request.parts;
        let Some(path) = &parts.checkpoint else {
            let outcome = pool.install(|| resume(job, film, elapsed, stats, cancel, observer));
            return (outcome, Ok(()));
        };
        pool.install(|| {
            let mut checkpoints = Checkpoints {
                path,
                interval: parts.checkpoint_every,
                identity,
                interrupt,
                console,
                last: Instant::now(),
                failure: None,
                observer,
            };
            let outcome = resume(job, film, elapsed, stats, cancel, &mut checkpoints);
            (outcome, checkpoints.failure.map_or(Ok(()), Err))
        })
    }
}

/// Refuses a share of a render.
fn check_kind(part: &PartFile) -> Result<(), FileError> {
    if has_group(part, CURRENT) {
        return Ok(());
    }
    let message =
        "found a share of a render, expected a checkpoint; `manylight merge` merges shares";
    Err(FileError::malformed(part.path(), message))
}

fn has_group(part: &PartFile, prefix: &str) -> bool {
    part.groups().iter().any(|group| group == prefix)
}

/// The film of a checkpoint.
fn read_film(part: &PartFile, job: &RenderJob) -> Result<Film, FileError> {
    let mut film = job.film(0);
    let completed = has_group(part, COMPLETED)
        .then(|| part.sums(COMPLETED, &film))
        .transpose()?;
    let current = part.sums(CURRENT, &film)?;
    let before = completed.as_ref().map_or(0..0, |sums| sums.passes());
    let block = job.block.get();
    let are_whole = before.start == 0
        && before.end == current.passes().start
        && before.end.is_multiple_of(block);
    if !are_whole || current.passes().len() > block as usize {
        return Err(FileError::malformed(
            part.path(),
            "its blocks do not follow each other: the file is damaged",
        ));
    }
    film.restore(completed, current);
    Ok(film)
}
