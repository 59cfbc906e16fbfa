//! Kernels that trace the same rays, and their rates side by side.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

use super::clock;
use manylight::geometry::{Geometry, Instructions};
use std::hint::black_box;

/// Timed runs per kernel; the median is reported.
pub(crate) const REPEATS: usize = 9;

/// A kernel that traces a whole ray set and returns the number of hits.
pub(crate) struct RayKernel<'a> {
    name: String,
    trace: Box<dyn Fn(&Geometry) -> u64 + 'a>,
    instructions: Instructions,
}

/// A kernel of this project, once for each instruction set of the machine.
pub(crate) fn own_kernels<'a>(
    name: &str,
    trace: impl Fn(&Geometry) -> u64 + Clone + 'a,
) -> impl Iterator<Item = RayKernel<'a>> {
    let all = Instructions::available().into_iter();
    all.map(move |instructions| RayKernel {
        name: format!("{name} {instructions:?}"),
        trace: Box::new(trace.clone()),
        instructions,
    })
}

/// A kernel of Embree.
pub(crate) fn embree_kernel<'a>(name: &str, trace: impl Fn() -> u64 + 'a) -> RayKernel<'a> {
    RayKernel {
        name: name.to_owned(),
        trace: Box::new(move |_| trace()),
        instructions: Instructions::Portable,
    }
}

/// The median. Sorts the times.
pub(crate) fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A ray set and the kernels that trace it. The first `references` kernels are Embree's.
pub(crate) struct Comparison<'a> {
    pub(crate) set: String,
    pub(crate) rays: usize,
    pub(crate) references: usize,
    pub(crate) kernels: Vec<RayKernel<'a>>,
}

impl Comparison<'_> {
    /// Times the kernels alternately and prints their median rates, as ratios to the fastest
    /// reference, or to the last kernel if there is no reference.
    pub(crate) fn run(&self, geometry: &mut Geometry) {
        let mut seconds = vec![Vec::new(); self.kernels.len()];
        let mut hits = vec![0; self.kernels.len()];
        for _ in 0..=REPEATS {
            for (i, kernel) in self.kernels.iter().enumerate() {
                geometry.use_instructions(kernel.instructions);
                let start = clock::thread_seconds();
                hits[i] = black_box((kernel.trace)(geometry));
                seconds[i].push(clock::thread_seconds() - start);
            }
        }
        let medians: Vec<f64> = seconds
            .iter_mut()
            .map(|times| {
                // The first run only warms the caches.
                times.remove(0);
                median(times)
            })
            .collect();
        let reference = medians[..self.references]
            .iter()
            .copied()
            .min_by(f64::total_cmp)
            .unwrap_or(medians[medians.len() - 1]);
        println!("{}: {} rays", self.set, self.rays);
        for ((kernel, median), hits) in self.kernels.iter().zip(&medians).zip(&hits) {
            let rate = self.rays as f64 / median * 1e-6;
            println!(
                "  {:32} {rate:8.2} M/s {:6.2}x  {hits} hits",
                kernel.name,
                reference / median
            );
        }
    }
}
