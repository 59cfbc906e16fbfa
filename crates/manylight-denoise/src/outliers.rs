//! Whether the light of bright pixels spreads to dark ones in the filter.

use manylight::image::{DARK_FLOOR, Image};

/// Squared change by the filter from which on bright pixels have spread, relative to the variance
/// of the term. In many-lights-bunny, with lamps a thousand times brighter than the rest, it is 176
/// or more; in veach-mis, staircase2 and living-room at most 13 from 8 passes on (`path` with 8, 16
/// and 32 passes, `rich-vpl` with 16).
const SPREADING: f32 = 50.0;

/// Passes below which variances miss rare bright samples: there, [`SPREADING`] grows by the third
/// power of the missing factor. After 4 passes the change is 90 to more than 200 in veach-mis, and
/// 765 or more in many-lights-bunny.
const KNOWN_FROM: f32 = 8.0;

/// Passes below which variances are not used at all. In veach-mis, emission that stays as it is
/// after 2 passes of `path` raises the relative MSE from 0.008 to 0.023 (two of three seeds); after
/// 4 passes the rule leaves the filtered image, 0.004.
const MIN_PASSES: u32 = 4;

/// Whether the filter has spread bright pixels of a term to others. `filtered`, `noisy` and
/// `variance` are those of the term after `passes` passes, `picture` is the beauty. The squared
/// change is the variance plus the squared error of the filter: if it is far above the variance,
/// the filter does more harm than it can do good. Both are relative to the squared radiance of the
/// picture, so that lamps do not decide. All images have the same size.
pub(crate) fn spreads(
    [filtered, noisy]: [&Image; 2],
    variance: &Image,
    picture: &Image,
    passes: u32,
) -> bool {
    if passes < MIN_PASSES {
        return false;
    }
    let squares = (filtered.data.iter().zip(&noisy.data)).map(|(y, x)| (y - x) * (y - x));
    let change = relative_sum(squares, picture);
    let factor = SPREADING * (KNOWN_FROM / passes as f32).max(1.0).powi(3);
    change > factor * relative_sum(variance.data.iter().copied(), picture)
}

/// Sum of squared radiances relative to `p² + 0.01 m²`, where `p` is the pixel of `picture` and `m`
/// its mean.
fn relative_sum(mut squares: impl Iterator<Item = f32>, picture: &Image) -> f32 {
    let mean = picture.data.iter().sum::<f32>() / picture.data.len().max(1) as f32;
    let mut sum = 0.0;
    for pixel in picture.data.chunks_exact(picture.channels.max(1)) {
        let value = pixel.iter().sum::<f32>() / pixel.len() as f32;
        let squares: f32 = squares.by_ref().take(pixel.len()).sum();
        // 0/0 in a black picture.
        sum += squares / (value * value + DARK_FLOOR * mean * mean).max(f32::MIN_POSITIVE);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gray pixels.
    fn gray(value: impl Fn(usize) -> f32) -> Image {
        Image {
            data: (0..1024).flat_map(|i| [value(i); 3]).collect(),
            ..Image::new(32, 32, 3)
        }
    }

    /// A lamp among pixels of this value.
    fn lamp(rest: f32) -> Image {
        gray(|i| if i == 500 { 1e3 } else { rest })
    }

    #[test]
    fn light_of_a_lamp_on_dark_pixels_is_found() {
        let (noisy, picture, variance) = (lamp(0.0), lamp(0.1), gray(|_| 1e-3));
        let spread = |rest, passes| spreads([&lamp(rest), &noisy], &variance, &picture, passes);
        assert!(spread(1e4, 4), "the rule is used");
        assert!(spread(1.0, 8) && !spread(0.2, 8));
        assert!(!spread(1e4, 2), "variances of two passes are not trusted");
    }

    #[test]
    fn noise_that_the_filter_takes_away_is_no_spreading() {
        let noisy = gray(|i| if i % 4 == 0 { 4.0 } else { 0.0 });
        let filtered = gray(|_| 1.0);
        let images = [&filtered, &noisy];
        assert!(!spreads(images, &gray(|_| 3.0), &filtered, 8));
        assert!(!spreads(images, &gray(|_| f32::INFINITY), &filtered, 8));
        let black = gray(|_| 0.0);
        assert!(!spreads([&black, &black], &black, &black, 8));
    }
}
