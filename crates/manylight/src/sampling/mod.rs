//! Random numbers, warps to other domains, discrete sampling.

pub mod alias;
pub mod rng;
pub mod sampler;
pub mod systematic;
pub mod warp;

pub(crate) use rng::Pcg;
pub use sampler::{LowDiscrepancySequence, Pass, Sampler, Stream};
