//! Paths of particles in tasks of fixed size, with results in path order.

use rayon::prelude::*;
use std::ops::Range;

/// Number of paths traced by one task.
const PATHS_PER_TASK: u32 = 1024;

/// The particles of `path_count` paths, in path order for any number of threads. `trace` returns
/// those of a range of paths, each with the index of its path; those of one path are in their
/// order.
pub(super) fn in_path_order<P: Send>(
    path_count: u32,
    trace: impl Fn(Range<u32>) -> Vec<(u32, P)> + Sync,
) -> Vec<P> {
    let tasks: Vec<Vec<(u32, P)>> = (0..path_count.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * PATHS_PER_TASK;
            let mut particles = trace(first..(first + PATHS_PER_TASK).min(path_count));
            // Stable.
            particles.sort_by_key(|&(path, _)| path);
            particles
        })
        .collect();
    // Not `concat`: frees the list of each task while copying.
    let mut particles = Vec::with_capacity(tasks.iter().map(Vec::len).sum());
    particles.extend(tasks.into_iter().flatten().map(|(_, particle)| particle));
    particles
}
