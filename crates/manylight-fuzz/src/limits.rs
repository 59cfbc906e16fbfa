//! Limits of memory and stack: those of the program, or tighter.

use cap::Cap;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::alloc::System;
use std::sync::OnceLock;

/// Most bytes that a target may take for one input of 16 KiB. Deflate expands 1032 times, and a
/// sample of one bit becomes one of 32.
pub const MEMORY_LIMIT: usize = 1 << 30;

static ALLOCATOR: OnceLock<&'static Cap<System>> = OnceLock::new();

/// Makes `allocator` the one that [`limited`] sets limits of. It must be the global allocator of
/// the program.
pub fn limited_allocator(allocator: &'static Cap<System>) {
    let _ = ALLOCATOR.set(allocator);
}

/// Runs `target` as the program runs a reader: on a worker thread, with a stack of 2 MiB. If the
/// program has a [`limited_allocator`], an allocation beyond [`MEMORY_LIMIT`] fails.
pub fn limited(target: impl FnOnce() + Send) {
    static POOL: OnceLock<ThreadPool> = OnceLock::new();
    let pool = POOL.get_or_init(|| {
        let pool = ThreadPoolBuilder::new().num_threads(1).build();
        pool.expect("a thread can be started")
    });
    if let Some(allocator) = ALLOCATOR.get() {
        let limit = allocator.allocated() + MEMORY_LIMIT;
        allocator
            .set_limit(limit)
            .expect("the limit is above the memory in use");
    }
    pool.install(target);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_run_on_a_worker_thread() {
        let test = std::thread::current().id();
        limited(move || assert_ne!(std::thread::current().id(), test));
    }
}
