//! All measures of one image against a reference.

use super::bars::{BarCoverage, bar_coverage};
use super::blocks::{BlockScores, block_scores};
use super::flip::flip_map;
use super::image::ComparisonImage;
use super::metrics::{Errors, Means, NoiseFloor, errors, means, noise_floor, reference_noise};
use super::ssim::ssim;
use serde::Serialize;

/// All measures of one image against a reference.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Name of the image.
    pub image: String,
    /// Number of pixels that are finite in both images. All measures but SSIM and HDR-FLIP leave
    /// the others out.
    pub pixels: usize,
    /// Number of pixels with an infinite value or NaN in one of the images.
    pub non_finite_pixels: usize,
    /// Error measures.
    #[serde(flatten)]
    pub errors: Errors,
    /// Structural similarity, at most 1; `None` below 11 pixels in width or height.
    pub ssim: Option<f64>,
    /// Mean of HDR-FLIP over all pixels, in [0, 1].
    pub flip: f64,
    /// HDR-FLIP of each pixel, row by row.
    #[serde(skip)]
    pub flip_map: Vec<f32>,
    /// Means of image and reference, and their ratio.
    #[serde(flatten)]
    pub means: Means,
    /// Expected errors if the images differed by noise alone; `None` unless both variances are
    /// known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<NoiseFloor>,
    /// Expected errors from the noise of the reference alone; `None` unless its variance is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_noise: Option<NoiseFloor>,
    /// z-scores of 8x8 blocks; `None` unless both variances are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blocks: Option<BlockScores>,
    /// How much of the reference lies within the error bars of the image; `None` if it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_bars: Option<BarCoverage>,
    /// Measures over the pixels without visible emitters; `None` if the image has no `emission`
    /// layer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_emitters: Option<WithoutEmitters>,
}

/// Measures over the pixels in which no emitter is visible, directly or through specular reflection
/// and refraction.
#[derive(Debug, Serialize)]
pub struct WithoutEmitters {
    /// Number of these pixels.
    pub pixels: usize,
    /// Error measures.
    #[serde(flatten)]
    pub errors: Errors,
    /// Means of image and reference, and their ratio.
    #[serde(flatten)]
    pub means: Means,
    /// z-scores of 8x8 blocks; `None` unless both variances are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blocks: Option<BlockScores>,
}

/// Compares an image with a reference of the same size. `name` becomes [`Comparison::image`].
///
/// # Panics
/// If the sizes differ.
pub fn compare(
    name: impl Into<String>,
    image: &ComparisonImage,
    reference: &ComparisonImage,
) -> Comparison {
    assert_eq!(
        (image.width, image.height),
        (reference.width, reference.height),
        "images of one size are compared"
    );
    let finite: Vec<bool> = (0..image.rgb.len())
        .map(|i| image.is_finite(i) && reference.is_finite(i))
        .collect();
    let pixels = finite.iter().filter(|&&f| f).count();
    let flip_map = flip_map(image, reference);
    Comparison {
        image: name.into(),
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
        within_bars: bar_coverage(image, reference, &finite),
        without_emitters: without_emitters(image, reference, &finite),
    }
}

fn without_emitters(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    finite: &[bool],
) -> Option<WithoutEmitters> {
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
