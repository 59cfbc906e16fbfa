//! Raster images of `f32` values, shared by textures, film and files.

use crate::color::Rgb;

/// Floor of the squared value in relative errors, as in relMSE, in units of the squared mean of the
/// picture. A larger floor gives dark pixels less weight.
pub const DARK_FLOOR: f32 = 0.01;

/// An image: `height` rows of `width` pixels with `channels` values each. Rows from top to bottom,
/// channels interleaved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Number of pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Number of values in a pixel.
    pub channels: usize,
    /// `width * height * channels` values.
    pub data: Vec<f32>,
}

impl Image {
    /// An image of zeros.
    pub fn new(width: usize, height: usize, channels: usize) -> Self {
        Image {
            width,
            height,
            channels,
            data: vec![0.0; width * height * channels],
        }
    }

    /// The values of the pixel in column `x`, row `y`. Row 0 is the top.
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> &[f32] {
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }

    /// The pixel as a color. Images of one or two channels give gray; a second channel, alpha, is
    /// ignored.
    #[inline]
    pub fn rgb(&self, x: usize, y: usize) -> Rgb {
        match *self.pixel(x, y) {
            [r, g, b, ..] => Rgb::new(r, g, b),
            [v, ..] => Rgb::splat(v),
            [] => Rgb::BLACK,
        }
    }

    /// Gaussian mean around each pixel, with a standard deviation in pixels. Beyond three standard
    /// deviations, and outside of the image, nothing counts.
    pub fn smoothed(&self, stddev: f32) -> Image {
        let radius = (3.0 * stddev).ceil() as usize;
        let weights: Vec<f32> = (0..=radius)
            .map(|i| (-0.5 * (i as f32 / stddev).powi(2)).exp())
            .collect();
        let row = self.width * self.channels;
        let mut result = self.clone();
        for values in result.data.chunks_exact_mut(row.max(1)) {
            let means = weighted_means(values, self.channels, &weights);
            values.copy_from_slice(&means);
        }
        result.data = weighted_means(&result.data, row, &weights);
        result
    }
}

/// Means over neighbors in a sequence of elements of `size` values, with `weights` by distance.
fn weighted_means(values: &[f32], size: usize, weights: &[f32]) -> Vec<f32> {
    let mut sums: Vec<f32> = values.iter().map(|v| weights[0] * v).collect();
    let mut totals = vec![weights[0]; values.len() / size.max(1)];
    let add = |sums: &mut [f32], values: &[f32], weight: f32| {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    };
    for (distance, &weight) in weights.iter().enumerate().skip(1) {
        let count = totals.len().saturating_sub(distance);
        let (inner, offset) = (count * size, distance * size);
        if count > 0 {
            add(&mut sums[..inner], &values[offset..], weight);
            add(&mut sums[offset..], &values[..inner], weight);
            totals[..count]
                .iter_mut()
                .for_each(|total| *total += weight);
            totals[distance..]
                .iter_mut()
                .for_each(|total| *total += weight);
        }
    }
    for (sums, total) in sums.chunks_exact_mut(size.max(1)).zip(&totals) {
        sums.iter_mut().for_each(|sum| *sum /= total);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_constants() {
        let image = Image {
            data: vec![0.7; 20 * 11 * 3],
            ..Image::new(20, 11, 3)
        };
        let smooth = image.smoothed(3.0);
        assert!(smooth.data.iter().all(|v| (v - 0.7).abs() < 1e-5));
    }

    #[test]
    fn smoothing_keeps_the_sum_within_the_image() {
        let mut image = Image::new(41, 39, 3);
        image.data[(19 * 41 + 20) * 3 + 1] = 5.0;
        let smooth = image.smoothed(3.0);
        let sum = |c: usize| smooth.data.iter().skip(c).step_by(3).sum::<f32>();
        assert!((sum(1) - 5.0).abs() < 1e-3 && sum(0) == 0.0, "{}", sum(1));
    }
}
