//! What an image file says of the noise of means over many pixels: the names, written and read in one place.
//!
//! Pixels that share virtual lights are off together, so that the variance of a mean over them does not follow from theirs.

use manylight::film::Film;
use manylight_io::image::LayeredImage;

/// Variances of means over the picture, from the spread over batches of passes that have nothing in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeanNoise {
    /// How many batches told.
    pub(crate) batches: u32,
    /// Of the beauty, per channel.
    pub(crate) beauty: [f64; 3],
    /// Of the beauty without what emitters show of themselves.
    pub(crate) without_emission: [f64; 3],
}

const BATCHES: &str = "batches";
const BEAUTY: &str = "variance_of_mean";
const WITHOUT_EMISSION: &str = "variance_of_mean.without_emission";

/// As metadata of an image; variances are `inf` where nothing is known.
pub(crate) fn metadata(film: &Film) -> [(String, String); 3] {
    let text = |values: [f64; 3]| values.map(|v| format!("{v:e}")).join(" ");
    [
        (BATCHES, film.batches().to_string()),
        (BEAUTY, text(film.mean_variance())),
        (
            WITHOUT_EMISSION,
            text(film.mean_variance_without_emission()),
        ),
    ]
    .map(|(name, value)| (name.to_string(), value))
}

/// What the metadata of an image says; `None` where that is nothing.
pub(crate) fn read(picture: &LayeredImage) -> Option<MeanNoise> {
    let values = |name: &str| -> Option<[f64; 3]> {
        let words = picture.metadata_value(name)?.split(' ');
        let values: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>().ok()?;
        let known = values.iter().all(|v| v.is_finite());
        known.then_some(values)?.try_into().ok()
    };
    Some(MeanNoise {
        batches: picture.metadata_value(BATCHES)?.parse().ok()?,
        beauty: values(BEAUTY)?,
        without_emission: values(WITHOUT_EMISSION)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::color::Rgb;
    use manylight::film::{FilmDesc, Filter, Layer};
    use manylight::math::UVec2;
    use std::sync::atomic::{AtomicBool, AtomicU64};

    #[test]
    fn what_is_written_is_read() {
        let size = UVec2::new(3, 2);
        let desc = FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter: Filter::Box,
        };
        let mut film = Film::new(desc, &[Layer::Beauty, Layer::Direct, Layer::Emission]);
        let read_back = |film: &Film| {
            read(&LayeredImage {
                metadata: metadata(film).to_vec(),
                ..LayeredImage::default()
            })
        };
        for value in [1.0, 2.0, 4.0] {
            film.begin_batch();
            film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
                for i in 0..6 {
                    samples.add(i, Layer::Direct, Rgb::new(value, 1.0, 2.0 * value));
                    samples.add(i, Layer::Emission, Rgb::splat(10.0 * value));
                }
            });
            if value < 4.0 {
                assert_eq!(read_back(&film), None, "one batch tells nothing");
            }
        }
        film.begin_batch();
        let noise = read_back(&film).unwrap();
        assert_eq!(noise.batches, 3);
        assert_eq!(noise.beauty, film.mean_variance());
        assert_eq!(
            noise.without_emission,
            film.mean_variance_without_emission()
        );
        // Values 1, 2, 4: sample variance 7/3, of the mean 7/9.
        let expected = [7.0 / 9.0, 0.0, 28.0 / 9.0];
        for (v, expected) in noise.without_emission.into_iter().zip(expected) {
            assert!((v - expected).abs() < 1e-9, "{v}");
        }
        assert!((noise.beauty[0] / (121.0 * expected[0]) - 1.0).abs() < 1e-9);
    }
}
