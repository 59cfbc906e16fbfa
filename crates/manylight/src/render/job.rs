//! The pass loop: render passes until the budget is spent.

use super::Stats;
use crate::film::Film;
use crate::integrators::Method;
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

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

/// Renders `job`. `cancel` may turn true at any time: then the pass under way is dropped (the first pass is finished).
/// `stats` may be read by other threads meanwhile. Runs on the current `rayon` pool.
pub fn render(_job: &RenderJob, _stats: &Stats, _cancel: &AtomicBool, _observer: &mut dyn Observer) -> Outcome {
    todo!()
}
