//! OpenEXR. Files with any channels are read; written files have one part with 32-bit float channels.

use super::layered::{LayeredImage, interleave};
use crate::file_error::Fault;
use exr::image::read::read;
use exr::image::write::WritableImage;
use exr::image::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatImage, FlatSamples, Layer as Part,
};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, IntegerBounds, ReadChannels, ReadLayers, Vec2};
use manylight::image::Image;
use std::io::Cursor;

/// The color of an EXR file: the channels `R`, `G`, `B`, else `Y`, else those of the first layer that has them, else the only
/// channel.
pub(super) fn read_color(bytes: &[u8]) -> Result<Image, Fault> {
    let layered = read_channels(bytes)?;
    if let Some(image) = layered.beauty() {
        return Ok(image);
    }
    let names: Vec<&str> = layered
        .layers
        .iter()
        .flat_map(|l| &l.channels)
        .map(|(name, _)| name.as_str())
        .collect();
    let find = |layer: &str, suffix: &str| {
        layered.channel(&if layer.is_empty() {
            suffix.to_owned()
        } else {
            format!("{layer}.{suffix}")
        })
    };
    for layer in &layered.layers {
        for suffixes in [
            &["R", "G", "B"][..],
            &["r", "g", "b"],
            &["red", "green", "blue"],
            &["Y"],
        ] {
            let planes: Option<Vec<&[f32]>> = suffixes
                .iter()
                .map(|suffix| find(&layer.name, suffix))
                .collect();
            if let Some(planes) = planes {
                return Ok(interleave(layered.width, layered.height, &planes));
            }
        }
    }
    match names[..] {
        [only] => Ok(interleave(
            layered.width,
            layered.height,
            &[layered.channel(only).unwrap_or_default()],
        )),
        _ => Err(Fault::new(format!(
            "expected the channels R, G, B or Y, found {}",
            names.join(", ")
        ))),
    }
}

/// All channels of all parts that have the size of the first part. The name of a part becomes the layer of a channel if that name
/// is already taken.
pub(super) fn read_channels(bytes: &[u8]) -> Result<LayeredImage, Fault> {
    check_size(bytes)?;
    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes();
    let image: FlatImage = reader.from_buffered(Cursor::new(bytes)).map_err(damaged)?;
    let Some(first) = image.layer_data.first() else {
        return Err(Fault::new("the EXR file contains no image"));
    };
    let size = first.size;
    let mut channels: Vec<(String, Vec<f32>)> = Vec::new();
    for part in image.layer_data.iter().filter(|part| part.size == size) {
        let part_name = part.attributes.layer_name.as_ref().map(text);
        for channel in &part.channel_data.list {
            let mut name = text(&channel.name);
            if let (true, Some(part_name)) = (channels.iter().any(|(n, _)| *n == name), &part_name)
            {
                name = format!("{part_name}.{name}");
            }
            channels.push((name, channel.sample_data.values_as_f32().collect()));
        }
    }
    let metadata = metadata_of(&first.attributes);
    Ok(LayeredImage {
        metadata,
        ..LayeredImage::from_channels(size.width(), size.height(), channels)
    })
}

/// Rejects headers that declare more samples than the file can contain, before anything is allocated.
fn check_size(bytes: &[u8]) -> Result<(), Fault> {
    /// Bound on samples per byte of the file; far above the compression of an image of one color.
    const MAX_SAMPLES_PER_BYTE: u128 = 20_000;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        let (size, channels) = (header.layer_size, header.channels.list.len());
        let samples = size.width() as u128 * size.height() as u128 * channels as u128;
        if samples > bytes.len() as u128 * MAX_SAMPLES_PER_BYTE {
            let (width, height) = (size.width(), size.height());
            return Err(Fault::new(format!(
                "the header declares {width} x {height} pixels of {channels} channels, more than fit into the file"
            )));
        }
    }
    Ok(())
}

fn damaged(error: exr::error::Error) -> Fault {
    Fault::new(format!("the EXR image cannot be decoded: {error}"))
}

fn text(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// All text attributes, sorted by name.
fn metadata_of(attributes: &LayerAttributes) -> Vec<(String, String)> {
    let standard = [
        (SOFTWARE, &attributes.software_name),
        (COMMENTS, &attributes.comments),
        (OWNER, &attributes.owner),
        (CAPTURE_DATE, &attributes.capture_date),
    ];
    let standard = standard
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), text(value.as_ref()?))));
    let other = attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(value) => Some((text(name), text(value))),
            _ => None,
        });
    let mut metadata: Vec<(String, String)> = standard.chain(other).collect();
    metadata.sort();
    metadata
}

/// Names of the text attributes that OpenEXR standardizes.
const SOFTWARE: &str = "software";
const COMMENTS: &str = "comments";
const OWNER: &str = "owner";
const CAPTURE_DATE: &str = "capDate";

/// The file content for an image: one part with ZIP compression and 32-bit float channels, metadata as text attributes.
pub(super) fn encode(image: &LayeredImage) -> Result<Vec<u8>, Fault> {
    let channels = image.layers.iter().flat_map(|layer| &layer.channels);
    let channels = channels
        .map(|(name, values)| AnyChannel::new(utf8(name), FlatSamples::F32(values.clone())))
        .collect();
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = Vec2(image.width, image.height);
    let part = Part::new(
        size,
        attributes_for(&image.metadata),
        encoding,
        AnyChannels::sort(channels),
    );
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    attributes.chromaticities = Some(REC_709);
    let image = exr::image::Image::empty(attributes).with_layer(part);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| Fault::new(format!("the EXR image cannot be encoded: {error}")))?;
    Ok(bytes.into_inner())
}

/// Primaries and white point of Rec. 709.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

fn attributes_for(metadata: &[(String, String)]) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    for (name, value) in metadata {
        let value = utf8(value);
        match name.as_str() {
            SOFTWARE => attributes.software_name = Some(value),
            COMMENTS => attributes.comments = Some(value),
            OWNER => attributes.owner = Some(value),
            CAPTURE_DATE => attributes.capture_date = Some(value),
            _ => drop(
                attributes
                    .other
                    .insert(utf8(name), AttributeValue::Text(value)),
            ),
        }
    }
    attributes
}

/// `text` as UTF-8. The conversion of the `exr` crate rejects everything but Latin-1, although the format stores bytes and
/// readers assume UTF-8.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
