//! Statistics of a render: stage times and counters. Written by many threads; readable at any time,
//! by progress displays.

use std::cell::Cell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Counters and stage times of a render.
#[derive(Debug, Default)]
pub struct Stats {
    stages: Mutex<Vec<(&'static str, Duration)>>,
    /// Time of stages within others, which counts in both, in ns.
    nested: AtomicU64,
    /// Number of camera paths traced.
    pub camera_paths: AtomicU64,
    /// Number of photon paths traced.
    pub photon_paths: AtomicU64,
    /// Number of photons stored.
    pub photons: AtomicU64,
    /// Number of importons stored.
    pub importons: AtomicU64,
    /// Number of virtual lights created.
    pub lights: AtomicU64,
    /// Memory of the virtual lights in bytes, tables included.
    pub light_bytes: AtomicU64,
    /// Number of connections: pairs of a shading point and a virtual light that are evaluated.
    pub connections: AtomicU64,
    /// Number of shadow rays, for connections and for direct light.
    pub shadow_rays: AtomicU64,
    /// Number of pixel samples dropped for a non-finite value.
    pub dropped_samples: AtomicU64,
    /// Radiance of virtual lights that clamping removes, summed over pixels, in units of 1e-6 of
    /// luminance.
    pub clamped: AtomicU64,
    /// Radiance of virtual lights before clamping, in the units of [`Stats::clamped`].
    pub unclamped: AtomicU64,
    /// Number of complete tiles in the current pass.
    pub tiles_done: AtomicU64,
    /// Number of tiles in the current pass.
    pub tiles: AtomicU64,
    /// Number of complete passes.
    pub passes: AtomicU64,
}

thread_local! {
    /// Stages that this thread is in.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

impl Stats {
    /// Runs `work` and adds its wall time to the stage `name`. A stage may run within another, as
    /// virtual lights are made for the pre-pass of a choice: the time counts in both.
    pub fn time<T>(&self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let depth = DEPTH.replace(DEPTH.get() + 1);
        let start = Instant::now();
        let result = work();
        let elapsed = start.elapsed();
        DEPTH.set(depth);
        self.add_time(name, elapsed);
        if depth > 0 {
            Self::count(&self.nested, elapsed.as_nanos() as u64);
        }
        result
    }

    /// Time of all stages together; of stages within others, only that of the outer one.
    pub fn total_time(&self) -> Duration {
        let sum: Duration = self.stages().iter().map(|(_, time)| *time).sum();
        sum.saturating_sub(Duration::from_nanos(Self::get(&self.nested)))
    }

    /// Adds a duration to the stage `name`. Stages are ordered by their first use.
    pub fn add_time(&self, name: &'static str, duration: Duration) {
        let mut stages = self
            .stages
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        match stages.iter_mut().find(|stage| stage.0 == name) {
            Some(stage) => stage.1 += duration,
            None => stages.push((name, duration)),
        }
    }

    /// All stages with their total times.
    pub fn stages(&self) -> Vec<(&'static str, Duration)> {
        self.stages
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .clone()
    }

    /// The counters that add up over parts of a render, with their names.
    pub fn counters(&self) -> [(&'static str, &AtomicU64); 12] {
        [
            ("passes", &self.passes),
            ("camera_paths", &self.camera_paths),
            ("photon_paths", &self.photon_paths),
            ("photons", &self.photons),
            ("importons", &self.importons),
            ("lights", &self.lights),
            ("light_bytes", &self.light_bytes),
            ("connections", &self.connections),
            ("shadow_rays", &self.shadow_rays),
            ("dropped_samples", &self.dropped_samples),
            ("clamped", &self.clamped),
            ("unclamped", &self.unclamped),
        ]
    }

    /// Adds to a counter.
    #[inline]
    pub fn count(counter: &AtomicU64, n: u64) {
        counter.fetch_add(n, Ordering::Relaxed);
    }

    /// Reads a counter.
    pub fn get(counter: &AtomicU64) -> u64 {
        counter.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_within_others_count_once_in_the_total() {
        let stats = Stats::default();
        let pause = || std::thread::sleep(Duration::from_millis(5));
        stats.time("choice", || {
            pause();
            stats.time("lights", || stats.time("photons", pause));
        });
        stats.time("shade", pause);
        let stages = stats.stages();
        let of = |name| stages.iter().find(|stage| stage.0 == name).unwrap().1;
        assert_eq!(stats.total_time(), of("choice") + of("shade"));
        assert!(of("choice") >= of("lights") && of("lights") >= of("photons"));
    }
}
