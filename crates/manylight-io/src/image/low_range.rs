//! PNG, TGA, BMP and Radiance HDR, decoded by the `image` crate.

use super::transfer::{Depth, Transfer};
use crate::file_error::Fault;
use image::{DynamicImage, ImageReader, Limits};
use manylight::image::Image;
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

/// Memory limit of a decoder in bytes: enough for 16k x 16k float RGB, and a bound for damaged headers.
pub(super) const MAX_DECODED_BYTES: u64 = 4 << 30;

/// Decodes the file content `bytes`. If it does not show the format, the extension of `path` decides.
pub(super) fn decode(bytes: &[u8], path: &Path, transfer: Transfer) -> Result<Image, Fault> {
    Ok(linear(decode_stored(bytes, path)?, transfer))
}

/// The alpha channel of the file content `bytes`; 1 everywhere if there is none.
pub(super) fn decode_alpha(bytes: &[u8], path: &Path) -> Result<Image, Fault> {
    let decoded = decode_stored(bytes, path)?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let data = if decoded.color().has_alpha() {
        decoded.into_rgba32f().pixels().map(|p| p.0[3]).collect()
    } else {
        vec![1.0; width * height]
    };
    Ok(Image {
        width,
        height,
        channels: 1,
        data,
    })
}

fn decode_stored(bytes: &[u8], path: &Path) -> Result<DynamicImage, Fault> {
    let undecodable =
        |error: image::ImageError| Fault::new(format!("the image cannot be decoded: {error}"));
    let bytes = with_known_signature(bytes);
    let mut reader = ImageReader::new(Cursor::new(bytes.as_ref()))
        .with_guessed_format()
        .map_err(|e| undecodable(e.into()))?;
    if reader.format().is_none() {
        match image::ImageFormat::from_path(path) {
            Ok(format) => reader.set_format(format),
            Err(_) => {
                return Err(Fault::new(
                    "unknown image format; expected PNG, JPEG, TGA, BMP, HDR, EXR or PFM",
                ));
            }
        }
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    reader.decode().map_err(undecodable)
}

/// Radiance files start with `#?RADIANCE` or `#?RGBE`; the decoder accepts only the first, so the second is replaced.
fn with_known_signature(bytes: &[u8]) -> Cow<'_, [u8]> {
    match bytes.strip_prefix(b"#?RGBE") {
        Some(rest) => Cow::Owned([b"#?RADIANCE", rest].concat()),
        None => Cow::Borrowed(bytes),
    }
}

/// Drops alpha and applies the transfer function. Gray images have one channel, others three.
fn linear(decoded: DynamicImage, transfer: Transfer) -> Image {
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let integer = transfer.curve(Depth::Integer);
    let bytes =
        |raw: &[u8], stored: usize, kept: usize| bytes_to_linear(raw, stored, kept, transfer);
    let words = |raw: &[u16], stored: usize, kept: usize| {
        pick(raw, stored, kept, |v| integer(f32::from(v) / 65535.0))
    };
    let (channels, data) = match decoded {
        DynamicImage::ImageLuma8(image) => (1, bytes(&image, 1, 1)),
        DynamicImage::ImageLumaA8(image) => (1, bytes(&image, 2, 1)),
        DynamicImage::ImageRgb8(image) => (3, bytes(&image, 3, 3)),
        DynamicImage::ImageRgba8(image) => (3, bytes(&image, 4, 3)),
        DynamicImage::ImageLuma16(image) => (1, words(&image, 1, 1)),
        DynamicImage::ImageLumaA16(image) => (1, words(&image, 2, 1)),
        DynamicImage::ImageRgb16(image) => (3, words(&image, 3, 3)),
        DynamicImage::ImageRgba16(image) => (3, words(&image, 4, 3)),
        other => (
            3,
            pick(&other.into_rgb32f(), 3, 3, transfer.curve(Depth::Float)),
        ),
    };
    Image {
        width,
        height,
        channels,
        data,
    }
}

/// The first `kept` of every `stored` bytes as linear values.
pub(super) fn bytes_to_linear(
    raw: &[u8],
    stored: usize,
    kept: usize,
    transfer: Transfer,
) -> Vec<f32> {
    let curve = transfer.curve(Depth::Integer);
    let table: Vec<f32> = (0..=255_u8).map(|v| curve(f32::from(v) / 255.0)).collect();
    pick(raw, stored, kept, |v| table[usize::from(v)])
}

/// The first `kept` of every `stored` values, converted.
fn pick<T: Copy>(raw: &[T], stored: usize, kept: usize, convert: impl Fn(T) -> f32) -> Vec<f32> {
    raw.chunks_exact(stored)
        .flat_map(|pixel| pixel[..kept].iter().map(|&v| convert(v)))
        .collect()
}
