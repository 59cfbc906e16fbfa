//! z-scores of 8x8 blocks: whether a region differs by more than its noise explains.

use super::image::{ComparisonImage, NoiseCorrelation};
use serde::Serialize;

/// Width and height of a block in pixels.
pub(super) const BLOCK_SIZE: usize = 8;

/// Absolute z-score above which a block counts as different. With normally distributed noise alone,
/// 0.27 % of blocks exceed it.
const SCORE_LIMIT: f64 = 3.0;

/// Relative rounding error of image values, which are sums of 32-bit floats. It matters where there
/// is no noise, as on emitters.
const RELATIVE_ROUNDING: f64 = 1e-6;

/// Statistics of z = (x - r) / sqrt(var x + var r + rounding²), with x and r the means over a block
/// in one channel.
///
/// A variance estimated from few batches makes z follow Student's distribution. Then z is replaced
/// by the value of a standard normal variable with the same probability of being exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BlockScores {
    /// Number of scores: pairs of block and channel with at least one kept pixel, and with noise or
    /// a difference.
    pub count: usize,
    /// Fraction of the scores with |z| > 3.
    pub share_beyond_3: f64,
    /// Mean of z; 0 is expected without bias.
    pub mean: f64,
    /// Root mean square of z; 1 is expected if the images differ by noise alone.
    pub rms: f64,
    /// Largest |z|.
    pub largest: f64,
}

/// Scores of all blocks over the kept pixels; `None` unless both variances are known.
pub(super) fn block_scores(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
) -> Option<BlockScores> {
    let noises = [ImageNoise::of(image)?, ImageNoise::of(reference)?];
    let mut scores = Vec::new();
    for y in (0..image.height).step_by(BLOCK_SIZE) {
        for x in (0..image.width).step_by(BLOCK_SIZE) {
            let block = PixelBlock::new(image, [x, y], kept);
            scores.extend((0..3).filter_map(|c| {
                let variances = noises.each_ref().map(|noise| noise.of_sum(&block, c));
                score(image, reference, variances, &block.pixels, c)
            }));
        }
    }
    Some(summary(&scores))
}

