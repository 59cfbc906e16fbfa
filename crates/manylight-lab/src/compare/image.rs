//! The channels of an image that a comparison needs.

use super::layers::{self, Found, NotFound};
use crate::noise::{self, BLOCK_ERROR, BLOCK_VARIANCE, ERROR, MeanNoise, NOISY, VARIANCE};
use manylight_io::image::LayeredImage;
use std::fmt;

/// An image with what is known of its noise, for comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear RGB values, row by row.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of each value of `rgb`; `None` if it is not known.
    pub variance: Option<Vec<[f32; 3]>>,
    /// How the noise of different pixels is correlated.
    pub correlation: NoiseCorrelation,
    /// Error bars; `None` if they are not known.
    pub bars: Option<ErrorBars>,
    /// Emitted radiance seen directly or through specular reflection and refraction; `None` if it
    /// is not known.
    pub emission: Option<Vec<[f32; 3]>>,
    /// The light groups; none for a layer.
    pub light: LightGroups,
}

/// The light groups of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightGroups {
    /// The name and the linear RGB values of each group, row by row.
    pub groups: Vec<(String, Vec<[f32; 3]>)>,
    /// What the groups add up to, where this is not the image: the image before it was denoised.
    pub sum: Option<Vec<[f32; 3]>>,
}

/// Half-widths of the intervals at 95 % around the values of an image, per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorBars {
    /// Of each pixel.
    pub pixels: Vec<[f32; 3]>,
    /// For each pixel, of the mean over the 8x8 block around it.
    pub blocks: Vec<[f32; 3]>,
}

/// What is known of the correlation between the noise of different pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum NoiseCorrelation {
    /// The noise of pixels is independent.
    None,
    /// The noise is correlated by an unknown amount.
    Unknown,
    /// The noise is correlated, and the variances of means over many pixels are known.
    Known {
        /// For each pixel, variance of the mean over the 8x8 block around it.
        blocks: Vec<[f32; 3]>,
        /// Variances of the mean over the whole image.
        mean: MeanNoise,
    },
}

/// An image file lacks the color channels of the image or of the requested layer.
#[derive(Debug, PartialEq, Eq)]
pub struct ImageChannelsError {
    /// The requested layer; `None` for the image.
    layer: Option<String>,
    reason: NotFound,
}

impl ImageChannelsError {
    /// Whether several layers have the requested name.
    pub fn is_ambiguous(&self) -> bool {
        matches!(self.reason, NotFound::Several(_))
    }
}

impl std::error::Error for ImageChannelsError {}

impl fmt::Display for ImageChannelsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.reason, &self.layer) {
            (NotFound::Missing(channels), layer) => {
                match layer {
                    Some(layer) => write!(f, "no layer `{layer}`")?,
                    None => f.write_str("no channels R, G, B or Y")?,
                }
                write!(f, "; found: {}", channels.join(", "))
            }
            (NotFound::Several(layers), Some(layer)) => {
                write!(f, "several layers end in `{layer}`: {}", layers.join(", "))
            }
            (NotFound::Several(layers), None) => write!(f, "several images: {}", layers.join(", ")),
        }
    }
}

impl ComparisonImage {
    /// An image of linear RGB values, row by row, without information on noise or emitters.
    ///
    /// # Panics
    /// If `rgb` does not have `width * height` pixels.
    pub fn from_rgb(width: usize, height: usize, rgb: Vec<[f32; 3]>) -> Self {
        assert_eq!(rgb.len(), width * height, "one value per pixel");
        ComparisonImage {
            width,
            height,
            rgb,
            variance: None,
            correlation: NoiseCorrelation::None,
            bars: None,
            emission: None,
            light: LightGroups::default(),
        }
    }

