//! What of a film is filtered: each term of the beauty by itself.

use crate::blend::blend;
use crate::features::FeatureImages;
use crate::oidn::{Features, FilterError, Oidn};
use crate::outliers::spreads;
use crate::symmetries::filter_by_symmetries;
use manylight::film::{Film, Layer};
use manylight::image::Image;
use manylight::integrators::choice::FilterInput;
use std::sync::atomic::AtomicBool;

/// Least width and height of a film that is filtered, in pixels. The library darkens smaller
/// images: a single pixel of 0.5 becomes 0.09, and the mean of 2x2 pixels 0.37; that of 8x8 stays.
const LEAST_SIZE: u32 = 8;

/// The denoised image of `film`: the sum of its terms, each of which is filtered and blended with
/// its noisy image by the estimated errors of both. If variances are not known, after a single
/// pass, or if the film has no terms, the beauty is filtered as a whole. Emission stays as it is if
/// the filter spreads its lamps. A film below 8 pixels in width or height is not filtered.
///
/// # Errors
/// `cancel` becomes true, or the library reports an error.
pub fn denoise_film(
    oidn: &Oidn,
    film: &Film,
    features: Option<&FeatureImages>,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    if film.image_size().min_element() < LEAST_SIZE {
        return Ok(film.image(Layer::Beauty).unwrap_or_default());
    }
    let terms: Vec<Layer> = (film.layers().iter().copied())
        .filter(|layer| layer.is_term())
        .collect();
    if terms.is_empty() || film.passes() < 2 {
        return denoise_layer(oidn, film, Layer::Beauty, features, cancel);
    }
    let mut sum = Image::new(
        film.image_size().x as usize,
        film.image_size().y as usize,
        3,
    );
    for layer in terms {
        let term = denoise_layer(oidn, film, layer, features, cancel)?;
        for (sum, value) in sum.data.iter_mut().zip(&term.data) {
            *sum += value;
        }
    }
    Ok(sum)
}

/// A picture of the pre-pass of a choice between methods, filtered as a whole and once: margins and
/// reflections change the errors of all methods alike, and take four times as long.
///
/// # Errors
/// `cancel` becomes true, or the library reports an error.
pub fn denoise_picture(
    oidn: &Oidn,
    input: &FilterInput,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    let FilterInput {
        radiance,
        albedo,
        normal,
    } = input;
    if radiance.width.min(radiance.height) < LEAST_SIZE as usize {
        return Ok(radiance.clone());
    }
    oidn.filter(radiance, Some(Features { albedo, normal }), cancel)
}

/// One layer of `film`, filtered and blended.
fn denoise_layer(
    oidn: &Oidn,
    film: &Film,
    layer: Layer,
    features: Option<&FeatureImages>,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    let noisy = film.image(layer).unwrap_or_default();
    if noisy.data.iter().all(|&v| v == 0.0) {
        return Ok(noisy);
    }
    let features = features.map(FeatureImages::features);
    let filtered = filter_by_symmetries(oidn, &noisy, features, cancel)?;
    let variance = film.layer_variance(layer).unwrap_or_default();
    let blended = blend(&filtered, &noisy, &variance);
    // Bright pixels of other terms may be noise, which must be filtered.
    if layer == Layer::Emission {
        let picture = film.image(Layer::Beauty).unwrap_or_default();
        if spreads([&blended, &noisy], &variance, &picture, film.passes()) {
            return Ok(noisy);
        }
    }
    Ok(blended)
}
