//! Structural similarity of what a screen shows.
//!
//! Source: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", 2004, with its window
//! and constants, on the luma of sRGB values in [0, 1]. The mean is over windows inside the picture.

use super::Frame;
use super::planes::{convolve, normalized, shown};
use manylight_io::image::srgb_from_linear;

/// Half the window less the pixel in its middle, and its standard deviation, in pixels.
const RADIUS: usize = 5;
const SIGMA: f32 = 1.5;
/// Keep quotients of small numbers stable.
const C1: f32 = 0.01 * 0.01;
const C2: f32 = 0.03 * 0.03;
/// Rec. 601, as is usual.
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

/// The mean; `None` for pictures that are smaller than the window. What is not finite counts as black.
pub(super) fn ssim(image: &Frame, reference: &Frame) -> Option<f64> {
    let (width, height) = (reference.width, reference.height);
    if width.min(height) <= 2 * RADIUS {
        return None;
    }
    let (x, r) = (luma(image), luma(reference));
    let taps = (0..=2 * RADIUS).map(|i| {
        let offset = i as f32 - RADIUS as f32;
        (-0.5 * (offset / SIGMA).powi(2)).exp()
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
    let rows = RADIUS..height - RADIUS;
    let inside = rows.flat_map(|y| (RADIUS..width - RADIUS).map(move |x| y * width + x));
    let count = (width - 2 * RADIUS) * (height - 2 * RADIUS);
    Some(inside.map(at).sum::<f64>() / count as f64)
}

fn luma(frame: &Frame) -> Vec<f32> {
    let stored = |v: f32| srgb_from_linear(shown(v).min(1.0));
    let pixels = frame.rgb.iter();
    pixels
        .map(|rgb| (0..3).map(|c| LUMA[c] * stored(rgb[c])).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, ramp, ramp_and_spots};
    use super::*;

    /// The figure of scikit-image 0.26 with the same window, `structural_similarity(..., gaussian_weights=True, sigma=1.5,
    /// use_sample_covariance=False, data_range=1)`.
    #[test]
    fn what_others_say() {
        let (image, reference) = (frame(ramp_and_spots), frame(ramp));
        let own = ssim(&image, &reference).unwrap();
        assert!((own - 0.557_624_93).abs() < 1e-4, "{own}");
        assert!((ssim(&reference, &reference).unwrap() - 1.0).abs() < 1e-6);
        let small = Frame {
            width: 480,
            height: 4,
            ..reference
        };
        assert_eq!(ssim(&small, &small), None);
    }
}
