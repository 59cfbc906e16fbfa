//! The pass loop: passes are rendered until the budget is spent.

use crate::emitters::EmissionGuide;
use crate::film::blocks::{DEFAULT_BLOCK, passes_of_block};
use crate::film::{ErrorBars, Film, PassSums};
use crate::integrators::{ExtraLayers, KeptLights, Method, MethodKind, PassContext, Renderer};
use crate::sampling::{Pass, rng};
use crate::scene::Scene;
use crate::stats::Stats;
use std::borrow::Cow;
use std::num::NonZeroU32;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Tells the seeds of frames from that of a picture.
const FRAMES: u64 = 0xf4a3_e500_5eed;
/// Least number of passes after which an error may end a render: a variance estimated from fewer is
/// too noisy.
const MIN_PASSES_FOR_ERROR: u32 = 4;
/// Passes grow by one in this number until the error is asked for again: a render ends by at most
/// an eighth too late.
const ERROR_STEP: u32 = 8;

/// The end of a render: at the first limit that is reached. At least one pass is always made.
/// Without any limit a render ends only when it is canceled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Number of passes; for path tracing, samples per pixel.
    pub passes: Option<u32>,
    /// The render ends after the pass that ends nearest to this time.
    pub time: Option<Duration>,
    /// The render ends when [`Observer::error`] is at most this.
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
    /// The frame of a walkthrough, among [`Scene::frames`]; `None`: the picture of the sensor. All
    /// frames have the same photons and virtual lights, which [`Walkthrough`] makes once.
    pub frame: Option<u32>,
    /// Virtual lights that were made before, by [`make_lights`]; `None`: they are made pass by
    /// pass.
    pub lights: Option<&'s KeptLights<'s>>,
    /// Passes of a block of sums, a multiple of [`BLOCK_STEP`](crate::film::blocks::BLOCK_STEP).
    /// Another number rounds otherwise.
    pub block: NonZeroU32,
    /// The guide that [`Method::emission_guide`] gives for the scene and the method. If `None`, a
    /// render of photons makes it.
    pub guide: Option<&'s EmissionGuide>,
}

/// Watches a render. `()` is an observer that does nothing.
pub trait Observer {
    /// Is called before the first pass of a render that `budget` ends.
    fn begins(&mut self, _budget: &Budget) {}

    /// Is called after every complete pass. `Break` ends the render after this pass.
    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()>;

    /// Relative error of the picture that `film` becomes, which [`Budget::relative_error`] bounds;
    /// `None` if it is not known, or not due. Is called after every pass if there is such a bound.
    fn error(&mut self, film: &Film) -> Option<f32> {
        let bars = error_is_due(film.passes(), ERROR_STEP).then(|| ErrorBars::of_film(film))?;
        bars.map(|bars| bars.stated.at_most)
    }

    /// Is called when the render ends, with a film that [`resume`] can continue.
    fn ended(&mut self, _film: &Film, _stats: &Stats, _elapsed: Duration) {}
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

/// Renders `scene` within its own path limits and returns the film. [`render()`] adds cancellation,
/// counters and an observer.
///
/// # Panics
/// The settings of a many-light method contradict each other, as for all renders:
/// [`ManyLight::check`](crate::integrators::ManyLight::check).
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
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    };
    let never = AtomicBool::new(false);
    render(&job, &Stats::default(), &never, &mut ()).film
}

/// Renders `job` on the current `rayon` pool. `cancel` may become true at any time: the unfinished
/// pass is dropped then, unless it is the first. Other threads may read `stats` meanwhile.
pub fn render(
    job: &RenderJob,
    stats: &Stats,
    cancel: &AtomicBool,
    observer: &mut dyn Observer,
) -> Outcome {
    resume(job, job.film(0), Duration::ZERO, stats, cancel, observer)
}

/// [`render()`] from a film of `job` that has some passes, after which `elapsed` had passed. The
/// result has the same bits as that of a render without a break.
pub fn resume(
    job: &RenderJob,
    film: Film,
    elapsed: Duration,
    stats: &Stats,
    cancel: &AtomicBool,
    observer: &mut dyn Observer,
) -> Outcome {
    let start = Instant::now();
    let mut passes = Passes::new(job, job.method_of_passes(), stats, 1);
    let elapsed = elapsed + start.elapsed();
    passes.render_to_the_end(job.frame, film, elapsed, cancel, observer)
}

