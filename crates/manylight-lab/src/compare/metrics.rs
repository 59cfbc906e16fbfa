//! Error measures, means and the noise floor over a subset of the pixels, given as one flag per
//! pixel (`kept`).

use super::blocks::{BLOCK_SIZE, block_pixels};
use super::image::{ComparisonImage, NoiseCorrelation};
use crate::noise::MeanNoise;
use serde::Serialize;

/// Error measures. Averages are over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Mean squared error: average of (x - r)².
    pub mse: f64,
    /// Relative mean squared error: average of (x - r)² / (r² + 0.01 m²).
    pub relmse: f64,
    /// The same of the means of 8x8 blocks. The noise of independent pixels is a 64th of that in
    /// relMSE; what neighbors share, as a filter leaves it, is as large.
    pub block_relmse: f64,
    /// Mean absolute relative error: average of |x - r| / max(|r|, 0.01 m).
    pub mape: f64,
    /// Symmetric mean absolute relative error: average of |x - r| / max(|x| + |r|, 0.01 m).
    pub smape: f64,
    /// Peak signal-to-noise ratio 10 log10(p² / MSE) in dB, with p the largest value of the
    /// reference; `None` for equal images.
    pub psnr: Option<f64>,
    /// Quantiles over pixels of the square root of the pixel's relMSE.
    pub pixel_error: Quantiles,
}

/// Quantiles of a distribution; see the field names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Half of the values are at most this.
    pub median: f64,
    /// 99 % of the values are at most this.
    pub p99: f64,
    /// 99.9 % of the values are at most this.
    pub p99_9: f64,
}

/// Means over the pixels, per channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Means {
    /// Mean of the image.
    pub mean: [f64; 3],
    /// Mean of the reference.
    pub reference_mean: [f64; 3],
    /// Mean of the image over the mean of the reference; `None` where the latter is 0.
    pub ratio_of_means: [Option<f64>; 3],
    /// Standard error of the ratio; `None` unless both variances are known.
    pub ratio_standard_error: [Option<f64>; 3],
}

/// Expected contribution of noise to the error measures. If both images have the same expectation,
/// it is all of their error. `v` is the variance of x - r, or of r alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseFloor {
    /// Expected MSE: average of v.
    pub mse: f64,
    /// Expected relMSE: average of v / (r² + 0.01 m²).
    pub relmse: f64,
}

/// Lower bound of the denominators of MAPE and SMAPE, in units of m: keeps black pixels from
/// dominating.
const FLOOR: f64 = 0.01;

/// Weight of m² in the denominator of relMSE, for the same reason.
const RELMSE_FLOOR: f64 = 0.01;

/// Pairs (pixel, channel) of the kept pixels.
fn values(kept: &[bool]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let pixels = kept.iter().enumerate().filter(|(_, kept)| **kept);
    pixels.flat_map(|(i, _)| (0..3).map(move |c| (i, c)))
}

fn average(terms: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = terms.fold((0.0, 0_usize), |(sum, count), term| (sum + term, count + 1));
    sum / count.max(1) as f64
}

/// `part / whole`, or 0 for 0 / 0.
fn share(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

fn mean_of(image: &ComparisonImage, kept: &[bool]) -> f64 {
    average(values(kept).map(|(i, c)| f64::from(image.rgb[i][c])))
}

/// The error measures over the kept pixels.
pub(super) fn errors(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
) -> Errors {
    let pair =
        |(i, c): (usize, usize)| (f64::from(image.rgb[i][c]), f64::from(reference.rgb[i][c]));
    let mean =
        |term: &dyn Fn(f64, f64) -> f64| average(values(kept).map(pair).map(|(x, r)| term(x, r)));
    let m = mean_of(reference, kept);
    let mse = mean(&|x, r| (x - r).powi(2));
    let peak = values(kept).map(pair).map(|(_, r)| r).fold(0.0, f64::max);
    Errors {
        mse,
        relmse: mean(&|x, r| share((x - r).powi(2), r * r + RELMSE_FLOOR * m * m)),
        block_relmse: block_relmse(image, reference, kept, m),
        mape: mean(&|x, r| share((x - r).abs(), r.abs().max(FLOOR * m))),
        smape: mean(&|x, r| share((x - r).abs(), (x.abs() + r.abs()).max(FLOOR * m))),
        psnr: (mse > 0.0).then(|| 10.0 * (peak * peak / mse).log10()),
        pixel_error: pixel_error(image, reference, kept, m),
    }
}

/// [`Errors::block_relmse`]; `m` is the mean of the reference. Blocks at the border and those with
/// pixels that are not kept are smaller, and count by their pixels.
fn block_relmse(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
    m: f64,
) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for y in (0..image.height).step_by(BLOCK_SIZE) {
        for x in (0..image.width).step_by(BLOCK_SIZE) {
            let pixels: Vec<usize> = block_pixels(image, [x, y]).filter(|&i| kept[i]).collect();
            let mean = |rgb: &[[f32; 3]], c| average(pixels.iter().map(|&i| f64::from(rgb[i][c])));
            for c in 0..3 {
                let (x, r) = (mean(&image.rgb, c), mean(&reference.rgb, c));
                let error = share((x - r).powi(2), r * r + RELMSE_FLOOR * m * m);
                sum += error * pixels.len() as f64;
            }
            count += 3 * pixels.len();
        }
    }
    sum / count.max(1) as f64
}

