//! A plain raster of `f32` values: the currency between textures, film and files.

use crate::color::Rgb;

/// `height` rows of `width` pixels of `channels` values, rows from top to bottom, channels interleaved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values in a pixel.
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

    /// The values of the pixel in column `x`, row `y` (row 0 on top).
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> &[f32] {
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }

    /// The pixel as a colour; a one-channel image is grey. Two-channel images ignore the second (alpha).
    #[inline]
    pub fn rgb(&self, x: usize, y: usize) -> Rgb {
        match *self.pixel(x, y) {
            [r, g, b, ..] => Rgb::new(r, g, b),
            [v, ..] => Rgb::splat(v),
            [] => Rgb::BLACK,
        }
    }
}