    /// Takes the channels of the image, or of the layer `layer`, from `picture`. A gray image is
    /// used for all three channels, and in files as Blender writes them the image is the layer
    /// `Combined`. The end of a name, such as `Combined` of `ViewLayer.Combined`, finds a layer if
    /// only one has it. The variance of a layer is not known, nor that of a denoised
    /// image: the variances in its file are those of the layer [`NOISY`].
    ///
    /// # Errors
    /// `picture` lacks these channels, or several layers have the name.
    pub fn new(picture: &LayeredImage, layer: Option<&str>) -> Result<Self, ImageChannelsError> {
        let found = layers::find(picture, layer).map_err(|reason| ImageChannelsError {
            layer: layer.map(String::from),
            reason,
        })?;
        let beside = |name: &str| found.beside(picture, name).map(|found| found.rgb());
        let denoised = beside(NOISY).is_some();
        let has_variance = found.is(NOISY) || found.is_image() && !denoised;
        let known = |variance: &Vec<[f32; 3]>| variance.iter().flatten().all(|v| v.is_finite());
        Ok(ComparisonImage {
            width: picture.width,
            height: picture.height,
            rgb: found.rgb(),
            variance: beside(VARIANCE).filter(|v| has_variance && known(v)),
            correlation: match beside(BLOCK_VARIANCE) {
                _ if denoised && !has_variance => NoiseCorrelation::Unknown,
                None => NoiseCorrelation::None,
                Some(blocks) => match noise::read(picture) {
                    Some(mean) if known(&blocks) => NoiseCorrelation::Known { blocks, mean },
                    _ => NoiseCorrelation::Unknown,
                },
            },
            bars: match (beside(ERROR), beside(BLOCK_ERROR)) {
                (Some(pixels), Some(blocks))
                    if found.is_image() && known(&pixels) && known(&blocks) =>
                {
                    Some(ErrorBars { pixels, blocks })
                }
                _ => None,
            },
            emission: beside("emission"),
            light: match found.is_image() {
                true => LightGroups::of(picture, &found),
                false => LightGroups::default(),
            },
        })
    }

    /// Whether all values of pixel `i` are finite.
    pub fn is_finite(&self, i: usize) -> bool {
        self.rgb[i].iter().all(|v| v.is_finite())
    }

    /// Whether `emission` is known and not black in pixel `i`.
    pub fn sees_emitter(&self, i: usize) -> bool {
        self.emission
            .as_ref()
            .is_some_and(|emission| emission[i] != [0.0; 3])
    }
}

