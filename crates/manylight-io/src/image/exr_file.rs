//! OpenEXR. Files with any channels are read; written files have one part with 32-bit float
//! channels.

use super::exr_checks::{check_headers, damaged};
use super::exr_colors::{COLOR_INTEROP_ID, ColorSpace, Colors, Planes, REC_709, text};
use super::layered::{ImageCamera, ImageWindow, LayeredImage, interleave, is_combined};
use crate::file_error::Fault;
use exr::image::read::read;
use exr::image::write::WritableImage;
use exr::image::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatImage, FlatSamples, Layer as Part,
};
use exr::meta::attribute::{AttributeValue, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, IntegerBounds, ReadChannels, ReadLayers, Vec2};
use manylight::image::Image;
use std::io::Cursor;

/// The color of an EXR file: the channels `R`, `G`, `B`, else `Y`, else those of the image in files
/// of Blender, else those of the first layer that has them, else the only channel.
pub(super) fn read_color(bytes: &[u8], colors: Colors) -> Result<Image, Fault> {
    let (layered, space) = decode(bytes, colors)?;
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
    let images = layered.layers.iter().filter(|l| is_combined(&l.name));
    for layer in images.chain(&layered.layers) {
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
                let mut image = interleave(layered.width, layered.height, &planes);
                if colors == Colors::Converted && image.channels == 3 {
                    space.convert_pixels(&mut image.data);
                }
                return Ok(image);
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

/// All channels of all parts that have the size of the first part, with colors in linear Rec. 709.
/// The name of a part becomes the layer of a channel if that name is already taken.
pub(super) fn read_channels(bytes: &[u8]) -> Result<LayeredImage, Fault> {
    decode(bytes, Colors::Converted).map(|(image, _)| image)
}

/// All channels as in [`read_channels`], and the color space of the file.
fn decode(bytes: &[u8], colors: Colors) -> Result<(LayeredImage, ColorSpace), Fault> {
    check_headers(bytes)?;
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
    let space = ColorSpace::of(&image.attributes, first)?;
    let metadata = metadata_of(&first.attributes);
    let window = window_of(&image.attributes.display_window, first);
    let camera = camera_of(&first.attributes);
    let mut channels = Planes::new();
    for part in image
        .layer_data
        .into_iter()
        .filter(|part| part.size == size)
    {
        let part_name = part.attributes.layer_name.as_ref().map(text);
        for channel in part.channel_data.list {
            let mut name = text(&channel.name);
            if let (true, Some(part_name)) = (channels.iter().any(|(n, _)| *n == name), &part_name)
            {
                name = format!("{part_name}.{name}");
            }
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                other => other.values_as_f32().collect(),
            };
            channels.push((name, values));
        }
    }
    space.convert(&mut channels, colors);
    let image = LayeredImage {
        metadata,
        window,
        camera,
        ..LayeredImage::from_channels(size.width(), size.height(), channels)
    };
    Ok((image, space))
}

/// The place of a part in the display window; `None` if the part fills it or reaches beyond it.
fn window_of(
    display: &IntegerBounds,
    part: &Part<AnyChannels<FlatSamples>>,
) -> Option<ImageWindow> {
    let offset = |part: i32, display: i32| usize::try_from(part.checked_sub(display)?).ok();
    let position = part.attributes.layer_position;
    let window = ImageWindow {
        full_size: [display.size.width(), display.size.height()],
        offset: [
            offset(position.x(), display.position.x())?,
            offset(position.y(), display.position.y())?,
        ],
    };
    let size = [part.size.width(), part.size.height()];
    let is_inside = (0..2).all(|i| window.offset[i] + size[i] <= window.full_size[i]);
    (is_inside && size != window.full_size).then_some(window)
}

/// The camera of a part that has both of its matrices.
fn camera_of(attributes: &LayerAttributes) -> Option<ImageCamera> {
    let Vec2(x, y) = attributes.screen_window_center;
    Some(ImageCamera {
        camera_from_world: attributes.world_to_camera?,
        ndc_from_world: attributes.world_to_normalized_device?,
        screen_center: [x, y],
        screen_width: attributes.screen_window_width,
    })
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
/// Local time as `YYYY:MM:DD hh:mm:ss`; here universal time, with `utcOffset` 0.
const CAPTURE_DATE: &str = "capDate";

/// The tag of rendered images: linear Rec. 709 that is proportional to radiance.
const LINEAR_REC_709_SCENE: &str = "lin_rec709_scene";

/// The file content for an image: one part with ZIP compression and 32-bit float channels, metadata
/// as text attributes. The display window is the full picture, the data window the image.
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
        attributes_for(image),
        encoding,
        AnyChannels::sort(channels),
    );
    let full = image
        .window
        .map_or([image.width, image.height], |w| w.full_size);
    let display = IntegerBounds::from_dimensions(Vec2(full[0], full[1]));
    let mut attributes = ImageAttributes::new(display);
    attributes.chromaticities = Some(REC_709);
    let image = exr::image::Image::empty(attributes).with_layer(part);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| Fault::new(format!("the EXR image cannot be encoded: {error}")))?;
    Ok(bytes.into_inner())
}

fn attributes_for(image: &LayeredImage) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    if let Some(window) = image.window {
        let [x, y] = window.offset.map(|offset| offset as i32);
        attributes.layer_position = Vec2(x, y);
    }
    if let Some(camera) = image.camera {
        attributes.world_to_camera = Some(camera.camera_from_world);
        attributes.world_to_normalized_device = Some(camera.ndc_from_world);
        let [x, y] = camera.screen_center;
        attributes.screen_window_center = Vec2(x, y);
        attributes.screen_window_width = camera.screen_width;
    }
    let tag = AttributeValue::Text(utf8(LINEAR_REC_709_SCENE));
    attributes.other.insert(utf8(COLOR_INTEROP_ID), tag);
    for (name, value) in &image.metadata {
        let value = utf8(value);
        match name.as_str() {
            SOFTWARE => attributes.software_name = Some(value),
            COMMENTS => attributes.comments = Some(value),
            OWNER => attributes.owner = Some(value),
            CAPTURE_DATE => {
                attributes.capture_date = Some(value);
                attributes.utc_offset = Some(0.0);
            }
            _ => drop(
                attributes
                    .other
                    .insert(utf8(name), AttributeValue::Text(value)),
            ),
        }
    }
    attributes
}

/// `text` as UTF-8. The conversion of the `exr` crate rejects everything but Latin-1, although the
/// format stores bytes and readers assume UTF-8.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
