//! Images stored by channel, and separable filters.

use rayon::prelude::*;

/// An image with one array per channel.
#[derive(Clone, Debug)]
pub(super) struct ColorPlanes {
    pub(super) width: usize,
    pub(super) channels: [Vec<f32>; 3],
}

impl ColorPlanes {
    /// An image from its pixels, row by row.
    pub(super) fn new(width: usize, pixels: impl Iterator<Item = [f32; 3]>) -> Self {
        let mut channels: [Vec<f32>; 3] = Default::default();
        for pixel in pixels {
            for (channel, v) in channels.iter_mut().zip(pixel) {
                channel.push(v);
            }
        }
        ColorPlanes { width, channels }
    }

    /// The values of channel `c`, row by row.
    pub(super) fn channel(&self, c: usize) -> &[f32] {
        &self.channels[c]
    }

    /// The pixels, row by row.
    pub(super) fn pixels(&self) -> impl Iterator<Item = [f32; 3]> {
        let [r, g, b] = &self.channels;
        let both = r.iter().zip(g).zip(b);
        both.map(|((&r, &g), &b)| [r, g, b])
    }
}

/// `v`, or 0 if it is NaN, infinite or negative.
pub(super) fn displayable(v: f32) -> f32 {
    if v.is_finite() { v.max(0.0) } else { 0.0 }
}

/// `kernel` divided by its sum.
pub(super) fn normalized(mut kernel: Vec<f32>) -> Vec<f32> {
    let sum: f32 = kernel.iter().sum();
    kernel.iter_mut().for_each(|weight| *weight /= sum);
    kernel
}

/// Convolves a channel with rows of `width` values by the separable kernel `along_x` times
/// `along_y`, both of odd length. Outside of the image, the nearest pixel of its border is used.
pub(super) fn convolve(values: &[f32], width: usize, along_x: &[f32], along_y: &[f32]) -> Vec<f32> {
    if values.is_empty() {
        return Vec::new();
    }
    let height = values.len() / width;
    let taps = |kernel: &[f32], at: usize, end: usize, value: &dyn Fn(usize) -> f32| -> f32 {
        let radius = kernel.len() / 2;
        let place = |k: usize| (at + k).saturating_sub(radius).min(end - 1);
        (kernel.iter().enumerate())
            .map(|(k, weight)| weight * value(place(k)))
            .sum()
    };
    let rows = values
        .par_chunks_exact(width)
        .flat_map_iter(|row| (0..width).map(move |x| taps(along_x, x, width, &|x| row[x])));
    let rows: Vec<f32> = rows.collect();
    let pixels = (0..values.len()).into_par_iter();
    pixels
        .map(|i| taps(along_y, i / width, height, &|y| rows[y * width + i % width]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_go_on_and_weights_add_up() {
        let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
        assert_eq!(convolve(&values, 4, &[1.0], &[1.0]), values);
        let shifted = convolve(&values, 4, &[1.0, 0.0, 0.0], &[0.0, 0.0, 1.0]);
        assert_eq!(&shifted[..4], [4.0, 4.0, 5.0, 6.0]);
        assert_eq!(&shifted[8..], [8.0, 8.0, 9.0, 10.0]);
        let flat = convolve(&[3.0; 6], 2, &[0.25, 0.5, 0.25], &[0.2; 5]);
        assert!(flat.iter().all(|v| (v - 3.0).abs() < 1e-6));
        assert!(convolve(&[], 0, &[1.0], &[1.0]).is_empty());
    }
}
