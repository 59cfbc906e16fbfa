//! The film: per-pixel sums over passes, and estimates of the variance of their means.
//!
//! A sample touches exactly one pixel, because filters are importance-sampled. Tiles are therefore
//! independent, and any number of threads gives the same bits. The values of a pass are kept apart
//! until the pass is complete: a cancelled pass is discarded.
//!
//! Sums have two levels, so that parts of a render can be made apart and merged without a change of
//! bits: a block of passes sums from zero, and completed blocks are added in their order
//! ([`blocks`]).

pub mod arrays;
mod batches;
pub mod blocks;
mod coverage;
mod description;
mod error_bars;
mod estimates;
pub mod filter;
mod halves;
mod layer;
mod passes;
mod sampler;
mod sums;
#[cfg(test)]
mod tests;
mod tile_samples;
mod tiles;
mod totals;

pub use coverage::{IdLayer, RankedIds};
pub use description::FilmDesc;
pub use error_bars::{ErrorBars, StatedError};
pub use filter::Filter;
pub use halves::{Half, HalfCounts};
pub use layer::Layer;
pub use passes::Film;
pub use sampler::FilmSampler;
pub use sums::PassSums;
pub use tile_samples::{ShadedPixels, TileSamples, shaded_pixels};
pub use tiles::{TILE_SIZE, Tile, Tiling};
