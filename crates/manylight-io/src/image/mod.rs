//! Image files: textures and environment maps in, pictures out and in again.
//!
//! [`read_image`] gives what a texture needs: one or three linear channels. [`read_picture`] and [`write_image`] keep every
//! channel by its name, and metadata.

mod exr_file;
mod jpeg;
mod low_range;
mod pfm;
mod picture;
mod transfer;
mod write;

#[cfg(test)]
mod tests;

pub use picture::{Layer, Picture, read_picture};
pub use transfer::{Transfer, linear_from_srgb, srgb_from_linear};
pub use write::{ImageFormat, check_writable, write_file, write_image};

use crate::file_error::{Fault, FileError, read_bytes};
use manylight::image::Image;
use std::path::Path;
use transfer::Depth;

/// The image as one linear gray channel or three linear Rec. 709 channels, as Mitsuba's `bitmap` texture sees it: alpha is
/// dropped without multiplying by it, 8 and 16 bit values are divided by their maximum.
/// PNG, JPEG, TGA, BMP, Radiance HDR, OpenEXR and PFM; known by content, TGA by its extension.
pub fn read_image(path: &Path, transfer: Transfer) -> Result<Image, FileError> {
    let bytes = read_bytes(path)?;
    decode(&bytes, path, transfer).map_err(|fault| fault.in_file(path))
}

fn decode(bytes: &[u8], path: &Path, transfer: Transfer) -> Result<Image, Fault> {
    match Content::of(bytes) {
        Content::Exr => {
            exr_file::read_color(bytes).map(|image| transfer.apply(image, Depth::Float))
        }
        Content::Pfm => pfm::parse(bytes).map(|image| transfer.apply(image, Depth::Float)),
        Content::Jpeg => jpeg::decode(bytes, transfer),
        Content::Other => low_range::decode(bytes, path, transfer),
    }
}

/// What the first bytes of an image say.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    Exr,
    Pfm,
    Jpeg,
    Other,
}

impl Content {
    fn of(bytes: &[u8]) -> Content {
        match bytes {
            [0x76, 0x2F, 0x31, 0x01, ..] => Content::Exr,
            [b'P', b'F' | b'f', b'\n' | b' ' | b'\r' | b'\t', ..] => Content::Pfm,
            [0xFF, 0xD8, 0xFF, ..] => Content::Jpeg,
            _ => Content::Other,
        }
    }
}
