//! Where samples end up: per-pixel sums over passes, with the variance of their mean.

pub mod filter;

pub use filter::{Filter, FilterSampler};

use crate::math::UVec2;

/// Size and filter of a film, as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmDesc {
    /// Full size in pixels.
    pub size: UVec2,
    /// Upper left corner of the part that is rendered, in pixels.
    pub crop_offset: UVec2,
    /// Size of the part that is rendered, in pixels; `crop_offset + crop_size <= size`.
    pub crop_size: UVec2,
    /// Reconstruction filter.
    pub filter: Filter,
}
