//! The one random walk, and light from emitters at a point.

pub mod direct;
mod numbers;
pub mod roulette;
pub mod walk;

pub use walk::{Arrival, Step, Vertex, Walk, past_emitters};
