//! Variance of means over a whole image, as metadata of image files.
//!
//! Pixels that share virtual lights have correlated errors. The variance of their mean therefore
//! does not follow from the variances of the pixels, and an image file states it separately.

use manylight::film::Film;
use manylight_io::image::LayeredImage;

/// Variances of means over the image, estimated from independent batches of passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanNoise {
    /// Number of batches in the estimate.
    pub batches: u32,
    /// Variance of the mean of the image, per channel.
    pub beauty: [f64; 3],
    /// Variance of the mean of the image without directly visible emission, per channel.
    pub without_emission: [f64; 3],
}

/// The layer with the image before denoising, in files of denoised images. The variances in the
/// file belong to it.
pub const NOISY: &str = "noisy";

/// The layer with the variance of the mean of each pixel, of the image before denoising.
pub const VARIANCE: &str = "variance";

/// The layer with the variance of the means over 8x8 blocks; all pixels of a block hold its value.
pub const BLOCK_VARIANCE: &str = "block_variance";

/// The layer with the error bars of the pixels: half-widths of intervals at 95 % around the image,
/// which is denoised where there is a layer [`NOISY`].
pub const ERROR: &str = "error";

/// The layer with the error bars of the means over 8x8 blocks; all pixels of a block hold its
/// value.
pub const BLOCK_ERROR: &str = "block_error";

const BATCHES: &str = "batches";
const BEAUTY: &str = "variance_of_mean";
const WITHOUT_EMISSION: &str = "variance_of_mean.without_emission";

/// The number of batches of `film` and its variances as metadata (name, value). Unknown variances,
/// as those of a single batch, are left out.
pub fn metadata(film: &Film) -> Vec<(String, String)> {
    let mut metadata = vec![(BATCHES.to_owned(), film.batches().to_string())];
    for (name, values) in [
        (BEAUTY, film.mean_variance()),
        (WITHOUT_EMISSION, film.mean_variance_without_emission()),
    ] {
        if values.iter().all(|v| v.is_finite()) {
            let text = values.map(|v| format!("{v:e}")).join(" ");
            metadata.push((name.to_owned(), text));
        }
    }
    metadata
}

/// The variances in the metadata of an image; `None` if they are absent or unknown.
pub fn read(picture: &LayeredImage) -> Option<MeanNoise> {
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
                metadata: metadata(film),
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
                assert_eq!(read_back(&film), None, "one batch has no spread");
                let names: Vec<_> = metadata(&film).into_iter().map(|(name, _)| name).collect();
                assert_eq!(names, [BATCHES], "unknown variances are left out");
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
        // Values 1, 2, 4: sample variance 7/3, variance of the mean 7/9.
        let expected = [7.0 / 9.0, 0.0, 28.0 / 9.0];
        for (v, expected) in noise.without_emission.into_iter().zip(expected) {
            assert!((v - expected).abs() < 1e-9, "{v}");
        }
        assert!((noise.beauty[0] / (121.0 * expected[0]) - 1.0).abs() < 1e-9);
    }
}
