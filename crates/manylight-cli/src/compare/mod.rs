//! How much an image differs from a reference: error measures, and whether noise alone can explain the difference.

mod blocks;
mod flip;
mod frame;
mod metrics;
mod planes;
mod ssim;
mod table;
#[cfg(test)]
mod testing;

#[cfg(test)]
pub(crate) use frame::Correlation;
pub(crate) use frame::Frame;
pub(crate) use table::table;

use blocks::{BlockScores, block_scores};
use flip::flip;
use metrics::{Errors, Means, NoiseFloor, errors, means, noise_floor, reference_noise};
use serde::Serialize;
use ssim::ssim;

/// Everything known about one image against the reference.
#[derive(Debug, Serialize)]
pub(crate) struct Comparison {
    /// The image file.
    pub(crate) image: String,
    /// Pixels that are finite in both images; the others are left out of every figure.
    pub(crate) pixels: usize,
    /// Pixels that are not.
    pub(crate) non_finite_pixels: usize,
    /// Error measures.
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Structural similarity; absent for pictures of fewer than 11 pixels a side.
    pub(crate) ssim: Option<f64>,
    /// Mean of HDR-FLIP over all pixels, and
    pub(crate) flip: f64,
    /// by pixel.
    #[serde(skip)]
    pub(crate) flip_map: Vec<f32>,
    /// Means of both and their ratio.
    #[serde(flatten)]
    pub(crate) means: Means,
    /// What noise alone would give; absent unless both variances are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) noise_floor: Option<NoiseFloor>,
    /// The part of it that is the reference's; absent unless its variance is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reference_noise: Option<NoiseFloor>,
    /// z-scores of 8x8 blocks; absent unless both variances are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) blocks: Option<BlockScores>,
    /// The same without the pixels where an emitter is seen; absent unless an `emission` layer tells which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) without_emitters: Option<WithoutEmitters>,
}

/// Figures over the pixels where no emitter is seen, directly or along specular chains.
#[derive(Debug, Serialize)]
pub(crate) struct WithoutEmitters {
    /// How many pixels these are.
    pub(crate) pixels: usize,
    /// Error measures.
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Means of both and their ratio.
    #[serde(flatten)]
    pub(crate) means: Means,
    /// z-scores of 8x8 blocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) blocks: Option<BlockScores>,
}

/// Compares two frames of the same size.
pub(crate) fn compare(name: String, image: &Frame, reference: &Frame) -> Comparison {
    let finite: Vec<bool> = (0..image.rgb.len())
        .map(|i| image.is_finite(i) && reference.is_finite(i))
        .collect();
    let pixels = finite.iter().filter(|&&f| f).count();
    let flip_map = flip(image, reference);
    Comparison {
        image: name,
        pixels,
        non_finite_pixels: finite.len() - pixels,
        errors: errors(image, reference, &finite),
        ssim: ssim(image, reference),
        flip: flip_map.iter().copied().map(f64::from).sum::<f64>() / flip_map.len() as f64,
        flip_map,
        means: means(image, reference, &finite, |noise| noise.beauty),
        noise_floor: noise_floor(image, reference, &finite),
        reference_noise: reference_noise(reference, &finite),
        blocks: block_scores(image, reference, &finite),
        without_emitters: without_emitters(image, reference, &finite),
    }
}

fn without_emitters(image: &Frame, reference: &Frame, finite: &[bool]) -> Option<WithoutEmitters> {
    image.emission.as_ref()?;
    let kept: Vec<bool> = finite
        .iter()
        .enumerate()
        .map(|(i, &finite)| finite && !image.sees_emitter(i) && !reference.sees_emitter(i))
        .collect();
    Some(WithoutEmitters {
        pixels: kept.iter().filter(|&&k| k).count(),
        errors: errors(image, reference, &kept),
        means: means(image, reference, &kept, |noise| noise.without_emission),
        blocks: block_scores(image, reference, &kept),
    })
}
