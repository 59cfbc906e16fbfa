//! Whether the light of bright pixels spreads to dark ones in the filter.

use manylight::image::Image;

/// Squared change by the filter from which on bright pixels have spread, relative to the variance
/// of the picture. It is 7 to 73 in many-lights-bunny, with lamps a thousand times brighter than
/// the rest; at most 2.2 in veach-mis, staircase2 and living-room, but for 47 in veach-mis after 4
/// samples of path tracing (`path` and `rich-vpl`, 4 and 16 passes).
const SPREADING: f32 = 4.0;

/// Whether the filter has spread bright pixels of a term to others. `filtered` and `noisy` are the
/// term, `picture` and `variance` the beauty. The squared change of the term is its variance plus
/// the squared error of the filter: if it is far above the variance of the whole picture, the
/// filter does more harm than it can do good. All are relative to the squared radiance of the
/// picture, so that lamps do not decide. All images have the same size.
pub(crate) fn spreads(filtered: &Image, noisy: &Image, picture: &Image, variance: &Image) -> bool {
    let squares = (filtered.data.iter().zip(&noisy.data)).map(|(y, x)| (y - x) * (y - x));
    let change = relative_sum(squares, picture);
    change > SPREADING * relative_sum(variance.data.iter().copied(), picture)
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
        sum += squares / (value * value + 0.01 * mean * mean).max(f32::MIN_POSITIVE);
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
        assert!(spreads(&lamp(1.0), &noisy, &picture, &variance));
        assert!(!spreads(&lamp(0.03), &noisy, &picture, &variance));
    }

    #[test]
    fn noise_that_the_filter_takes_away_is_no_spreading() {
        let noisy = gray(|i| if i % 4 == 0 { 4.0 } else { 0.0 });
        let filtered = gray(|_| 1.0);
        assert!(!spreads(&filtered, &noisy, &filtered, &gray(|_| 3.0)));
        let unknown = gray(|_| f32::INFINITY);
        assert!(!spreads(&filtered, &noisy, &filtered, &unknown));
        let black = gray(|_| 0.0);
        assert!(!spreads(&black, &black, &black, &black));
    }
}