/// [`Errors::pixel_error`]; `m` is the mean of the reference.
fn pixel_error(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
    m: f64,
) -> Quantiles {
    let error = |(i, _): (usize, &bool)| {
        let squares = (0..3).map(|c| {
            let (x, r) = (f64::from(image.rgb[i][c]), f64::from(reference.rgb[i][c]));
            share((x - r).powi(2), r * r + RELMSE_FLOOR * m * m)
        });
        average(squares).sqrt()
    };
    let kept = kept.iter().enumerate().filter(|(_, kept)| **kept);
    let mut errors: Vec<f64> = kept.map(error).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| {
        let i = (share * errors.len() as f64).ceil() as usize;
        errors.get(i.max(1) - 1).copied().unwrap_or_default()
    };
    Quantiles {
        median: at(0.5),
        p99: at(0.99),
        p99_9: at(0.999),
    }
}

/// Means of both images over the kept pixels. Where the noise is correlated, `variance` selects the
/// known variance of the mean that belongs to these pixels.
pub(super) fn means(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
    variance: fn(&MeanNoise) -> [f64; 3],
) -> Means {
    let mean = std::array::from_fn(|c| channel_mean(&image.rgb, kept, c));
    let reference_mean = std::array::from_fn(|c| channel_mean(&reference.rgb, kept, c));
    let ratio = |c: usize| (reference_mean[c] != 0.0).then(|| mean[c] / reference_mean[c]);
    // Ratio q of two independent means: var q = (var x + q² var r) / r².
    let standard_error = |c: usize| {
        let q = ratio(c)?;
        let of_image = variance_of_mean(image, kept, variance, c)?;
        let of_reference = variance_of_mean(reference, kept, variance, c)?;
        Some((of_image + q * q * of_reference).sqrt() / reference_mean[c].abs())
    };
    Means {
        mean,
        reference_mean,
        ratio_of_means: std::array::from_fn(ratio),
        ratio_standard_error: std::array::from_fn(standard_error),
    }
}

/// Variance of the mean over the kept pixels; `None` if it is not known.
fn variance_of_mean(
    image: &ComparisonImage,
    kept: &[bool],
    variance: fn(&MeanNoise) -> [f64; 3],
    c: usize,
) -> Option<f64> {
    let count = kept.iter().filter(|&&k| k).count().max(1) as f64;
    match &image.correlation {
        NoiseCorrelation::Unknown => None,
        NoiseCorrelation::None => Some(channel_mean(image.variance.as_ref()?, kept, c) / count),
        NoiseCorrelation::Known { mean, .. } => {
            Some(variance(mean)[c] * (kept.len() as f64 / count).powi(2))
        }
    }
}

fn channel_mean(values: &[[f32; 3]], kept: &[bool], c: usize) -> f64 {
    average(
        values
            .iter()
            .zip(kept)
            .filter(|(_, kept)| **kept)
            .map(|(v, _)| f64::from(v[c])),
    )
}

/// Expected errors if the images differed by noise alone; `None` unless both variances are known.
pub(super) fn noise_floor(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
) -> Option<NoiseFloor> {
    let (a, b) = image.variance.as_ref().zip(reference.variance.as_ref())?;
    let variance = |(i, c): (usize, usize)| f64::from(a[i][c]) + f64::from(b[i][c]);
    Some(floor_of(variance, reference, kept))
}

/// Expected errors from the noise of the reference alone; `None` unless its variance is known.
pub(super) fn reference_noise(reference: &ComparisonImage, kept: &[bool]) -> Option<NoiseFloor> {
    let variance = reference.variance.as_ref()?;
    let of_value = |(i, c): (usize, usize)| f64::from(variance[i][c]);
    Some(floor_of(of_value, reference, kept))
}

