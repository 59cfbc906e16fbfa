//! Raster images of `f32` values, shared by textures, film and files.

use crate::color::Rgb;

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
}
