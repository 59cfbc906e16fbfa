//! Budget, passes, observers.

pub mod job;

pub use crate::stats::Stats;
pub use job::{Budget, Observer, Outcome, RenderJob, Stop, render};
