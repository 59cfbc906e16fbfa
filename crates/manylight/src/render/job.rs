//! The pass loop: render passes until the budget is spent.

use crate::film::Film;
use crate::integrators::{Method, PassContext, Renderer};
use crate::sampling::Pass;
use crate::scene::Scene;
use crate::stats::Stats;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Fewer passes than this say too little about the variance to stop by it.
const MIN_PASSES_FOR_ERROR: u32 = 4;

/// When to stop: at the first limit that is reached. At least one pass is always made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Number of passes; for path tracing, samples per pixel.
    pub passes: Option<u32>,
    /// Stop after the pass that ends nearest to this.
    pub time: Option<Duration>,
    /// Stop when [`Film::relative_error`] is below this.
    pub relative_error: Option<f32>,
}

/// Everything that influences the picture.
#[derive(Clone, Debug)]
pub struct RenderJob<'s> {
    /// The world.
    pub scene: &'s Scene,
    /// How to render it.
    pub method: Method,
    /// When to stop.
    pub budget: Budget,
    /// The same seed gives the same bits.
    pub seed: u64,
}

/// Hears of every complete pass.
pub trait Observer {
    /// `Break` ends the render after this pass.
    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()>;
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The budget was spent.
    Budget,
    /// `cancel` turned true or the observer broke off.
    Cancelled,
}

/// What a render made.
#[derive(Debug)]
pub struct Outcome {
    /// At least one complete pass.
    pub film: Film,
    /// Why it ended.
    pub stop: Stop,
}

/// Renders `job`. `cancel` may turn true at any time: then the pass under way is dropped, but the first pass is always
/// finished. `stats` may be read by other threads meanwhile. Runs on the current `rayon` pool.
pub fn render(
    job: &RenderJob,
    stats: &Stats,
    cancel: &AtomicBool,
    observer: &mut dyn Observer,
) -> Outcome {
    let start = Instant::now();
    let mut film = Film::new(job.scene.sensor.desc().film.clone(), &job.method.layers());
    let mut renderer = Renderer::new(job.scene, job.method.clone());
    let never = AtomicBool::new(false);
    let stop = loop {
        let index = film.passes();
        let cancel_pass = if index == 0 { &never } else { cancel };
        let run = PassContext {
            pass: Pass {
                seed: job.seed,
                index,
            },
            stats,
            cancel: cancel_pass,
        };
        if !renderer.render_pass(&run, &mut film) {
            break Stop::Cancelled;
        }
        Stats::count(&stats.passes, 1);
        let broken_off = observer.pass_done(&film, stats, start.elapsed()).is_break();
        if broken_off || cancel.load(Ordering::Relaxed) {
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
    fn is_spent(&self, film: &Film, elapsed: Duration) -> bool {
        let passes = film.passes();
        self.passes.is_some_and(|limit| passes >= limit)
            // Another pass would end farther beyond the limit than this one ended before it.
            || self.time.is_some_and(|limit| elapsed + elapsed / (2 * passes) >= limit)
            || self.relative_error.is_some_and(|limit| passes >= MIN_PASSES_FOR_ERROR && film.relative_error() <= limit)
    }
}
