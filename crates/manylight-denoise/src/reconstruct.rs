//! What of a film is filtered.

use crate::blend::blend;
use crate::features::FeatureImages;
use crate::oidn::{FilterError, Oidn};
use manylight::film::{Film, Layer};
use manylight::image::Image;
use std::sync::atomic::AtomicBool;

/// The denoised image of `film`.
///
/// # Errors
/// `cancel` becomes true, or the library reports an error.
pub fn denoise_film(
    oidn: &Oidn,
    film: &Film,
    features: Option<&FeatureImages>,
    cancel: &AtomicBool,
) -> Result<Image, FilterError> {
    let noisy = film.image(Layer::Beauty).unwrap_or_default();
    let features = features.map(FeatureImages::features);
    let filtered = oidn.filter(&noisy, features, cancel)?;
    Ok(blend(&filtered, &noisy, &film.variance()))
}
