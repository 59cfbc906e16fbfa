//! Pictures: named channels in layers, with metadata.

use super::{Content, Transfer, decode, exr_file};
use crate::file_error::{FileError, read_bytes};
use manylight::image::Image;
use std::path::Path;

/// Channels that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// Empty for the beauty layer, else the part of the channels' names before the last dot.
    pub name: String,
    /// Full name, such as `R`, `variance.R` or `depth.Z`, and `width * height` values, rows from top to bottom.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// An image as a renderer makes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Layers; channel names differ throughout.
    pub layers: Vec<Layer>,
    /// Names and values to be kept in the file.
    pub metadata: Vec<(String, String)>,
}

impl Picture {
    /// The values of the channel with this full name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.layers
            .iter()
            .flat_map(|l| &l.channels)
            .find(|(n, _)| n == name)
            .map(|(_, values)| values.as_slice())
    }

    /// The value of a metadata entry.
    pub fn metadata_value(&self, name: &str) -> Option<&str> {
        self.metadata
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, value)| value.as_str())
    }

    /// The beauty layer: `R`, `G`, `B`, or `Y` alone.
    pub(super) fn beauty(&self) -> Option<Image> {
        let names: &[&str] = if self.channel("R").is_some() {
            &["R", "G", "B"]
        } else {
            &["Y"]
        };
        let planes: Option<Vec<&[f32]>> = names.iter().map(|name| self.channel(name)).collect();
        Some(interleave(self.width, self.height, &planes?))
    }

    /// Sorts channels into layers by the part of their names before the last dot; layers in order of appearance.
    pub(super) fn from_channels(
        width: usize,
        height: usize,
        channels: Vec<(String, Vec<f32>)>,
    ) -> Picture {
        let mut layers: Vec<Layer> = Vec::new();
        for (name, values) in channels {
            let layer_name = name.rsplit_once('.').map_or("", |(layer, _)| layer);
            let index = layers
                .iter()
                .position(|l| l.name == layer_name)
                .unwrap_or_else(|| {
                    layers.push(Layer {
                        name: layer_name.to_owned(),
                        channels: Vec::new(),
                    });
                    layers.len() - 1
                });
            layers[index].channels.push((name, values));
        }
        Picture {
            width,
            height,
            layers,
            metadata: Vec::new(),
        }
    }
}

/// One image from planes of equal size.
pub(super) fn interleave(width: usize, height: usize, planes: &[&[f32]]) -> Image {
    let data = (0..width * height)
        .flat_map(|i| planes.iter().map(move |plane| plane[i]))
        .collect();
    Image {
        width,
        height,
        channels: planes.len(),
        data,
    }
}

/// Every channel of an EXR file with its metadata. Other formats give linear `R`, `G`, `B` or `Y`.
pub fn read_picture(path: &Path) -> Result<Picture, FileError> {
    let bytes = read_bytes(path)?;
    let picture = if Content::of(&bytes) == Content::Exr {
        exr_file::read_channels(&bytes)
    } else {
        decode(&bytes, path, Transfer::Auto).map(|image| split(&image))
    };
    picture.map_err(|fault| fault.in_file(path))
}

fn split(image: &Image) -> Picture {
    let names: &[&str] = if image.channels == 3 {
        &["R", "G", "B"]
    } else {
        &["Y"]
    };
    let plane = |c: usize| {
        image
            .data
            .iter()
            .skip(c)
            .step_by(image.channels)
            .copied()
            .collect()
    };
    let channels = names
        .iter()
        .enumerate()
        .map(|(c, name)| ((*name).to_owned(), plane(c)))
        .collect();
    Picture::from_channels(image.width, image.height, channels)
}