/// Renders the frames of a walkthrough. Photons and virtual lights are made once for all frames, if
/// the number of passes is given; otherwise each frame makes those after its first group of passes
/// anew. A frame has the bits of its render alone.
pub struct Walkthrough<'j, 's>(Passes<'j, 's>);

impl<'j, 's> Walkthrough<'j, 's> {
    /// Before the first frame; the frame of `job` is ignored.
    pub fn new(job: &'j RenderJob<'s>, stats: &'j Stats) -> Self {
        let method = job.method_of_many_passes();
        let kept = method.max_group_count(job.scene, job.budget.passes) as usize;
        Walkthrough(Passes::new(job, method, stats, kept))
    }

    /// Renders frame `index` of [`Scene::frames`], as [`render()`] does.
    ///
    /// # Panics
    /// There is no such frame.
    pub fn render(
        &mut self,
        index: u32,
        cancel: &AtomicBool,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let film = self.0.job.film(0);
        self.0
            .render_to_the_end(Some(index), film, Duration::ZERO, cancel, observer)
    }
}

/// Makes the virtual lights of the passes of `job`, to be kept: [`RenderJob::lights`]. `None` if it
/// was cancelled, or if the method has no virtual lights or passes have no end.
pub fn make_lights<'s>(
    job: &RenderJob<'s>,
    stats: &Stats,
    cancel: &AtomicBool,
) -> Option<KeptLights<'s>> {
    let count = job.budget.passes?;
    let passes = Passes::new(job, job.method_of_many_passes(), stats, 1);
    let pass = Pass {
        seed: job.seed,
        index: 0,
    };
    let run = PassContext {
        light_groups: job.method.extra.light_groups,
        ..PassContext::of_picture(job.scene, pass, &passes.guide, stats, cancel)
    };
    passes.renderer.make_lights(count, &run)
}

/// Renders blocks of passes apart from the others. The last block of the render ends with the
/// budget's passes; other limits are ignored. `None` if it was cancelled. The observer gets the
/// film of each block.
pub fn render_blocks(
    job: &RenderJob,
    blocks: Range<u32>,
    stats: &Stats,
    cancel: &AtomicBool,
    observer: &mut dyn Observer,
) -> Option<Vec<PassSums>> {
    let start = Instant::now();
    let mut passes = Passes::new(job, job.method_of_passes(), stats, 1);
    let last = job.budget.passes.unwrap_or(u32::MAX);
    let rendered = blocks.map(|block| {
        let range = passes_of_block(block, job.block, last);
        let mut film = job.film(range.start);
        while film.next_pass() < range.end {
            if !passes.render_next(job.frame, &mut film, cancel)
                || observer.pass_done(&film, stats, start.elapsed()).is_break()
            {
                return None;
            }
        }
        Some(film.into_block())
    });
    rendered.collect()
}

/// The passes of a job, in any order.
struct Passes<'j, 's> {
    job: &'j RenderJob<'s>,
    renderer: Renderer<'s>,
    guide: Cow<'j, EmissionGuide>,
    stats: &'j Stats,
}

impl<'j, 's> Passes<'j, 's> {
    /// The virtual lights of `kept_groups` groups of passes are kept.
    fn new(job: &'j RenderJob<'s>, method: Method, stats: &'j Stats, kept_groups: usize) -> Self {
        let guide = match (job.guide, job.lights) {
            (Some(guide), _) => Cow::Borrowed(guide),
            (None, Some(_)) => Cow::default(),
            (None, None) => {
                Cow::Owned(stats.time("photons", || job.method.emission_guide(job.scene)))
            }
        };
        Passes {
            job,
            renderer: Renderer::new(job.scene, method, kept_groups).with_lights(job.lights),
            guide,
            stats,
        }
    }

