//! Random numbers, warps to other domains, discrete sampling.

pub mod alias;
pub mod rng;
pub mod sampler;
mod sobol;
pub mod systematic;
pub mod warp;

pub(crate) use rng::Pcg;
pub(crate) use sampler::SobolSequences;
pub use sampler::{LowDiscrepancySequence, Pass, Sampler, Stream};