fn floor_of(
    variance: impl Fn((usize, usize)) -> f64,
    reference: &ComparisonImage,
    kept: &[bool],
) -> NoiseFloor {
    let m = mean_of(reference, kept);
    let relative = |(i, c): (usize, usize)| {
        let r = f64::from(reference.rgb[i][c]);
        share(variance((i, c)), r * r + RELMSE_FLOOR * m * m)
    };
    NoiseFloor {
        mse: average(values(kept).map(&variance)),
        relmse: average(values(kept).map(relative)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(pixels: &[[f32; 3]], variance: Option<f32>) -> ComparisonImage {
        ComparisonImage {
            variance: variance.map(|v| vec![[v; 3]; pixels.len()]),
            ..ComparisonImage::from_rgb(pixels.len(), 1, pixels.to_vec())
        }
    }

    fn assert_close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn hand_computed_errors() {
        // Reference mean m = (6 * 1 + 6 * 3) / 12 = 2; differences 1 in half of the values of pixel
        // 0, 0 elsewhere.
        let reference = frame(&[[1.0; 3], [3.0; 3], [1.0; 3], [3.0; 3]], None);
        let image = frame(&[[2.0; 3], [3.0; 3], [1.0; 3], [3.0; 3]], None);
        let e = errors(&image, &reference, &[true; 4]);
        assert_close(e.mse, 0.25);
        assert_close(e.relmse, 0.25 / 1.04);
        assert_close(e.mape, 0.25);
        assert_close(e.smape, 0.25 / 3.0);
        assert_close(e.psnr.unwrap(), 10.0 * 36_f64.log10());
        assert_eq!(e.pixel_error.median, 0.0);
        assert_close(e.pixel_error.p99, (1.0 / 1.04_f64).sqrt());
        assert_eq!(e.pixel_error.p99, e.pixel_error.p99_9);
    }

    #[test]
    fn equal_images_have_no_error_even_where_black() {
        let black = frame(&[[0.0; 3]; 2], None);
        let e = errors(&black, &black, &[true; 2]);
        assert_eq!(
            (e.mse, e.relmse, e.block_relmse, e.mape, e.smape, e.psnr),
            (0.0, 0.0, 0.0, 0.0, 0.0, None)
        );
        assert_eq!(
            means(&black, &black, &[true; 2], |noise| noise.beauty).ratio_of_means,
            [None; 3]
        );
    }

    #[test]
    fn pixels_that_are_not_kept_do_not_count() {
        let reference = frame(&[[1.0; 3], [1.0; 3]], None);
        let image = frame(&[[1.0; 3], [f32::NAN; 3]], None);
        let kept = [true, false];
        assert_eq!(errors(&image, &reference, &kept).mse, 0.0);
        assert_eq!(
            means(&image, &reference, &kept, |noise| noise.beauty).ratio_of_means,
            [Some(1.0); 3]
        );
    }

    #[test]
    fn ratio_of_means_and_its_standard_error() {
        let reference = frame(&[[2.0, 4.0, 8.0]; 4], Some(0.5));
        let image = frame(&[[1.0, 4.0, 16.0]; 4], Some(1.0));
        let means = means(&image, &reference, &[true; 4], |noise| noise.beauty);
        assert_eq!(means.ratio_of_means, [Some(0.5), Some(1.0), Some(2.0)]);
        // Channel 0: variances of the means of 4 pixels are 1/4 and 1/8; sqrt(1/4 + 0.25 / 8) / 2.
        assert_close(
            means.ratio_standard_error[0].unwrap(),
            (0.25_f64 + 0.25 / 8.0).sqrt() / 2.0,
        );
        let floor = noise_floor(&image, &reference, &[true; 4]).unwrap();
        assert_close(floor.mse, 1.5);
        let own = reference_noise(&reference, &[true; 4]).unwrap();
        assert_close(own.mse, 0.5);
        let m2 = (14.0 / 3.0f64).powi(2);
        let weights = [2.0, 4.0, 8.0].map(|r: f64| 1.0 / (r * r + 0.01 * m2));
        assert_close(own.relmse, 0.5 * weights.iter().sum::<f64>() / 3.0);
    }

    #[test]
    fn noise_in_common_does_not_average_out() {
        let reference = frame(&[[2.0, 4.0, 8.0]; 4], Some(0.0));
        let mut image = frame(&[[1.0, 4.0, 16.0]; 4], Some(1.0));
        let mean = MeanNoise {
            batches: 5,
            beauty: [0.36; 3],
            without_emission: [0.09; 3],
        };
        let blocks = vec![[1.0; 3]; 4];
        image.correlation = NoiseCorrelation::Known { blocks, mean };
        let error = |image: &ComparisonImage, kept: &[bool], variance| {
            means(image, &reference, kept, variance).ratio_standard_error[0]
        };
        assert_close(
            error(&image, &[true; 4], |noise| noise.beauty).unwrap(),
            0.3,
        );
        // All of it is in the half that is left.
        let half = [true, true, false, false];
        assert_close(
            error(&image, &half, |noise| noise.without_emission).unwrap(),
            0.3,
        );
        image.correlation = NoiseCorrelation::Unknown;
        assert_eq!(error(&image, &half, |noise| noise.without_emission), None);
    }

    #[test]
    fn blocks_keep_what_neighbors_share_alone() {
        // Two pixels, in one block.
        let reference = frame(&[[1.0; 3]; 2], None);
        let relmse = |pixels: [[f32; 3]; 2], kept: [bool; 2]| {
            let e = errors(&frame(&pixels, None), &reference, &kept);
            (e.relmse, e.block_relmse)
        };
        let (own, of_blocks) = relmse([[1.5; 3], [0.5; 3]], [true; 2]);
        assert_close(own, 0.25 / 1.01);
        assert_close(of_blocks, 0.0);
        let (own, of_blocks) = relmse([[1.5; 3]; 2], [true; 2]);
        assert_close(own, 0.25 / 1.01);
        assert_close(of_blocks, 0.25 / 1.01);
        let (_, of_blocks) = relmse([[1.5; 3], [f32::NAN; 3]], [true, false]);
        assert_close(of_blocks, 0.25 / 1.01);
    }
}
