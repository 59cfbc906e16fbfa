//! The pass loop: passes are rendered until the budget is spent.

use crate::emitters::EmissionGuide;
use crate::film::Film;
use crate::integrators::{ExtraLayers, Method, MethodKind, PassContext, Renderer};
use crate::sampling::Pass;
use crate::scene::Scene;
use crate::stats::Stats;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Least number of passes after which [`Film::relative_error`] may end a render: a variance estimated from fewer is too noisy.
const MIN_PASSES_FOR_ERROR: u32 = 4;

/// The end of a render: at the first limit that is reached. At least one pass is always made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Number of passes; for path tracing, samples per pixel.
    pub passes: Option<u32>,
    /// The render ends after the pass that ends nearest to this time.
    pub time: Option<Duration>,
    /// The render ends when [`Film::relative_error`] is at most this.
    pub relative_error: Option<f32>,
}

/// Everything that influences the image.
#[derive(Clone, Debug)]
pub struct RenderJob<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// The method.
    pub method: Method,
    /// The end of the render.
    pub budget: Budget,
    /// The same seed gives the same bits, for any number of threads.
    pub seed: u64,
}

/// Is called after every complete pass. `()` is an observer that does nothing.
pub trait Observer {
    /// `Break` ends the render after this pass.
    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()>;
}

impl Observer for () {
    fn pass_done(&mut self, _: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The reason why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The budget was spent.
    Budget,
    /// `cancel` became true, or the observer ended the render.
    Cancelled,
}

/// The result of a render.
#[derive(Debug)]
pub struct Outcome {
    /// At least one complete pass.
    pub film: Film,
    /// The reason why it ended.
    pub stop: Stop,
}

/// Renders `scene` within its own path limits and returns the film. [`render()`] adds cancellation, counters and an observer.
pub fn render_film(scene: &Scene, kind: MethodKind, budget: Budget, seed: u64) -> Film {
    let job = RenderJob {
        scene,
        method: Method {
            kind,
            limits: scene.limits,
            extra: ExtraLayers::default(),
        },
        budget,
        seed,
    };
    let never = AtomicBool::new(false);
    render(&job, &Stats::default(), &never, &mut ()).film
}

/// Renders `job` on the current `rayon` pool. `cancel` may become true at any time: the unfinished pass is dropped then, unless
/// it is the first. Other threads may read `stats` meanwhile.
pub fn render(
    job: &RenderJob,
    stats: &Stats,
    cancel: &AtomicBool,
    observer: &mut dyn Observer,
) -> Outcome {
    let start = Instant::now();
    let film = job.scene.sensor.desc().film.clone();
    let id_layers = job.method.extra.id_layers();
    let mut film = Film::with_ids(film, &job.method.layers(), &id_layers);
    let mut renderer = Renderer::new(job.scene, job.method.clone());
    let never = AtomicBool::new(false);
    let guide = if job.method.emits_photons() {
        stats.time("photons", || job.scene.emission_guide())
    } else {
        EmissionGuide::default()
    };
    let stop = loop {
        let index = film.passes();
        let cancel_pass = if index == 0 { &never } else { cancel };
        let run = PassContext {
            pass: Pass {
                seed: job.seed,
                index,
            },
            guide: &guide,
            stats,
            cancel: cancel_pass,
        };
        if !renderer.render_pass(&run, &mut film) {
            break Stop::Cancelled;
        }
        Stats::count(&stats.passes, 1);
        let ended = observer.pass_done(&film, stats, start.elapsed()).is_break();
        if ended || cancel.load(Ordering::Relaxed) {
            break Stop::Cancelled;
        }
        if job.budget.is_spent(&film, start.elapsed()) {
            break Stop::Budget;
        }
    };
    film.begin_batch();
    Outcome { film, stop }
}

impl Budget {
    /// A number of passes.
    pub fn passes(count: u32) -> Self {
        Budget {
            passes: Some(count),
            ..Budget::default()
        }
    }

    /// A time.
    pub fn time(time: Duration) -> Self {
        Budget {
            time: Some(time),
            ..Budget::default()
        }
    }

    fn is_spent(&self, film: &Film, elapsed: Duration) -> bool {
        let passes = film.passes();
        self.passes.is_some_and(|limit| passes >= limit)
            // Another pass would end farther beyond the limit than this one ended before it.
            || self.time.is_some_and(|limit| elapsed + elapsed / (2 * passes) >= limit)
            || self.relative_error.is_some_and(|limit| passes >= MIN_PASSES_FOR_ERROR && film.relative_error() <= limit)
    }
}
