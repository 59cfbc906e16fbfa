//! Time and counts of the runs that have made a part.

use manylight::render::Stats;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;

/// Name of the stage with the time of earlier runs.
const STAGE: &str = "earlier_runs";

/// Time and counts of the runs that have made a part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunState {
    /// Seconds from the begin of the render to the last pass, over all runs.
    pub(crate) seconds: f64,
    /// Counters of [`Stats`].
    counts: BTreeMap<String, u64>,
}

impl RunState {
    /// The state after `elapsed`.
    pub(crate) fn new(stats: &Stats, elapsed: Duration) -> Self {
        let counts = stats
            .counters()
            .map(|(name, counter)| (name.to_owned(), Stats::get(counter)));
        RunState {
            seconds: elapsed.as_secs_f64(),
            counts: counts.into(),
        }
    }

    /// Time from the begin of the render; zero if the number is none.
    pub(crate) fn elapsed(&self) -> Duration {
        Duration::try_from_secs_f64(self.seconds).unwrap_or_default()
    }

    /// Adds time and counts to those of a run.
    pub(crate) fn add_to(&self, stats: &Stats) {
        if !self.elapsed().is_zero() {
            stats.add_time(STAGE, self.elapsed());
        }
        for (name, counter) in stats.counters() {
            Stats::count(counter, self.counts.get(name).copied().unwrap_or(0));
        }
    }
}
