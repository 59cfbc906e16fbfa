//! Random numbers and what is made of them: warps, discrete choice, MIS weights.

pub mod alias;
pub mod mis;
pub mod rng;
pub mod sampler;
pub mod systematic;
pub mod warp;

pub use sampler::{Pass, Sampler, Spread, Stream};
