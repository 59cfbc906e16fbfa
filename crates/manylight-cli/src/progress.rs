//! Display of the progress of a render on standard error.
//!
//! The renderer only counts ([`Stats`]). A separate thread reads the counts several times a second
//! and displays them.

use crate::args::{DisplayArgs, ProgressKind};
use crate::output::{Console, human_time, print_message};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manylight::film::{ErrorBars, Film};
use manylight::render::{Budget, Observer, Stats};
use serde_json::json;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between two readings of the counts: ten pictures of the bar per second.
const TICK: Duration = Duration::from_millis(100);

/// Time between two lines of a display without a bar.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Shortest time between two error estimates, which read all pixels.
const ESTIMATE_INTERVAL: Duration = Duration::from_secs(1);

/// Shortest time between two error estimates, in units of the time that one takes: 2 % of a render.
const ESTIMATE_REST: u32 = 50;

/// Number of steps of the bar.
const BAR_STEPS: u64 = 10_000;

/// Limits of the render, and the kind of display.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgressGoal {
    /// Limits of the render.
    pub(crate) budget: Budget,
    /// Passes that were counted before the first one of the render: those of other frames.
    pub(crate) before: u64,
    /// Time of earlier runs that the budget counts.
    pub(crate) elapsed_before: Duration,
    /// What is written after an interrupt.
    pub(crate) on_interrupt: &'static str,
    /// Kind of display.
    pub(crate) kind: ProgressKind,
}

impl ProgressGoal {
    /// Resolves [`ProgressKind::Auto`] for this terminal.
    pub(crate) fn new(budget: Budget, on_interrupt: &'static str, display: DisplayArgs) -> Self {
        let kind = match display.progress {
            ProgressKind::Auto if display.quiet => ProgressKind::None,
            ProgressKind::Auto if draws_bars() => ProgressKind::Bar,
            ProgressKind::Auto => ProgressKind::Plain,
            kind => kind,
        };
        ProgressGoal {
            budget,
            before: 0,
            elapsed_before: Duration::ZERO,
            on_interrupt,
            kind,
        }
    }
}

fn draws_bars() -> bool {
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Runs `work` and displays its progress. `work` passes the observer to the renderer. Other threads
/// print by `console` meanwhile.
pub(crate) fn show<T: Send>(
    goal: ProgressGoal,
    stats: &Stats,
    cancel: &AtomicBool,
    console: &Console,
    work: impl FnOnce(&mut (dyn Observer + Send)) -> T,
) -> T {
    let error = AtomicU32::new(f32::INFINITY.to_bits());
    let (done, until_done) = channel::<()>();
    std::thread::scope(|scope| {
        let watch = Watch {
            goal,
            stats,
            cancel,
            console,
            error: &error,
            start: Instant::now(),
            passes_at_start: Stats::get(&stats.passes),
        };
        if goal.kind != ProgressKind::None {
            scope.spawn(move || watch.run(until_done));
        }
        let mut estimate = ErrorEstimate {
            goal,
            error: &error,
            next: None,
        };
        let result = work(&mut estimate);
        drop(done);
        result
    })
}

/// Observer that estimates the error of the image for the display.
struct ErrorEstimate<'a> {
    goal: ProgressGoal,
    error: &'a AtomicU32,
    /// When the next estimate is due; `None`: at once.
    next: Option<Instant>,
}

impl Observer for ErrorEstimate<'_> {
    fn pass_done(&mut self, film: &Film, _stats: &Stats, _elapsed: Duration) -> ControlFlow<()> {
        let start = Instant::now();
        let due = self.next.is_none_or(|next| start >= next);
        if self.goal.kind != ProgressKind::None && due {
            let error = ErrorBars::of_film(film).map_or(f32::INFINITY, |bars| bars.stated.at_most);
            self.error.store(error.to_bits(), Ordering::Relaxed);
            let rest = ESTIMATE_INTERVAL.max(ESTIMATE_REST * start.elapsed());
            self.next = Some(Instant::now() + rest);
        }
        ControlFlow::Continue(())
    }
}

/// The counts at one point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Snapshot {
    passes: u64,
    /// Passes of a checkpoint, which are not part of the elapsed time.
    resumed: u64,
    tiles_done: u64,
    tiles: u64,
    /// Seconds since the start of this run.
    elapsed: f64,
    /// Seconds of earlier runs that the budget counts.
    elapsed_before: f64,
    error: f32,
    budget: Budget,
}