    /// Adds passes to `film` until the budget is spent, or the render is cancelled.
    fn render_to_the_end(
        &mut self,
        frame: Option<u32>,
        mut film: Film,
        elapsed: Duration,
        cancel: &AtomicBool,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let start = Instant::now();
        let elapsed = || elapsed + start.elapsed();
        let never = AtomicBool::new(false);
        observer.begins(&self.job.budget);
        let stop = loop {
            let is_first = film.passes() == 0;
            if !is_first && self.job.budget.is_spent(&film, elapsed(), observer) {
                break Stop::Budget;
            }
            if !self.render_next(frame, &mut film, if is_first { &never } else { cancel }) {
                break Stop::Cancelled;
            }
            let ended = observer.pass_done(&film, self.stats, elapsed()).is_break();
            if ended || cancel.load(Ordering::Relaxed) {
                break Stop::Cancelled;
            }
        };
        observer.ended(&film, self.stats, elapsed());
        film.begin_batch();
        Outcome { film, stop }
    }

    /// Adds the pass that comes next to `film`; `false` if it was cancelled.
    fn render_next(&mut self, frame: Option<u32>, film: &mut Film, cancel: &AtomicBool) -> bool {
        let seed = self.job.seed;
        let pass = Pass {
            seed: frame.map_or(seed, |index| seed_of_frame(seed, index)),
            index: film.next_pass(),
        };
        let run = PassContext {
            camera: self.job.scene.camera(frame),
            pass,
            lights_seed: seed,
            guide: &self.guide,
            stats: self.stats,
            cancel,
            light_groups: film.light_groups(),
        };
        let complete = self.renderer.render_pass(&run, film);
        if complete {
            Stats::count(&self.stats.passes, 1);
        }
        complete
    }
}

/// The seed of what the frames of a walkthrough do not share: noise that neither lasts from frame
/// to frame nor sticks to the screen.
fn seed_of_frame(seed: u64, index: u32) -> u64 {
    rng::mix(seed ^ rng::mix(FRAMES ^ u64::from(index)))
}

impl RenderJob<'_> {
    /// The method of the passes. The lights of a frame of a walkthrough are made for many passes.
    fn method_of_passes(&self) -> Method {
        match (self.frame, self.lights) {
            (None, None) => self.method.clone(),
            _ => self.method_of_many_passes(),
        }
    }

    /// The method for lights that are made for many passes at once, or were made before.
    fn method_of_many_passes(&self) -> Method {
        match self.lights {
            Some(lights) => self.method.with_lights(lights.method()),
            None => self.method.of_frames(self.budget.passes),
        }
    }

    /// A film without passes; `first`, the first pass of a block, comes next.
    pub fn film(&self, first: u32) -> Film {
        let desc = self.scene.sensor.desc().film.clone();
        let id_layers = self.method.extra.id_layers();
        Film::with_blocks(desc, &self.method.layers(), &id_layers, self.block, first)
    }
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

    fn is_spent(&self, film: &Film, elapsed: Duration, observer: &mut dyn Observer) -> bool {
        let passes = film.passes();
        self.passes.is_some_and(|limit| passes >= limit)
            // Another pass would end farther beyond the limit than this one ended before it.
            || self.time.is_some_and(|limit| elapsed + elapsed / (2 * passes) >= limit)
            || self.relative_error.is_some_and(|limit| observer.error(film).is_some_and(|error| error <= limit))
    }
}

/// Whether an error is to be known after this number of passes: after 4, and each time that passes
/// have grown by one in `step`. It depends on nothing else, so that resumed renders end alike.
pub fn error_is_due(passes: u32, step: u32) -> bool {
    let next = |&due: &u32| Some(due + due.div_ceil(step));
    let mut due = std::iter::successors(Some(MIN_PASSES_FOR_ERROR), next);
    due.find(|&due| due >= passes) == Some(passes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_due_more_and_more_rarely() {
        let due = |step| {
            (0..40)
                .filter(|&passes| error_is_due(passes, step))
                .collect::<Vec<_>>()
        };
        assert_eq!(
            due(8),
            [4, 5, 6, 7, 8, 9, 11, 13, 15, 17, 20, 23, 26, 30, 34, 39]
        );
        assert_eq!(due(2), [4, 6, 9, 14, 21, 32]);
    }
}
