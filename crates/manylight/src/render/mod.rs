//! The front door: a scene and a method in, a film out.

pub mod job;

pub use crate::stats::Stats;
pub use job::{
    Budget, Observer, Outcome, RenderJob, Stop, Walkthrough, error_is_due, make_lights, render,
    render_blocks, render_film, resume,
};
