//! The mean of the noisy and the filtered image with the smaller expected error.
//!
//! The noisy image `x` has variance `v` and no bias; the filtered image `y` has little variance and
//! an unknown error `e`. Where the errors are independent, `E (y - x)² = e² + v`, so that `e² ≈
//! max(G (y - x)² - c G v, 0)` with `G` a mean over neighboring pixels and `c` slightly above 1.
//! The weight `e² / (e² + v)` of `x` minimizes the expected squared error. A converged image
//! therefore stays as it is.

use manylight::image::Image;

/// Standard deviation of `G`, in pixels. Larger: estimates with less noise, from pixels with less
/// in common. 2, 3 and 5 give relative MSEs within 1 % of each other (3 scenes at 160x90, 16
/// passes).
const STDDEV: f32 = 3.0;

/// Factor of the variance in the estimate of `e²`. With 1, chance differences bring a tenth of
/// single bright pixels back, and the noise that passes with common lights share counts as an error
/// of the filter: 16 samples of path tracing in the Kitchen have 1.16 times the relative MSE of 1.5
/// and of 2. Larger values trust the filter more.
const VARIANCE_FACTOR: f32 = 1.5;

/// Blends `filtered` with `noisy`, which has this variance per pixel and channel. All images have
/// the same size. Where the variance is not known (not finite), the result is `filtered`.
pub(crate) fn blend(filtered: &Image, noisy: &Image, variance: &Image) -> Image {
    let mut difference = filtered.clone();
    for (d, x) in difference.data.iter_mut().zip(&noisy.data) {
        *d = (*d - x) * (*d - x);
    }
    let difference = difference.smoothed(STDDEV);
    let variance = variance.smoothed(STDDEV);
    let mut result = filtered.clone();
    for (i, y) in result.data.iter_mut().enumerate() {
        let v = variance.data[i];
        let error = (difference.data[i] - VARIANCE_FACTOR * v).max(0.0);
        let weight = error / (error + v);
        // 0/0 where nothing differs and nothing varies.
        if weight.is_finite() {
            *y += weight * (noisy.data[i] - *y);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(value: f32) -> Image {
        Image {
            data: vec![value; 20 * 11 * 3],
            ..Image::new(20, 11, 3)
        }
    }

    #[test]
    fn the_filtered_image_stays_where_the_difference_is_noise() {
        let result = blend(&constant(1.0), &constant(1.1), &constant(0.02));
        assert_eq!(result, constant(1.0));
    }

    #[test]
    fn the_noisy_image_stays_where_its_noise_is_small() {
        let result = blend(&constant(1.0), &constant(1.1), &constant(1e-6));
        assert!(result.data.iter().all(|v| (v - 1.1).abs() < 1e-3));
    }

    #[test]
    fn an_unknown_variance_leaves_the_filtered_image() {
        let result = blend(&constant(1.0), &constant(1.1), &constant(f32::INFINITY));
        assert_eq!(result, constant(1.0));
        let nothing = blend(&constant(0.0), &constant(0.0), &constant(0.0));
        assert_eq!(nothing, constant(0.0));
    }
}
