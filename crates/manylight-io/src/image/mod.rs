//! Image files: textures and environment maps, and rendered images with layers.
//!
//! [`read_image`] returns one or three linear channels, as a texture needs. [`read_layered_image`]
//! and [`write_image`] keep all named channels and the metadata.

mod agx;
mod cryptomatte;
mod exr_checks;
mod exr_colors;
mod exr_file;
mod finite;
mod jpeg;
mod layered;
mod low_range;
mod pfm;
mod png_file;
mod size_check;
mod transfer;
mod view;
mod write;

#[cfg(test)]
mod tests;

pub use cryptomatte::Cryptomatte;
pub(crate) use finite::{NotFinite, make_finite};
pub use layered::{
    ImageCamera, ImageLayer, ImageWindow, LIGHT_GROUP, LayeredImage, full_name, interleave,
    is_combined, last_part, light_group,
};
pub use transfer::{Transfer, linear_from_srgb, srgb_from_linear};
pub use view::{DisplayTransform, View};
pub use write::{ImageFormat, check_writable, encode_png, write_image};

use crate::file_error::{Fault, FileError, read_bytes};
use exr_colors::Colors;
use manylight::image::Image;
use std::path::Path;
use transfer::Depth;

/// Reads an image as one linear gray channel or three linear Rec. 709 channels, as Mitsuba's
/// `bitmap` texture does: alpha is dropped (colors are not multiplied by it), and 8 and 16 bit
/// values are divided by their maximum before `transfer` applies.
///
/// Formats are PNG, JPEG, WebP, TGA, BMP, Radiance HDR, OpenEXR and PFM, recognized by content (TGA
/// by extension). Colors of OpenEXR files in other color spaces are converted, unless `transfer` is
/// [`Transfer::Raw`].
///
/// # Errors
/// The file cannot be read, is damaged, or has an unsupported format.
pub fn read_image(path: &Path, transfer: Transfer) -> Result<Image, FileError> {
    let bytes = read_bytes(path)?;
    decode(&bytes, path, transfer).map_err(|fault| fault.in_file(path))
}

/// Reads the alpha channel of an image, in [0, 1]; 1 everywhere if the file has none.
///
/// # Errors
/// The file cannot be read, is damaged, or has an unsupported format.
pub fn read_alpha(path: &Path) -> Result<Image, FileError> {
    decode_alpha(&read_bytes(path)?, path)
}

/// The channel `A`.
fn alpha_of(image: &LayeredImage) -> Image {
    let mut alpha = opaque(image.width, image.height);
    if let Some(values) = image.channel("A") {
        alpha.data = values.to_vec();
    }
    alpha
}

/// An alpha channel of ones.
fn opaque(width: usize, height: usize) -> Image {
    Image {
        width,
        height,
        channels: 1,
        data: vec![1.0; width * height],
    }
}

/// Reads all channels of an OpenEXR file and its metadata. Files of other formats have the linear
/// channels `R`, `G`, `B`, or `Y`.
///
/// # Errors
/// The file cannot be read, is damaged, or has an unsupported format.
pub fn read_layered_image(path: &Path) -> Result<LayeredImage, FileError> {
    let bytes = read_bytes(path)?;
    let image = if SourceFormat::of(&bytes) == SourceFormat::Exr {
        exr_file::read_channels(&bytes)
    } else {
        decode(&bytes, path, Transfer::Auto).map(|image| LayeredImage::from_image(&image))
    };
    image.map_err(|fault| fault.in_file(path))
}

/// Decodes the content of an image file as [`read_image`] does. `path` is its name in messages.
pub(crate) fn decode_image(
    bytes: &[u8],
    path: &Path,
    transfer: Transfer,
) -> Result<Image, FileError> {
    decode(bytes, path, transfer).map_err(|fault| fault.in_file(path))
}

/// Decodes the alpha channel of the content of an image file as [`read_alpha`] does. `path` is its
/// name in messages.
pub(crate) fn decode_alpha(bytes: &[u8], path: &Path) -> Result<Image, FileError> {
    let found = match SourceFormat::of(bytes) {
        SourceFormat::Exr => exr_file::read_channels(bytes).map(|image| alpha_of(&image)),
        SourceFormat::Other => low_range::decode_alpha(bytes, path),
        SourceFormat::Pfm | SourceFormat::Jpeg => {
            decode(bytes, path, Transfer::Raw).map(|image| opaque(image.width, image.height))
        }
    };
    found.map_err(|fault| fault.in_file(path))
}

fn decode(bytes: &[u8], path: &Path, transfer: Transfer) -> Result<Image, Fault> {
    match SourceFormat::of(bytes) {
        SourceFormat::Exr => {
            let colors = match transfer {
                Transfer::Raw => Colors::Stored,
                _ => Colors::Converted,
            };
            let image = exr_file::read_color(bytes, colors)?;
            Ok(transfer.apply(image, Depth::Float))
        }
        SourceFormat::Pfm => pfm::parse(bytes).map(|image| transfer.apply(image, Depth::Float)),
        SourceFormat::Jpeg => jpeg::decode(bytes, transfer),
        SourceFormat::Other => low_range::decode(bytes, path, transfer),
    }
}

/// The format of an image file, from its first bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SourceFormat {
    Exr,
    Pfm,
    Jpeg,
    /// The formats of the `image` crate.
    Other,
}

impl SourceFormat {
    fn of(bytes: &[u8]) -> SourceFormat {
        match bytes {
            [0x76, 0x2F, 0x31, 0x01, ..] => SourceFormat::Exr,
            [b'P', b'F' | b'f', b'\n' | b' ' | b'\r' | b'\t', ..] => SourceFormat::Pfm,
            [0xFF, 0xD8, 0xFF, ..] => SourceFormat::Jpeg,
            _ => SourceFormat::Other,
        }
    }
}