impl LightGroups {
    /// The light groups of the image `found`.
    fn of(picture: &LayeredImage, found: &Found) -> Self {
        let groups = found.light_groups(picture).into_iter();
        let groups: Vec<_> = groups
            .map(|(name, group)| (name.to_owned(), group.rgb()))
            .collect();
        let noisy = found.beside(picture, NOISY).map(|noisy| noisy.rgb());
        LightGroups {
            sum: noisy.filter(|_| !groups.is_empty()),
            groups,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight_io::image::ImageLayer;

    fn picture(channels: &[(&str, f32)]) -> LayeredImage {
        let channels = channels
            .iter()
            .map(|&(name, v)| (name.to_string(), vec![v; 2]))
            .collect();
        let layers = vec![ImageLayer {
            name: String::new(),
            channels,
        }];
        LayeredImage {
            width: 2,
            height: 1,
            layers,
            ..LayeredImage::default()
        }
    }

    #[test]
    fn channels_are_found_by_name() {
        let frame = ComparisonImage::new(
            &picture(&[
                ("B", 3.0),
                ("G", 2.0),
                ("R", 1.0),
                ("emission.R", 0.0),
                ("emission.G", 0.0),
                ("emission.B", 0.5),
            ]),
            None,
        )
        .unwrap();
        assert_eq!(frame.rgb, [[1.0, 2.0, 3.0]; 2]);
        assert_eq!(frame.variance, None);
        assert!(frame.sees_emitter(1));
        let layered = picture(&[("direct.R", 1.0), ("direct.G", 2.0), ("direct.B", 3.0)]);
        assert_eq!(
            ComparisonImage::new(&layered, Some("direct")).unwrap().rgb,
            [[1.0, 2.0, 3.0]; 2]
        );
        let missing = ComparisonImage::new(&layered, Some("caustics")).unwrap_err();
        assert_eq!(
            missing.to_string(),
            "no layer `caustics`; found: direct.R, direct.G, direct.B"
        );
        assert_eq!(
            ComparisonImage::new(&picture(&[("Y", 4.0)]), None)
                .unwrap()
                .rgb,
            [[4.0; 3]; 2]
        );
        assert!(
            ComparisonImage::new(&picture(&[("depth.Z", 4.0)]), None)
                .unwrap_err()
                .to_string()
                .contains("depth.Z")
        );
    }

    #[test]
    fn noise_in_common_is_known_from_two_batches_on() {
        let with = |batches: &str, v| {
            let rgb = [("R", 1.0), ("G", 1.0), ("B", 1.0)];
            let blocks = ["R", "G", "B"].map(|c| (format!("block_variance.{c}"), v));
            let blocks: Vec<(&str, f32)> = blocks.iter().map(|(n, v)| (n.as_str(), *v)).collect();
            let mut picture = picture(&[rgb.as_slice(), &blocks].concat());
            picture.metadata = [
                ("batches", batches.to_string()),
                ("variance_of_mean", [v; 3].map(|v| v.to_string()).join(" ")),
                ("variance_of_mean.without_emission", "0 0.5 1e-3".into()),
            ]
            .map(|(name, value)| (name.to_string(), value))
            .to_vec();
            ComparisonImage::new(&picture, None).unwrap().correlation
        };
        assert_eq!(with("1", f32::INFINITY), NoiseCorrelation::Unknown);
        let mean = MeanNoise {
            batches: 3,
            beauty: [0.25; 3],
            without_emission: [0.0, 0.5, 0.001],
        };
        let blocks = vec![[0.25; 3]; 2];
        assert_eq!(with("3", 0.25), NoiseCorrelation::Known { blocks, mean });
    }

    #[test]
    fn the_variances_of_a_denoised_image_belong_to_the_noisy_one() {
        let rgb = |prefix: &str, v| ["R", "G", "B"].map(|c| (format!("{prefix}{c}"), v));
        let channels = [
            rgb("", 1.0),
            rgb("noisy.", 2.0),
            rgb("variance.", 0.25),
            rgb("block_variance.", 0.25),
        ];
        let channels = channels.as_flattened();
        let channels: Vec<(&str, f32)> = channels.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        let picture = picture(&channels);
        let denoised = ComparisonImage::new(&picture, None).unwrap();
        assert_eq!((denoised.rgb[0], denoised.variance), ([1.0; 3], None));
        assert_eq!(denoised.correlation, NoiseCorrelation::Unknown);
        let noisy = ComparisonImage::new(&picture, Some(NOISY)).unwrap();
        assert_eq!(
            (noisy.rgb[0], noisy.variance),
            ([2.0; 3], Some(vec![[0.25; 3]; 2]))
        );
    }

    #[test]
    fn the_light_groups_of_an_image_are_found() {
        let rgb = |prefix: &str, v| ["R", "G", "B"].map(|c| (format!("{prefix}{c}"), v));
        for (image, scene) in [("", ""), ("View.Combined.", "View.")] {
            let channels = [
                rgb(image, 3.0),
                rgb(&format!("{scene}noisy."), 3.5),
                rgb(&format!("{scene}Combined_key."), 2.0),
                rgb(&format!("{scene}variance_Combined_key."), 0.1),
                rgb("Other.Combined_rim.", 1.0),
            ];
            let channels = channels.as_flattened();
            let channels: Vec<_> = channels.iter().map(|(n, v)| (n.as_str(), *v)).collect();
            let picture = picture(&channels);
            let light = |layer| ComparisonImage::new(&picture, layer).unwrap().light;
            let groups = vec![("key".to_owned(), vec![[2.0; 3]; 2])];
            let sum = Some(vec![[3.5; 3]; 2]);
            assert_eq!(light(None), LightGroups { groups, sum });
            assert_eq!(light(Some("noisy")), LightGroups::default(), "a layer");
        }
    }

    #[test]
    fn infinite_variance_is_unknown_variance() {
        let with = |v| {
            let rgb = [("R", 1.0), ("G", 1.0), ("B", 1.0)];
            let variance = [("variance.R", v), ("variance.G", v), ("variance.B", v)];
            ComparisonImage::new(&picture(&[rgb, variance].concat()), None)
                .unwrap()
                .variance
        };
        assert_eq!(with(f32::INFINITY), None);
        assert_eq!(with(0.25), Some(vec![[0.25; 3]; 2]));
    }
}
