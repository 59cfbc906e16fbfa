//! What of a film is filtered: each term of the beauty by itself.

use crate::blend::blend;
use crate::features::FeatureImages;
use crate::oidn::{Features, FilterError, Oidn};
use crate::outliers::spreads;
use crate::symmetries::{filter_by_symmetries, filter_once, is_small};
use manylight::film::{ErrorBars, Film, Half, Layer};
use manylight::image::Image;
use manylight::integrators::choice::FilterInput;
use std::sync::atomic::AtomicBool;

/// Least width and height of a film that is filtered, in pixels. The library darkens smaller
/// images: a single pixel of 0.5 becomes 0.09, and the mean of 2x2 pixels 0.37; that of 8x8 stays.
const MIN_SIZE: u32 = 8;

/// A denoised image of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct DenoisedImage {
    /// The image.
    pub image: Image,
    /// Its error bars; `None` if they are not known, after few passes.
    pub bars: Option<ErrorBars>,
    /// The light of each group of the film, which sum to the image.
    pub groups: Vec<Image>,
}

/// The denoised image of `film`: the sum of its terms, each of which is filtered and blended with
/// its noisy image by the estimated errors of both. If variances are not known, after a single
/// pass, or if the film has no terms, the beauty is filtered as a whole. Emission stays as it is if
/// the filter spreads its lamps. A film below 8 pixels in width or height is not filtered.
///
/// Light groups are filtered in the same way, and scaled so that they sum to the image.
///
/// The error bars follow from both halves of the passes. Each is denoised in the same way, but
/// without the average over reflections, and large ones as a whole: the bars take half of the time
/// of the picture.
///
/// # Errors
/// `cancel` becomes true, or the library reports an error.
pub fn denoise_film(
    oidn: &Oidn,
    film: &Film,
    features: Option<&FeatureImages>,
    cancel: &AtomicBool,
) -> Result<DenoisedImage, FilterError> {
    if film.image_size().min_element() < MIN_SIZE {
        let groups = light_groups(film).filter_map(|group| film.image(group));
        return Ok(DenoisedImage {
            image: film.image(Layer::Beauty).unwrap_or_default(),
            bars: ErrorBars::of_film(film),
            groups: groups.collect(),
        });
    }
    let noisy = |half| Noisy { film, half };
    let denoise = |half| noisy(half).denoise(oidn, features, cancel);
    let image = denoise(None)?;
    let groups = light_groups(film);
    let groups = groups.map(|group| noisy(None).denoise_layer(oidn, group, features, cancel));
    let groups = scaled_to(&image, groups.collect::<Result<_, _>>()?);
    let counts = film.half_counts();
    let bars = match Half::BOTH.iter().all(|&half| counts.of(half) >= 2) {
        true => {
            let halves = [denoise(Some(Half::First))?, denoise(Some(Half::Second))?];
            ErrorBars::of_filtered(film, &image, halves.each_ref())
        }
        false => None,
    };
    Ok(DenoisedImage {
        image,
        bars,
        groups,
    })
}

/// The light groups of `film`.
fn light_groups(film: &Film) -> impl Iterator<Item = Layer> {
    let layers = film.layers().iter().copied();
    layers.filter(|layer| matches!(layer, Layer::LightGroup(_)))
}

/// `groups`, scaled in each pixel and channel so that they sum to `image`. Where none has light,
/// each has the same part of it.
fn scaled_to(image: &Image, mut groups: Vec<Image>) -> Vec<Image> {
    let equal = 1.0 / groups.len().max(1) as f32;
    for (i, value) in image.data.iter().enumerate() {
        let sum: f32 = groups.iter().map(|group| group.data[i]).sum();
        for group in &mut groups {
            let part = if sum > 0.0 {
                group.data[i] / sum
            } else {
                equal
            };
            group.data[i] = part * value;
        }
    }
    groups
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
    if radiance.width.min(radiance.height) < MIN_SIZE as usize {
        return Ok(radiance.clone());
    }
    oidn.filter(radiance, Some(Features { albedo, normal }), cancel)
}

/// Means over passes of a film, to be denoised.
#[derive(Clone, Copy)]
struct Noisy<'f> {
    film: &'f Film,
    /// The half of the passes; `None`: all.
    half: Option<Half>,
}

impl Noisy<'_> {
    fn denoise(
        self,
        oidn: &Oidn,
        features: Option<&FeatureImages>,
        cancel: &AtomicBool,
    ) -> Result<Image, FilterError> {
        let size = self.film.image_size().as_usizevec2();
        let is_rough = self.half.is_some() && !is_small(size.x * size.y);
        let terms: Vec<Layer> = (self.film.layers().iter().copied())
            .filter(|layer| layer.is_term())
            .collect();
        if terms.is_empty() || self.passes() < 2 || is_rough {
            return self.denoise_layer(oidn, Layer::Beauty, features, cancel);
        }
        let mut sum = Image::new(size.x, size.y, 3);
        for layer in terms {
            let term = self.denoise_layer(oidn, layer, features, cancel)?;
            for (sum, value) in sum.data.iter_mut().zip(&term.data) {
                *sum += value;
            }
        }
        Ok(sum)
    }

    /// One layer, filtered and blended.
    fn denoise_layer(
        self,
        oidn: &Oidn,
        layer: Layer,
        features: Option<&FeatureImages>,
        cancel: &AtomicBool,
    ) -> Result<Image, FilterError> {
        let noisy = self.image(layer);
        if noisy.data.iter().all(|&v| v == 0.0) {
            return Ok(noisy);
        }
        let features = features.map(FeatureImages::features);
        let filtered = match self.half {
            None => filter_by_symmetries(oidn, &noisy, features, cancel)?,
            Some(_) => filter_once(oidn, &noisy, features, cancel)?,
        };
        let variance = self.variance(layer);
        let blended = blend(&filtered, &noisy, &variance);
        // Bright pixels of other terms may be noise, which must be filtered.
        if layer == Layer::Emission {
            let picture = self.image(Layer::Beauty);
            if spreads([&blended, &noisy], &variance, &picture, self.passes()) {
                return Ok(noisy);
            }
        }
        Ok(blended)
    }

    fn passes(self) -> u32 {
        match self.half {
            None => self.film.passes(),
            Some(half) => self.film.half_counts().of(half),
        }
    }

    fn image(self, layer: Layer) -> Image {
        let image = match self.half {
            None => self.film.image(layer),
            Some(half) => self.film.half_image(layer, half),
        };
        image.unwrap_or_default()
    }

    /// Variance of the mean: that over all passes is shared out by the numbers of passes.
    fn variance(self, layer: Layer) -> Image {
        let mut variance = self.film.layer_variance(layer).unwrap_or_default();
        let factor = self.film.passes() as f32 / self.passes().max(1) as f32;
        variance.data.iter_mut().for_each(|v| *v *= factor);
        variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_scaled_to_the_sum() {
        let image = |values: [f32; 3]| Image {
            data: values.to_vec(),
            ..Image::new(1, 1, 3)
        };
        let groups = vec![image([1.0, 0.0, 0.5]), image([3.0, 0.0, 0.0])];
        let scaled = scaled_to(&image([2.0, 0.4, 0.6]), groups);
        assert_eq!(scaled[0].data, [0.5, 0.2, 0.6]);
        assert_eq!(scaled[1].data, [1.5, 0.2, 0.0]);
        assert!(scaled_to(&image([1.0; 3]), Vec::new()).is_empty());
    }
}