impl Snapshot {
    /// Finished passes plus the finished fraction of the current one. After a pass, the count of
    /// tiles stays at its maximum until the next pass is shaded; the maximum therefore counts as
    /// zero.
    fn fractional_passes(&self) -> f64 {
        let tiles = self.tiles.max(1);
        self.passes as f64 + (self.tiles_done % tiles) as f64 / tiles as f64
    }

    /// Used fraction of the budget, in [0, 1]; `None` if only an error bound ends the render.
    fn fraction(&self) -> Option<f64> {
        self.fraction_after(0, 0.0)
    }

    /// [`Snapshot::fraction`] of what the budget has beyond the first `resumed` passes and
    /// `seconds`.
    fn fraction_after(&self, resumed: u64, seconds: f64) -> Option<f64> {
        let resumed = resumed as f64;
        let by_passes = self
            .budget
            .passes
            .map(|n| (self.fractional_passes() - resumed) / (f64::from(n) - resumed).max(1.0));
        let by_time = self.budget.time.map(|t| {
            let elapsed = self.elapsed_before + self.elapsed;
            (elapsed - seconds) / (t.as_secs_f64() - seconds).max(1e-3)
        });
        let spent = [by_passes, by_time]
            .into_iter()
            .flatten()
            .reduce(f64::max)?;
        Some(spent.clamp(0.0, 1.0))
    }

    /// Estimated remaining time in seconds, in proportion to the elapsed time; `None` if it is not
    /// known.
    fn remaining(&self) -> Option<f64> {
        let fraction = self.fraction_after(self.resumed, self.elapsed_before)?;
        (fraction > 0.0).then(|| self.elapsed * (1.0 - fraction) / fraction)
    }

    /// `pass 3/16  tiles 120/3600  12.1 s  ETA 52.0 s  error at most 4.1 %`
    fn line(&self) -> String {
        let current =
            self.passes + u64::from(self.budget.passes.is_none_or(|n| self.passes < n.into()));
        let passes = match self.budget.passes {
            Some(n) => format!("pass {current}/{n}"),
            None => format!("pass {current}"),
        };
        let mut parts = vec![passes];
        if self.tiles > 0 {
            parts.push(format!(
                "tiles {}/{}",
                self.tiles_done.min(self.tiles),
                self.tiles
            ));
        }
        parts.push(human_time(self.elapsed));
        parts.extend(
            self.remaining()
                .map(|eta| format!("ETA {}", human_time(eta))),
        );
        if self.error.is_finite() {
            parts.push(format!(
                "error at most {:.1} %",
                f64::from(self.error) * 100.0
            ));
        }
        parts.join("  ")
    }

    fn json(&self) -> serde_json::Value {
        json!({
            "event": "progress",
            "passes_done": self.passes,
            "passes": self.budget.passes,
            "tiles_done": self.tiles_done,
            "tiles": self.tiles,
            "elapsed": self.elapsed,
            "remaining": self.remaining(),
            "fraction": self.fraction(),
            "relative_error": self.error.is_finite().then_some(self.error),
        })
    }
}

/// The state that the display thread reads.
struct Watch<'a> {
    goal: ProgressGoal,
    stats: &'a Stats,
    cancel: &'a AtomicBool,
    console: &'a Console,
    error: &'a AtomicU32,
    start: Instant,
    passes_at_start: u64,
}

impl Watch<'_> {
    fn snapshot(&self) -> Snapshot {
        Snapshot {
            passes: Stats::get(&self.stats.passes) - self.goal.before,
            resumed: self.passes_at_start - self.goal.before,
            tiles_done: Stats::get(&self.stats.tiles_done),
            tiles: Stats::get(&self.stats.tiles),
            elapsed: self.start.elapsed().as_secs_f64(),
            elapsed_before: self.goal.elapsed_before.as_secs_f64(),
            error: f32::from_bits(self.error.load(Ordering::Relaxed)),
            budget: self.goal.budget,
        }
    }

    fn run(&self, until_done: Receiver<()>) {
        let mut display = ProgressDisplay::new(self.goal.kind, self.start);
        self.console.set_bar(display.bar());
        let mut reported = false;
        while until_done.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
            if !reported && self.cancel.load(Ordering::Relaxed) {
                reported = true;
                display.message(&format!(
                    "interrupted: {}; interrupt again to quit at once",
                    self.goal.on_interrupt
                ));
            }
            display.update(&self.snapshot());
        }
        self.console.set_bar(None);
        display.finish(&self.snapshot());
    }
}

/// A display: a bar or lines.
enum ProgressDisplay {
    Bar(ProgressBar),
    Lines { kind: ProgressKind, last: Instant },
}

