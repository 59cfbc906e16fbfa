//! How much an image differs from a reference: error measures, and tests of whether noise alone
//! explains the difference.
//!
//! [`compare`] computes everything that [`Comparison`] lists. In the formulas of this module, `x`
//! is a value of the image, `r` the value of the reference in the same pixel and channel, and `m`
//! the mean of all `r`. Values are linear.

mod bars;
mod blocks;
mod comparison;
mod files;
mod flip;
mod image;
mod layers;
mod metrics;
mod planes;
mod ssim;
mod table;
#[cfg(test)]
mod testing;

pub use bars::BarCoverage;
pub use blocks::BlockScores;
pub use comparison::{Comparison, WithoutEmitters, compare};
pub use files::{compare_file, read_image};
pub use flip::flip_map;
pub use image::{ComparisonImage, ErrorBars, ImageChannelsError, LightGroups, NoiseCorrelation};
pub use metrics::{Errors, Means, NoiseFloor, Quantiles};
pub use ssim::ssim;
pub use table::table;