/// The pixels of the block with the upper left pixel `corner`.
pub(super) fn block_pixels(
    image: &ComparisonImage,
    [x0, y0]: [usize; 2],
) -> impl Iterator<Item = usize> + use<> {
    let width = image.width;
    let rows = y0..(y0 + BLOCK_SIZE).min(image.height);
    let columns = x0..(x0 + BLOCK_SIZE).min(width);
    rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// The kept pixels of one block.
pub(super) struct PixelBlock {
    pub(super) pixels: Vec<usize>,
    /// Whether all pixels of the block are kept.
    pub(super) is_whole: bool,
}

impl PixelBlock {
    /// The block with the upper left pixel `corner`.
    pub(super) fn new(image: &ComparisonImage, corner: [usize; 2], kept: &[bool]) -> Self {
        let (pixels, others): (Vec<usize>, Vec<usize>) =
            block_pixels(image, corner).partition(|&i| kept[i]);
        PixelBlock {
            pixels,
            is_whole: others.is_empty(),
        }
    }
}

/// Known variances of one image.
pub(super) struct ImageNoise<'f> {
    /// Variance of each pixel.
    pixels: &'f [[f32; 3]],
    /// Variance of the mean over the block of each pixel, and the degrees of freedom of the
    /// estimate; `None` if pixels are independent.
    blocks: Option<(&'f [[f32; 3]], f64)>,
}

/// A variance and the degrees of freedom of its estimate.
#[derive(Clone, Copy)]
pub(super) struct Variance {
    pub(super) value: f64,
    freedom: f64,
}

impl<'f> ImageNoise<'f> {
    /// `None` unless the variances of `image` are known.
    pub(super) fn of(image: &'f ComparisonImage) -> Option<Self> {
        let blocks = match &image.correlation {
            NoiseCorrelation::Unknown => return None,
            NoiseCorrelation::None => None,
            NoiseCorrelation::Known { blocks, mean } => {
                Some((blocks.as_slice(), f64::from(mean.batches) - 1.0))
            }
        };
        Some(ImageNoise {
            pixels: image.variance.as_deref()?,
            blocks,
        })
    }

    /// Variance of channel `c` of pixel `i`.
    pub(super) fn of_pixel(&self, i: usize, c: usize) -> f64 {
        f64::from(self.pixels[i][c])
    }

    /// Variance of the sum over the kept pixels of a block. For an incomplete block only the
    /// variances of single pixels are known, and the pixels are taken as independent.
    pub(super) fn of_sum(&self, block: &PixelBlock, c: usize) -> Variance {
        let pixels = &block.pixels;
        match (self.blocks, pixels.first()) {
            (Some((blocks, freedom)), Some(&first)) if block.is_whole => Variance {
                value: (pixels.len() as f64).powi(2) * f64::from(blocks[first][c]),
                freedom,
            },
            _ => Variance {
                value: pixels.iter().map(|&i| f64::from(self.pixels[i][c])).sum(),
                freedom: f64::INFINITY,
            },
        }
    }
}

impl Variance {
    /// Variance of the difference of two independent values, with the effective degrees of freedom
    /// (Welch, "The generalization of `Student's' problem", Biometrika 1947).
    fn of_difference([a, b]: [Variance; 2]) -> Variance {
        let value = a.value + b.value;
        let spread = a.value.powi(2) / a.freedom + b.value.powi(2) / b.freedom;
        let freedom = if spread > 0.0 {
            value.powi(2) / spread
        } else {
            f64::INFINITY
        };
        Variance { value, freedom }
    }
}

/// The standard normal value with the same tail probability as Student's `t` (Wallace, "Bounds on
/// normal approximations to Student's and the chi-square distributions", Ann. Math. Stat. 1959, eq.
/// 4.2; within 2 % from 3 degrees of freedom on).
fn normal(t: f64, freedom: f64) -> f64 {
    if freedom > 1e6 {
        return t;
    }
    let n = freedom;
    let z = (8.0 * n + 1.0) / (8.0 * n + 3.0) * (n * (t * t / n).ln_1p()).sqrt();
    z.copysign(t)
}

/// z-score of one block in one channel. The number of pixels cancels: z = Σ(x - r) / sqrt(Σ var).
/// `None` if the images are equal there and have no noise.
fn score(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    variances: [Variance; 2],
    pixels: &[usize],
    c: usize,
) -> Option<f64> {
    let sum = |term: &dyn Fn(usize) -> f64| pixels.iter().map(|&i| term(i)).sum::<f64>();
    let value = |image: &ComparisonImage, i: usize| f64::from(image.rgb[i][c]);
    let difference = sum(&|i| value(image, i) - value(reference, i));
    let variance = Variance::of_difference(variances);
    // Pixels of the same value round in the same direction: rounding errors add up before they are
    // squared.
    let rounding =
        RELATIVE_ROUNDING * sum(&|i| value(image, i).abs().max(value(reference, i).abs()));
    (difference != 0.0 || variance.value > 0.0).then(|| {
        let t = difference / variance.value.sqrt().hypot(rounding);
        normal(t, variance.freedom)
    })
}

fn summary(scores: &[f64]) -> BlockScores {
    let average = |f: &dyn Fn(f64) -> f64| {
        scores.iter().map(|&z| f(z)).sum::<f64>() / scores.len().max(1) as f64
    };
    BlockScores {
        count: scores.len(),
        share_beyond_3: average(&|z| f64::from(u8::from(z.abs() > SCORE_LIMIT))),
        mean: average(&|z| z),
        rms: average(&|z| z * z).sqrt(),
        largest: scores
            .iter()
            .fold(0.0, |largest: f64, z| largest.max(z.abs())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::MeanNoise;

    fn frame(width: usize, height: usize, value: f32, variance: Option<f32>) -> ComparisonImage {
        let count = width * height;
        ComparisonImage {
            variance: variance.map(|v| vec![[v; 3]; count]),
            ..ComparisonImage::from_rgb(width, height, vec![[value; 3]; count])
        }
    }

    #[test]
    fn blocks_at_the_edges_are_smaller() {
        // 8x8, 2x8, 8x1, 2x1 pixels; z = n d / sqrt(n (v + v)) = d sqrt(n / 2v).
        let reference = frame(10, 9, 1.0, Some(0.5));
        let image = frame(10, 9, 1.5, Some(0.5));
        let scores = block_scores(&image, &reference, &[true; 90]).unwrap();
        assert_eq!(scores.count, 12);
        let expected = [64.0_f64, 16.0, 8.0, 2.0].map(|n| 0.5 * n.sqrt());
        assert!((scores.mean - expected.iter().sum::<f64>() / 4.0).abs() < 1e-9);
        assert!((scores.largest - 4.0).abs() < 1e-9);
        assert_eq!(scores.share_beyond_3, 0.25);
    }

    #[test]
    fn noise_in_common_counts_whole() {
        let reference = frame(8, 8, 1.0, Some(0.0));
        let mut image = frame(8, 8, 1.5, Some(0.01));
        let mean = MeanNoise {
            batches: 11,
            beauty: [0.0; 3],
            without_emission: [0.0; 3],
        };
        let blocks = vec![[0.04; 3]; 64];
        image.correlation = NoiseCorrelation::Known { blocks, mean };
        // 2.5 standard deviations by 10 degrees of freedom: 3.1 % of all are farther off, as beyond
        // 2.15 of a normal variable.
        let scores = block_scores(&image, &reference, &[true; 64]).unwrap();
        assert!((scores.mean - 2.15).abs() < 0.01, "{scores:?}");
        // A part of the block is judged by its pixels: 0.5 / (0.1 / sqrt(63)).
        let mut kept = [true; 64];
        kept[5] = false;
        let scores = block_scores(&image, &reference, &kept).unwrap();
        assert!(
            (scores.mean - 5.0 * 63f64.sqrt()).abs() < 1e-6,
            "{scores:?}"
        );
        image.correlation = NoiseCorrelation::Unknown;
        assert_eq!(block_scores(&image, &reference, &[true; 64]), None);
    }

    /// Quantiles of Student's distribution from tables: two-sided 0.27 % and 5 %.
    #[test]
    fn as_rare_as_a_normal_variable() {
        for (freedom, t, z) in [
            (4.0, 6.62, 3.0),
            (7.0, 4.53, 3.0),
            (20.0, 3.42, 3.0),
            (4.0, 2.776, 1.96),
            (7.0, 2.365, 1.96),
            (20.0, 2.086, 1.96),
        ] {
            assert!((normal(t, freedom) / z - 1.0).abs() < 0.02, "{freedom} {t}");
            assert_eq!(normal(-t, freedom), -normal(t, freedom));
        }
        assert_eq!(normal(3.0, f64::INFINITY), 3.0);
    }

    #[test]
    fn no_variance_no_scores() {
        let reference = frame(8, 8, 1.0, None);
        assert_eq!(
            block_scores(&reference, &frame(8, 8, 1.0, Some(1.0)), &[true; 64]),
            None
        );
    }

    #[test]
    fn blocks_without_noise() {
        let reference = frame(8, 8, 1.0, Some(0.0));
        let same = block_scores(&reference, &reference, &[true; 64]).unwrap();
        assert_eq!((same.count, same.share_beyond_3), (0, 0.0));
        let other = frame(8, 8, 2.0, Some(0.0));
        let scores = block_scores(&other, &reference, &[true; 64]).unwrap();
        assert_eq!((scores.count, scores.share_beyond_3), (3, 1.0));
        let rounded = frame(8, 8, 1.0 + f32::EPSILON, Some(0.0));
        let scores = block_scores(&rounded, &reference, &[true; 64]).unwrap();
        assert!(scores.largest < 0.2, "a difference of one bit: {scores:?}");
    }
}