impl ProgressDisplay {
    fn new(kind: ProgressKind, now: Instant) -> Self {
        if kind != ProgressKind::Bar {
            return ProgressDisplay::Lines { kind, last: now };
        }
        let style =
            ProgressStyle::with_template("[{wide_bar}] {msg}").map(|s| s.progress_chars("=> "));
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
        ProgressDisplay::Bar(bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
    }

    /// The bar, if it is one.
    fn bar(&self) -> Option<ProgressBar> {
        match self {
            ProgressDisplay::Bar(bar) => Some(bar.clone()),
            ProgressDisplay::Lines { .. } => None,
        }
    }

    fn update(&mut self, snapshot: &Snapshot) {
        match self {
            ProgressDisplay::Bar(bar) => {
                let fraction = snapshot.fraction().unwrap_or(0.0);
                bar.set_position((fraction * BAR_STEPS as f64) as u64);
                bar.set_message(snapshot.line());
            }
            ProgressDisplay::Lines { kind, last } if last.elapsed() >= LINE_INTERVAL => {
                *last = Instant::now();
                match kind {
                    ProgressKind::Json => print_message(snapshot.json()),
                    _ => print_message(snapshot.line()),
                }
            }
            ProgressDisplay::Lines { .. } => {}
        }
    }

    fn message(&self, message: &str) {
        match self {
            ProgressDisplay::Bar(bar) => bar.suspend(|| print_message(message)),
            ProgressDisplay::Lines {
                kind: ProgressKind::Json,
                ..
            } => {
                print_message(json!({"event": "message", "message": message}));
            }
            ProgressDisplay::Lines { .. } => print_message(message),
        }
    }

    fn finish(&self, snapshot: &Snapshot) {
        match self {
            ProgressDisplay::Bar(bar) => bar.finish_and_clear(),
            ProgressDisplay::Lines {
                kind: ProgressKind::Json,
                ..
            } => print_message(snapshot.json()),
            ProgressDisplay::Lines { .. } => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(budget: Budget) -> Snapshot {
        Snapshot {
            passes: 3,
            resumed: 0,
            tiles_done: 50,
            tiles: 100,
            elapsed: 7.0,
            elapsed_before: 0.0,
            error: 0.041,
            budget,
        }
    }

    #[test]
    fn the_nearer_limit_counts() {
        let passes = Budget {
            passes: Some(7),
            time: None,
            relative_error: None,
        };
        assert_eq!(snapshot(passes).fraction(), Some(0.5));
        assert_eq!(snapshot(passes).remaining(), Some(7.0));
        let resumed = Snapshot {
            resumed: 2,
            ..snapshot(passes)
        };
        let spent = 1.5 / 5.0;
        assert_eq!(resumed.fraction(), Some(0.5));
        assert_eq!(resumed.remaining(), Some(7.0 * (1.0 - spent) / spent));
        let both = Budget {
            time: Some(Duration::from_secs(10)),
            ..passes
        };
        assert_eq!(snapshot(both).fraction(), Some(0.7));
        let time = Budget {
            passes: None,
            time: Some(Duration::from_secs(100)),
            relative_error: None,
        };
        let resumed = Snapshot {
            elapsed_before: 80.0,
            ..snapshot(time)
        };
        assert_eq!(resumed.fraction(), Some(0.87));
        assert_eq!(resumed.remaining(), Some(13.0));
        let error = Budget {
            passes: None,
            time: None,
            relative_error: Some(0.1),
        };
        assert_eq!(
            (snapshot(error).fraction(), snapshot(error).remaining()),
            (None, None)
        );
    }

    #[test]
    fn lines() {
        let passes = Budget {
            passes: Some(7),
            time: None,
            relative_error: None,
        };
        let line = snapshot(passes).line();
        assert_eq!(
            line,
            "pass 4/7  tiles 50/100  7.00 s  ETA 7.00 s  error at most 4.1 %"
        );
        let json = snapshot(passes).json();
        assert_eq!(
            (&json["passes_done"], &json["fraction"]),
            (&json!(3), &json!(0.5))
        );
    }

    #[test]
    fn work_returns_through_every_display() {
        for kind in [
            ProgressKind::None,
            ProgressKind::Plain,
            ProgressKind::Json,
            ProgressKind::Bar,
        ] {
            let budget = Budget {
                passes: Some(1),
                time: None,
                relative_error: None,
            };
            let goal = ProgressGoal {
                budget,
                before: 0,
                elapsed_before: Duration::ZERO,
                on_interrupt: "nothing will be written",
                kind,
            };
            let (stats, never) = (Stats::default(), AtomicBool::new(false));
            let result = show(goal, &stats, &never, &Console::default(), |_| 42);
            assert_eq!(result, 42);
        }
    }
}
