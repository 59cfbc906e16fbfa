//! Whether a reference lies within the error bars of an image.

use super::blocks::{BLOCK_SIZE, ImageNoise, PixelBlock};
use super::image::ComparisonImage;
use serde::Serialize;

/// Half-width of a normal interval that holds 95 %, in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Fractions of the values `x` with `|x - r| <= √(bar² + (1.96 σ)²)`, with `σ` the standard error
/// of the reference, or 0 if it is not known. 0.95 is expected of true bars.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BarCoverage {
    /// Of pixels and channels.
    pub pixels: f64,
    /// Of the means over 8x8 blocks, per channel.
    pub blocks: f64,
}

/// Coverage of the kept pixels, and of blocks without other pixels; `None` if the image has no bars.
pub(super) fn bar_coverage(
    image: &ComparisonImage,
    reference: &ComparisonImage,
    kept: &[bool],
) -> Option<BarCoverage> {
    let bars = image.bars.as_ref()?;
    let noise = ImageNoise::of(reference);
    let is_inside = |difference: f64, bar: f32, variance: f64| {
        difference.abs() <= f64::from(bar).hypot(NORMAL_95 * variance.sqrt())
    };
    let (mut pixels, mut blocks) = (Share::default(), Share::default());
    for y in (0..image.height).step_by(BLOCK_SIZE) {
        for x in (0..image.width).step_by(BLOCK_SIZE) {
            let block = PixelBlock::new(image, [x, y], kept);
            for c in 0..3 {
                let difference =
                    |i: usize| f64::from(image.rgb[i][c]) - f64::from(reference.rgb[i][c]);
                let mut sum = 0.0;
                for &i in &block.pixels {
                    let variance = noise.as_ref().map_or(0.0, |noise| noise.of_pixel(i, c));
                    pixels.add(is_inside(difference(i), bars.pixels[i][c], variance));
                    sum += difference(i);
                }
                let (true, Some(&first)) = (block.is_whole, block.pixels.first()) else {
                    continue;
                };
                let count = block.pixels.len() as f64;
                let of_sum = (noise.as_ref()).map_or(0.0, |noise| noise.of_sum(&block, c).value);
                let (mean, variance) = (sum / count, of_sum / (count * count));
                blocks.add(is_inside(mean, bars.blocks[first][c], variance));
            }
        }
    }
    Some(BarCoverage {
        pixels: pixels.value(),
        blocks: blocks.value(),
    })
}

/// A fraction of counted things.
#[derive(Default)]
struct Share {
    inside: usize,
    all: usize,
}

impl Share {
    fn add(&mut self, is_inside: bool) {
        self.inside += usize::from(is_inside);
        self.all += 1;
    }

    /// 0 of nothing.
    fn value(&self) -> f64 {
        self.inside as f64 / self.all.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::image::ErrorBars;
    use super::*;

    /// Bars of 0.1 for pixels and 0.02 for blocks around 1.
    fn image() -> ComparisonImage {
        let bars = ErrorBars {
            pixels: vec![[0.1; 3]; 128],
            blocks: vec![[0.02; 3]; 128],
        };
        ComparisonImage {
            bars: Some(bars),
            ..ComparisonImage::from_rgb(16, 8, vec![[1.0; 3]; 128])
        }
    }

    #[test]
    fn a_reference_is_inside_or_outside() {
        // A checkerboard of ±0.05 on the left, 0.05 more on the right; one pixel is far off.
        let value = |i: usize| match (i % 16 < 8, (i + i / 16) % 2) {
            (true, parity) => 0.95 + 0.1 * parity as f32,
            (false, _) => 1.05,
        };
        let mut rgb: Vec<[f32; 3]> = (0..128).map(|i| [value(i); 3]).collect();
        let reference = ComparisonImage::from_rgb(16, 8, rgb.clone());
        let coverage = |reference: &ComparisonImage, kept: &[bool]| {
            let coverage = bar_coverage(&image(), reference, kept).unwrap();
            (coverage.pixels, coverage.blocks)
        };
        assert_eq!(coverage(&reference, &[true; 128]), (1.0, 0.5));
        rgb[3] = [9.0; 3];
        let reference = ComparisonImage::from_rgb(16, 8, rgb);
        let (pixels, blocks) = coverage(&reference, &[true; 128]);
        assert_eq!((pixels, blocks), (127.0 / 128.0, 0.0));
        let kept: Vec<bool> = (0..128).map(|i| i != 3).collect();
        assert_eq!(coverage(&reference, &kept), (1.0, 0.0), "one whole block");
        assert_eq!(bar_coverage(&reference, &image(), &kept), None);
    }

    #[test]
    fn the_noise_of_the_reference_widens_the_bars() {
        let off = ComparisonImage::from_rgb(16, 8, vec![[1.3; 3]; 128]);
        let coverage = |reference| bar_coverage(&image(), &reference, &[true; 128]).unwrap();
        assert_eq!(coverage(off.clone()).pixels, 0.0);
        let noisy = ComparisonImage {
            variance: Some(vec![[0.04; 3]; 128]),
            ..off
        };
        // Blocks: 1.96 * 0.2 / 8 = 0.05 is less than 0.3.
        let coverage = coverage(noisy);
        assert_eq!((coverage.pixels, coverage.blocks), (1.0, 0.0));
    }
}
