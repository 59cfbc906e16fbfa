//! Texture images with 8 bits a channel, and their PNG encoding.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// How samples encode values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelEncoding {
    /// Three channels of color with the sRGB transfer function.
    Srgb,
    /// One channel of values from 0 to 1, stored as 0 to 255.
    Linear,
    /// Three such channels.
    LinearRgb,
}

/// An image with 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PngImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Encoding of the samples.
    pub encoding: PixelEncoding,
    /// Samples, row by row from the top, channels interleaved.
    pub samples: Vec<u8>,
}

impl PngImage {
    /// An image with one channel. `weight` is evaluated at pixel centers; u points right and v
    /// down, both from 0 to 1. Values are clamped to [0, 1].
    pub fn from_weights(size: [u32; 2], weight: impl Fn(f64, f64) -> f64) -> PngImage {
        let samples = pixel_centers(size)
            .map(|(u, v)| byte(weight(u, v)))
            .collect();
        PngImage {
            size,
            encoding: PixelEncoding::Linear,
            samples,
        }
    }

    /// An sRGB image. `color` gives linear RGB and is evaluated as in [`PngImage::from_weights`].
    pub fn from_colors(size: [u32; 2], color: impl Fn(f64, f64) -> [f64; 3]) -> PngImage {
        let samples = pixel_centers(size)
            .flat_map(|(u, v)| color(u, v).map(|c| byte(srgb(c))))
            .collect();
        PngImage {
            size,
            encoding: PixelEncoding::Srgb,
            samples,
        }
    }

    /// An image with three channels of values from 0 to 1, as [`PngImage::from_weights`].
    pub fn from_values(size: [u32; 2], values: impl Fn(f64, f64) -> [f64; 3]) -> PngImage {
        let samples = pixel_centers(size)
            .flat_map(|(u, v)| values(u, v).map(byte))
            .collect();
        PngImage {
            size,
            encoding: PixelEncoding::LinearRgb,
            samples,
        }
    }

    /// The value of the pixel that contains (u, v), repeated outside of [0, 1]: linear RGB, or
    /// three equal weights.
    pub fn value(&self, u: f64, v: f64) -> [f64; 3] {
        let [width, height] = self.size.map(|n| n as usize);
        let cell = |x: f64, n: usize| ((x - x.floor()) * n as f64).min(n as f64 - 1.0) as usize;
        let pixel = cell(v, height) * width + cell(u, width);
        let level = |i: usize| f64::from(self.samples[i]) / 255.0;
        match self.encoding {
            PixelEncoding::Srgb => std::array::from_fn(|c| linear(level(3 * pixel + c))),
            PixelEncoding::Linear => [level(pixel); 3],
            PixelEncoding::LinearRgb => std::array::from_fn(|c| level(3 * pixel + c)),
        }
    }

    /// The image with other colors: `change` gets and gives linear RGB.
    pub fn recolored(&self, change: impl Fn([f64; 3]) -> [f64; 3]) -> PngImage {
        PngImage::from_colors(self.size, |u, v| change(self.value(u, v)))
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// Returns an error if the compressor fails.
    pub fn encode(&self) -> io::Result<Vec<u8>> {
        let (color_type, channels) = match self.encoding {
            PixelEncoding::Srgb => (2, 3),
            PixelEncoding::Linear => (0, 1),
            PixelEncoding::LinearRgb => (2, 3),
        };
        let mut head = Vec::new();
        head.extend(self.size[0].to_be_bytes());
        head.extend(self.size[1].to_be_bytes());
        // Deflate, adaptive filters and no interlace are all encoded as 0.
        head.extend([BIT_DEPTH, color_type, 0, 0, 0]);

        let row = self.size[0] as usize * channels;
        let mut deflated = ZlibEncoder::new(Vec::new(), Compression::best());
        for line in self.samples.chunks(row) {
            let left = |i: usize| if i < channels { 0 } else { line[i - channels] };
            let differences: Vec<u8> = (0..row).map(|i| line[i].wrapping_sub(left(i))).collect();
            deflated.write_all(&[SUB_FILTER])?;
            deflated.write_all(&differences)?;
        }

        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        push_chunk(&mut file, b"IHDR", &head);
        push_chunk(&mut file, b"IDAT", &deflated.finish()?);
        push_chunk(&mut file, b"IEND", &[]);
        Ok(file)
    }
}

/// Bits a channel.
const BIT_DEPTH: u8 = 8;
/// PNG filter "Sub": a byte is stored as its difference from that of the pixel to the left.
const SUB_FILTER: u8 = 1;

fn push_chunk(file: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    crc.update(data);
    file.extend((data.len() as u32).to_be_bytes());
    file.extend(kind);
    file.extend(data);
    file.extend(crc.sum().to_be_bytes());
}

/// Centers (u, v) of all pixels, row by row.
fn pixel_centers([width, height]: [u32; 2]) -> impl Iterator<Item = (f64, f64)> {
    (0..height).flat_map(move |y| {
        (0..width).map(move |x| {
            (
                (f64::from(x) + 0.5) / f64::from(width),
                (f64::from(y) + 0.5) / f64::from(height),
            )
        })
    })
}

/// `x` in [0, 1] as the nearest of 256 levels.
fn byte(x: f64) -> u8 {
    // Just over one half, so that an exact tie rounds up even if the last bit of x differs between
    // platforms.
    (x.clamp(0.0, 1.0) * 255.0 + 0.500_001).floor().min(255.0) as u8
}

/// The sRGB transfer function (IEC 61966-2-1).
fn srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// The inverse of [`srgb`].
fn linear(x: f64) -> f64 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_has_its_signature_and_size() {
        let png = PngImage::from_colors([3, 2], |u, v| [u, v, 0.0])
            .encode()
            .unwrap();
        assert_eq!(&png[1..4], b"PNG");
        assert_eq!(&png[16..24], [0, 0, 0, 3, 0, 0, 0, 2]);
    }

    #[test]
    fn only_colors_get_the_srgb_transfer_function() {
        let color = PngImage::from_colors([1, 1], |_, _| [0.2140; 3]);
        assert_eq!(color.samples, [127; 3]);
        let weight = PngImage::from_weights([1, 1], |_, _| 0.2);
        assert_eq!(weight.samples, [51]);
        let values = PngImage::from_values([1, 1], |_, _| [0.2, 0.4, 1.0]);
        assert_eq!(values.samples, [51, 102, 255]);
    }

    #[test]
    fn values_are_those_that_were_stored() {
        let image = PngImage::from_colors([4, 2], |u, v| [u, v, 0.5]);
        let [r, g, b] = image.value(0.3, 0.9);
        assert!((r - 0.375).abs() < 4e-3 && (g - 0.75).abs() < 5e-3 && (b - 0.5).abs() < 4e-3);
        assert_eq!(image.value(1.3, -0.1), image.value(0.3, 0.9));
        assert_eq!(image.recolored(|color| color), image);
    }
}
