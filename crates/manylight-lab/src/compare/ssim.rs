//! Structural similarity of display-referred images.
//!
//! Source: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to
//! Structural Similarity", 2004, with its window and constants, on the luma of sRGB values in [0,
//! 1]. The mean is over the windows that lie inside of the image.

use super::image::ComparisonImage;
use super::planes::{convolve, displayable, normalized};
use manylight_io::image::srgb_from_linear;

/// Pixels from the center of the window to its edge: the window has 11x11 pixels.
const WINDOW_RADIUS: usize = 5;
/// Standard deviation of the Gaussian window, in pixels.
const WINDOW_SIGMA: f32 = 1.5;
/// C₁ = (0.01 L)² with the range L = 1: stabilizes the quotient of means.
const C1: f32 = 0.01 * 0.01;
/// C₂ = (0.03 L)²: stabilizes the quotient of variances.
const C2: f32 = 0.03 * 0.03;
/// Weights of R, G and B in the luma of Rec. 601.
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

/// Mean structural similarity; `None` for images smaller than the window. Values that are not
/// finite count as black.
pub fn ssim(image: &ComparisonImage, reference: &ComparisonImage) -> Option<f64> {
    let (width, height) = (reference.width, reference.height);
    if width.min(height) <= 2 * WINDOW_RADIUS {
        return None;
    }
    let (x, r) = (luma(image), luma(reference));
    let taps = (0..=2 * WINDOW_RADIUS).map(|i| {
        let offset = i as f32 - WINDOW_RADIUS as f32;
        (-0.5 * (offset / WINDOW_SIGMA).powi(2)).exp()
    });
    let window = normalized(taps.collect());
    let mean = |values: &[f32]| convolve(values, width, &window, &window);
    let mean_of_product = |a: &[f32], b: &[f32]| {
        let product: Vec<f32> = a.iter().zip(b).map(|(a, b)| a * b).collect();
        mean(&product)
    };
    let (mx, mr) = (mean(&x), mean(&r));
    let (xx, rr, xr) = (
        mean_of_product(&x, &x),
        mean_of_product(&r, &r),
        mean_of_product(&x, &r),
    );
    let at = |i: usize| {
        let (vx, vr) = (xx[i] - mx[i] * mx[i], rr[i] - mr[i] * mr[i]);
        let covariance = xr[i] - mx[i] * mr[i];
        let means = (2.0 * mx[i] * mr[i] + C1) / (mx[i] * mx[i] + mr[i] * mr[i] + C1);
        f64::from(means * (2.0 * covariance + C2) / (vx + vr + C2))
    };
    let rows = WINDOW_RADIUS..height - WINDOW_RADIUS;
    let inside =
        rows.flat_map(|y| (WINDOW_RADIUS..width - WINDOW_RADIUS).map(move |x| y * width + x));
    let count = (width - 2 * WINDOW_RADIUS) * (height - 2 * WINDOW_RADIUS);
    Some(inside.map(at).sum::<f64>() / count as f64)
}

fn luma(image: &ComparisonImage) -> Vec<f32> {
    let stored = |v: f32| srgb_from_linear(displayable(v).min(1.0));
    let pixels = image.rgb.iter();
    pixels
        .map(|rgb| (0..3).map(|c| LUMA[c] * stored(rgb[c])).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, ramp, ramp_and_spots};
    use super::*;

    /// The value of scikit-image 0.26 with the same window, `structural_similarity(...,
    /// gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)`.
    #[test]
    fn the_value_is_that_of_scikit_image() {
        let (image, reference) = (frame(ramp_and_spots), frame(ramp));
        let own = ssim(&image, &reference).unwrap();
        assert!((own - 0.557_624_93).abs() < 1e-4, "{own}");
        assert!((ssim(&reference, &reference).unwrap() - 1.0).abs() < 1e-6);
        let small = ComparisonImage {
            width: 480,
            height: 4,
            ..reference
        };
        assert_eq!(ssim(&small, &small), None);
    }
}
