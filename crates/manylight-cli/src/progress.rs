//! How far a render has come, shown on standard error while it runs.
//!
//! The renderer only counts ([`Stats`]); a thread of its own looks at the counts a few times a second and draws.

use crate::args::{DisplayArgs, ProgressKind};
use crate::output::{human_time, print_message};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manylight::film::Film;
use manylight::render::{Budget, Observer, Stats};
use serde_json::json;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between two looks at the counts.
const TICK: Duration = Duration::from_millis(100);

/// Time between two lines where there is no bar.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Steps of the bar.
const BAR_STEPS: u64 = 10_000;

/// What is being rendered, for displays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// When it ends.
    pub(crate) budget: Budget,
    /// How it is shown.
    pub(crate) kind: ProgressKind,
}

impl Goal {
    /// Resolves `auto` for this terminal.
    pub(crate) fn new(budget: Budget, display: DisplayArgs) -> Self {
        let kind = match display.progress {
            ProgressKind::Auto if display.quiet => ProgressKind::None,
            ProgressKind::Auto if draws_bars() => ProgressKind::Bar,
            ProgressKind::Auto => ProgressKind::Plain,
            kind => kind,
        };
        Goal { budget, kind }
    }
}

fn draws_bars() -> bool {
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Runs `work` while its progress is shown. `work` gets the observer to hand to the renderer.
pub(crate) fn show<T: Send>(
    goal: Goal,
    stats: &Stats,
    cancel: &AtomicBool,
    work: impl FnOnce(&mut (dyn Observer + Send)) -> T,
) -> T {
    let error = AtomicU32::new(f32::INFINITY.to_bits());
    let (done, until_done) = channel::<()>();
    std::thread::scope(|scope| {
        let watch = Watch {
            goal,
            stats,
            cancel,
            error: &error,
            start: Instant::now(),
        };
        if goal.kind != ProgressKind::None {
            scope.spawn(move || watch.run(until_done));
        }
        let result = work(&mut ErrorEstimate {
            goal,
            error: &error,
        });
        drop(done);
        result
    })
}

/// Keeps the error estimate of the last pass for the display.
struct ErrorEstimate<'a> {
    goal: Goal,
    error: &'a AtomicU32,
}

impl Observer for ErrorEstimate<'_> {
    fn pass_done(&mut self, film: &Film, _stats: &Stats, _elapsed: Duration) -> ControlFlow<()> {
        // The estimate costs a look at every pixel: not for nothing.
        if self.goal.kind != ProgressKind::None {
            self.error
                .store(film.relative_error().to_bits(), Ordering::Relaxed);
        }
        ControlFlow::Continue(())
    }
}

/// The counts at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Snapshot {
    passes: u64,
    tiles_done: u64,
    tiles: u64,
    elapsed: f64,
    error: f32,
    budget: Budget,
}

impl Snapshot {
    /// Passes, with the part of the current one that is done. The count of tiles stays full until the next pass is
    /// shaded, so a full count is none.
    fn fractional_passes(&self) -> f64 {
        let tiles = self.tiles.max(1);
        self.passes as f64 + (self.tiles_done % tiles) as f64 / tiles as f64
    }

    /// How much of the budget is spent, from 0 to 1; `None` while only an error bound ends the render.
    fn fraction(&self) -> Option<f64> {
        let by_passes = self
            .budget
            .passes
            .map(|n| self.fractional_passes() / f64::from(n));
        let by_time = self
            .budget
            .time
            .map(|t| self.elapsed / t.as_secs_f64().max(1e-3));
        let spent = [by_passes, by_time]
            .into_iter()
            .flatten()
            .reduce(f64::max)?;
        Some(spent.clamp(0.0, 1.0))
    }

    /// Seconds to go if all goes on as before; `None` while nothing is known.
    fn remaining(&self) -> Option<f64> {
        let fraction = self.fraction()?;
        (fraction > 0.0).then(|| self.elapsed * (1.0 - fraction) / fraction)
    }

    /// `pass 3/16  tiles 120/3600  12.1 s  ETA 52.0 s  error 4.1 %`
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
            parts.push(format!("error {:.1} %", f64::from(self.error) * 100.0));
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

/// What the drawing thread looks at.
struct Watch<'a> {
    goal: Goal,
    stats: &'a Stats,
    cancel: &'a AtomicBool,
    error: &'a AtomicU32,
    start: Instant,
}

impl Watch<'_> {
    fn snapshot(&self) -> Snapshot {
        Snapshot {
            passes: Stats::get(&self.stats.passes),
            tiles_done: Stats::get(&self.stats.tiles_done),
            tiles: Stats::get(&self.stats.tiles),
            elapsed: self.start.elapsed().as_secs_f64(),
            error: f32::from_bits(self.error.load(Ordering::Relaxed)),
            budget: self.goal.budget,
        }
    }

    fn run(&self, until_done: Receiver<()>) {
        let mut display = Display::new(self.goal.kind, self.start);
        let mut told = false;
        while until_done.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
            if !told && self.cancel.load(Ordering::Relaxed) {
                told = true;
                display.say(
                    "interrupted: the image is written at the end of a pass; interrupt again to quit at once",
                );
            }
            display.update(&self.snapshot());
        }
        display.finish();
    }
}

/// A bar or lines.
enum Display {
    Bar(ProgressBar),
    Lines { kind: ProgressKind, last: Instant },
}

impl Display {
    fn new(kind: ProgressKind, now: Instant) -> Self {
        if kind != ProgressKind::Bar {
            return Display::Lines { kind, last: now };
        }
        let style =
            ProgressStyle::with_template("[{wide_bar}] {msg}").map(|s| s.progress_chars("=> "));
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
        Display::Bar(bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
    }

    fn update(&mut self, snapshot: &Snapshot) {
        match self {
            Display::Bar(bar) => {
                let fraction = snapshot.fraction().unwrap_or(0.0);
                bar.set_position((fraction * BAR_STEPS as f64) as u64);
                bar.set_message(snapshot.line());
            }
            Display::Lines { kind, last } if last.elapsed() >= LINE_INTERVAL => {
                *last = Instant::now();
                match kind {
                    ProgressKind::Json => print_message(snapshot.json()),
                    _ => print_message(snapshot.line()),
                }
            }
            Display::Lines { .. } => {}
        }
    }

    fn say(&self, message: &str) {
        match self {
            Display::Bar(bar) => bar.suspend(|| print_message(message)),
            Display::Lines {
                kind: ProgressKind::Json,
                ..
            } => {
                print_message(json!({"event": "message", "message": message}));
            }
            Display::Lines { .. } => print_message(message),
        }
    }

    fn finish(&self) {
        if let Display::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(budget: Budget) -> Snapshot {
        Snapshot {
            passes: 3,
            tiles_done: 50,
            tiles: 100,
            elapsed: 7.0,
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
        let both = Budget {
            time: Some(Duration::from_secs(10)),
            ..passes
        };
        assert_eq!(snapshot(both).fraction(), Some(0.7));
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
            "pass 4/7  tiles 50/100  7.00 s  ETA 7.00 s  error 4.1 %"
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
            let goal = Goal { budget, kind };
            let result = show(goal, &Stats::default(), &AtomicBool::new(false), |_| 42);
            assert_eq!(result, 42);
        }
    }
}
