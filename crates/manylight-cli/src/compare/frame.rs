//! The part of an image file that comparisons need.

use crate::noise::{self, MeanNoise};
use manylight_io::image::LayeredImage;
use std::fmt;

/// Beauty, its variance, and the emitters seen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// Linear values, row by row.
    pub(crate) rgb: Vec<[f32; 3]>,
    /// Variance of the mean; `None` if the file has none, or says that it is unknown.
    pub(crate) variance: Option<Vec<[f32; 3]>>,
    /// How means over many pixels vary.
    pub(crate) correlation: Correlation,
    /// Light of emitters seen directly or along specular chains.
    pub(crate) emission: Option<Vec<[f32; 3]>>,
}

/// Whether the noise of pixels is correlated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Correlation {
    /// It is not: each pixel has its own.
    None,
    /// It is, but how much is not known.
    Unknown,
    /// It is, and so much.
    Known {
        /// Variance of the mean over its 8x8 block, for each pixel.
        blocks: Vec<[f32; 3]>,
        /// Over the picture.
        mean: MeanNoise,
    },
}

/// An image without the color channels that are asked for.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct FrameError {
    /// The layer that was asked for, if not the image.
    layer: Option<String>,
    /// The channels that it has.
    channels: Vec<String>,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.layer {
            Some(layer) => write!(f, "no layer `{layer}`")?,
            None => f.write_str("no channels R, G, B or Y")?,
        }
        write!(f, "; found: {}", self.channels.join(", "))
    }
}

impl Frame {
    /// Picks the channels of the image, or of one of its layers, out of a picture; a gray picture counts for all three.
    /// The variance of layers is not known.
    pub(crate) fn new(picture: &LayeredImage, layer: Option<&str>) -> Result<Self, FrameError> {
        let rgb = match layer {
            None => rgb(picture, "").or_else(|| gray(picture)),
            Some(layer) => rgb(picture, &format!("{layer}.")),
        };
        let rgb = rgb.ok_or_else(|| FrameError {
            layer: layer.map(String::from),
            channels: channels(picture).map(|(name, _)| name.clone()).collect(),
        })?;
        let known = |variance: &Vec<[f32; 3]>| variance.iter().flatten().all(|v| v.is_finite());
        Ok(Frame {
            width: picture.width,
            height: picture.height,
            rgb,
            variance: match layer {
                None => self::rgb(picture, "variance.").filter(known),
                Some(_) => None,
            },
            correlation: match self::rgb(picture, "block_variance.") {
                None => Correlation::None,
                Some(blocks) => match noise::read(picture) {
                    Some(mean) if known(&blocks) => Correlation::Known { blocks, mean },
                    _ => Correlation::Unknown,
                },
            },
            emission: self::rgb(picture, "emission."),
        })
    }

    /// Whether pixel `i` is finite.
    pub(crate) fn is_finite(&self, i: usize) -> bool {
        self.rgb[i].iter().all(|v| v.is_finite())
    }

    /// Whether an emitter is known to be seen in pixel `i`.
    pub(crate) fn sees_emitter(&self, i: usize) -> bool {
        self.emission
            .as_ref()
            .is_some_and(|emission| emission[i] != [0.0; 3])
    }
}

fn channels(picture: &LayeredImage) -> impl Iterator<Item = &(String, Vec<f32>)> {
    picture.layers.iter().flat_map(|layer| &layer.channels)
}

fn channel<'p>(picture: &'p LayeredImage, name: &str) -> Option<&'p [f32]> {
    channels(picture)
        .find(|(n, _)| n == name)
        .map(|(_, values)| values.as_slice())
}

fn rgb(picture: &LayeredImage, prefix: &str) -> Option<Vec<[f32; 3]>> {
    let one = |name: &str| channel(picture, &format!("{prefix}{name}"));
    let (r, g, b) = (one("R")?, one("G")?, one("B")?);
    Some(
        r.iter()
            .zip(g)
            .zip(b)
            .map(|((&r, &g), &b)| [r, g, b])
            .collect(),
    )
}

fn gray(picture: &LayeredImage) -> Option<Vec<[f32; 3]>> {
    Some(channel(picture, "Y")?.iter().map(|&y| [y; 3]).collect())
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
            metadata: Vec::new(),
        }
    }

    #[test]
    fn channels_are_found_by_name() {
        let frame = Frame::new(
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
            Frame::new(&layered, Some("direct")).unwrap().rgb,
            [[1.0, 2.0, 3.0]; 2]
        );
        let missing = Frame::new(&layered, Some("caustics")).unwrap_err();
        assert_eq!(
            missing.to_string(),
            "no layer `caustics`; found: direct.R, direct.G, direct.B"
        );
        assert_eq!(
            Frame::new(&picture(&[("Y", 4.0)]), None).unwrap().rgb,
            [[4.0; 3]; 2]
        );
        assert!(
            Frame::new(&picture(&[("depth.Z", 4.0)]), None)
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
            Frame::new(&picture, None).unwrap().correlation
        };
        assert_eq!(with("1", f32::INFINITY), Correlation::Unknown);
        let mean = MeanNoise {
            batches: 3,
            beauty: [0.25; 3],
            without_emission: [0.0, 0.5, 0.001],
        };
        let blocks = vec![[0.25; 3]; 2];
        assert_eq!(with("3", 0.25), Correlation::Known { blocks, mean });
    }

    #[test]
    fn infinite_variance_is_unknown_variance() {
        let with = |v| {
            let rgb = [("R", 1.0), ("G", 1.0), ("B", 1.0)];
            let variance = [("variance.R", v), ("variance.G", v), ("variance.B", v)];
            Frame::new(&picture(&[rgb, variance].concat()), None)
                .unwrap()
                .variance
        };
        assert_eq!(with(f32::INFINITY), None);
        assert_eq!(with(0.25), Some(vec![[0.25; 3]; 2]));
    }
}
