//! What a render did: stage times and counts. Written by many threads, read by progress displays at any time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Counters and stage times of a render.
#[derive(Debug, Default)]
pub struct Stats {
    stages: Mutex<Vec<(&'static str, Duration)>>,
    /// Camera paths started.
    pub camera_paths: AtomicU64,
    /// Photon paths started.
    pub photon_paths: AtomicU64,
    /// Photons stored.
    pub photons: AtomicU64,
    /// Importons stored.
    pub importons: AtomicU64,
    /// Virtual lights made.
    pub lights: AtomicU64,
    /// Their bytes, tables included.
    pub light_bytes: AtomicU64,
    /// (shading point, virtual light) pairs evaluated.
    pub connections: AtomicU64,
    /// Visibility tests of connections and of direct light.
    pub shadow_rays: AtomicU64,
    /// Pixels of a pass dropped for a non-finite value.
    pub dropped_samples: AtomicU64,
    /// Virtual-light radiance removed by the clamp, and all of it, in units of 1e-6 of pixel luminance.
    pub clamped: AtomicU64,
    /// See `clamped`.
    pub unclamped: AtomicU64,
    /// Tiles done in the current pass, for progress displays.
    pub tiles_done: AtomicU64,
    /// Tiles of a pass.
    pub tiles: AtomicU64,
    /// Passes done.
    pub passes: AtomicU64,
}

impl Stats {
    /// Runs `work` and adds its duration to the stage `name`.
    pub fn time<T>(&self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add_time(name, start.elapsed());
        result
    }

    /// Adds to the stage `name`; stages keep the order of their first mention.
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

    /// Stage names with their total times.
    pub fn stages(&self) -> Vec<(&'static str, Duration)> {
        self.stages
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .clone()
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
