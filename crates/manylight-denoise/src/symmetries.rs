//! A filter beyond the borders of an image, and averaged over reflections of it.
//!
//! Near a border the library darkens and brightens: the pixels of a constant image of 0.5 become
//! 0.45 to 0.60. A margin of mirrored pixels takes these errors. The library does not commute with
//! reflections, so that its results for an image and its reflections have partly independent
//! errors.

use crate::oidn::{Features, FilterError, Oidn};
use manylight::image::Image;
use std::sync::atomic::AtomicBool;

/// Width of the margin, in pixels: a multiple of 16, because shifts by other offsets change the
/// result throughout the image. Margins of 32 and 64 gain nothing more (staircase2 at 192x192, 16
/// samples of path tracing: relMSE 0.00461 without, 0.00454, 0.00455, 0.00455).
const MARGIN: usize = 16;

/// Most pixels of an image that is averaged over all four reflections; larger ones are filtered
/// once. Margin and average together have 0.92 to 0.98 times the relMSE (six scenes, `path` with
/// 16 passes and `rich-vpl` with 4). A filter takes 5 to 7 µs of one core per pixel and term: four
/// filters of five terms take 35 s of one core at this size.
const MAX_AVERAGED_PIXELS: usize = 1 << 18;

/// A reflection of an image.
#[derive(Clone, Copy, Debug)]
struct Reflection {
    /// Columns are reversed.
    x: bool,
    /// Rows are reversed.
    y: bool,
}

/// All reflections, the image itself first.
const REFLECTIONS: [Reflection; 4] = [
    Reflection { x: false, y: false },
    Reflection { x: true, y: false },
    Reflection { x: false, y: true },
    Reflection { x: true, y: true },
];

/// The filtered `radiance`: as [`Oidn::filter`], without its errors at borders, and averaged over
/// reflections if the image is small.
///
/// # Errors
/// As [`Oidn::filter`].
pub(crate) fn filter_by_symmetries(
    oidn: &Oidn,
    radiance: &Image,
    features: Option<Features>,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    let reflections = match is_small(radiance.width * radiance.height) {
        true => &REFLECTIONS[..],
        false => &REFLECTIONS[..1],
    };
    filter_reflections(oidn, radiance, features, reflections, cancel)
}

/// Whether images of this number of pixels are averaged over reflections.
pub(crate) fn is_small(pixels: usize) -> bool {
    pixels <= MAX_AVERAGED_PIXELS
}

/// [`filter_by_symmetries`] without reflections, in a fourth of its time.
///
/// # Errors
/// As [`Oidn::filter`].
pub(crate) fn filter_once(
    oidn: &Oidn,
    radiance: &Image,
    features: Option<Features>,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    filter_reflections(oidn, radiance, features, &REFLECTIONS[..1], cancel)
}

/// The mean over `reflections` of the filtered `radiance`.
fn filter_reflections(
    oidn: &Oidn,
    radiance: &Image,
    features: Option<Features>,
    reflections: &[Reflection],
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    let mut mean = Image::new(radiance.width, radiance.height, radiance.channels);
    for &reflection in reflections {
        let images = features.map(|Features { albedo, normal }| {
            [albedo, normal].map(|image| reflection.with_margin(image))
        });
        let features = (images.as_ref()).map(|[albedo, normal]| Features { albedo, normal });
        let filtered = oidn.filter(&reflection.with_margin(radiance), features, cancel)?;
        reflection.add_inner(&filtered, 1.0 / reflections.len() as f32, &mut mean);
    }
    Ok(mean)
}

/// Index in a sequence of `count` elements that is continued by its mirror images at both ends, for
/// `place` elements after the start of the margin.
fn mirrored(place: usize, count: usize) -> usize {
    let period = 2 * count;
    let place = (place + period * MARGIN.div_ceil(period) - MARGIN) % period;
    place.min(period - 1 - place)
}

/// Offset of pixel (x, y) in the values of `image`.
fn offset(image: &Image, x: usize, y: usize) -> usize {
    (y * image.width + x) * image.channels
}

impl Reflection {
    /// The reflected `image` with its margin.
    fn with_margin(self, image: &Image) -> Image {
        let (width, height) = (image.width + 2 * MARGIN, image.height + 2 * MARGIN);
        let mut result = Image::new(width, height, image.channels);
        result.data.clear();
        for y in 0..height {
            for x in 0..width {
                let [x, y] = self.of([x, y], [width, height]);
                let at = offset(image, mirrored(x, image.width), mirrored(y, image.height));
                let pixel = &image.data[at..at + image.channels];
                result.data.extend_from_slice(pixel);
            }
        }
        result
    }

    /// Adds the part of `image` within its margin to `sum`, reflected back, times `weight`.
    fn add_inner(self, image: &Image, weight: f32, sum: &mut Image) {
        for y in 0..sum.height {
            for x in 0..sum.width {
                let from = self.of([x + MARGIN, y + MARGIN], [image.width, image.height]);
                let (from, to) = (offset(image, from[0], from[1]), offset(sum, x, y));
                for channel in 0..sum.channels {
                    sum.data[to + channel] += weight * image.data[from + channel];
                }
            }
        }
    }

    /// Column and row of the pixel that comes to this column and row of an image of this size.
    fn of(self, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> [usize; 2] {
        [
            if self.x { width - 1 - x } else { x },
            if self.y { height - 1 - y } else { y },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Different values in all pixels.
    fn numbered(width: usize, height: usize) -> Image {
        Image {
            data: (0..width * height * 3).map(|i| i as f32).collect(),
            ..Image::new(width, height, 3)
        }
    }

    #[test]
    fn reflections_come_back_to_the_image() {
        for (width, height) in [(8, 9), (1, 40), (37, 16)] {
            let image = numbered(width, height);
            for reflection in REFLECTIONS {
                let mut back = Image::new(width, height, 3);
                reflection.add_inner(&reflection.with_margin(&image), 1.0, &mut back);
                assert_eq!(back, image, "{reflection:?}");
            }
        }
    }

    #[test]
    fn a_margin_mirrors_the_image() {
        let image = numbered(20, 18);
        let padded = REFLECTIONS[0].with_margin(&image);
        for (x, y, at) in [(15, 16, (0, 0)), (12, 15, (3, 0)), (36, 34, (19, 17))] {
            assert_eq!(padded.pixel(x, y), image.pixel(at.0, at.1), "{x} {y}");
        }
        assert!((0..64).all(|place| mirrored(place, 1) == 0));
    }
}
