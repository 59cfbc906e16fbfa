//! Budget, passes, observers.

pub mod job;
pub mod stats;

pub use job::{Budget, Observer, Outcome, RenderJob, Stop, render};
pub use stats::Stats;
