//! PNG, WebP, TGA, BMP and Radiance HDR, decoded by the `image` crate.

use super::png_file::check_palette;
use super::size_check::check_size;
use super::transfer::{Depth, Transfer};
use crate::file_error::Fault;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use manylight::image::Image;
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

/// Memory limit of a decoder in bytes: enough for 16k x 16k float RGB, and a bound for damaged
/// headers.
pub(super) const MAX_DECODED_BYTES: u64 = 4 << 30;

/// Decodes the file content `bytes`. If it does not show the format, the extension of `path`
/// decides.
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
    if reader.format().is_none()
        && let Ok(format) = ImageFormat::from_path(path)
    {
        reader.set_format(format);
    }
    let expansion = match reader.format() {
        Some(ImageFormat::Png) => {
            check_palette(&bytes)?;
            PNG_EXPANSION
        }
        Some(ImageFormat::WebP) => WEBP_EXPANSION,
        Some(ImageFormat::Bmp) => BMP_EXPANSION,
        Some(ImageFormat::Tga) => TGA_EXPANSION,
        Some(ImageFormat::Hdr) => HDR_EXPANSION,
        _ => {
            return Err(Fault::new(
                "unknown image format; expected PNG, JPEG, WebP, TGA, BMP, HDR, EXR or PFM",
            ));
        }
    };
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    let decoded = decoder.total_bytes();
    check_size(
        [width as usize, height as usize],
        u128::from(decoded),
        bytes.len(),
        expansion,
    )?;
    if decoded > MAX_DECODED_BYTES {
        return Err(Fault::new(format!(
            "found {width} x {height} pixels, which take {decoded} bytes; at most {MAX_DECODED_BYTES} are supported"
        )));
    }
    DynamicImage::from_decoder(decoder).map_err(undecodable)
}

/// Most decoded bytes per byte of a file. PNG: deflate expands 1032 times, and an index of one bit
/// becomes four bytes.
const PNG_EXPANSION: u32 = 1032 * 32;
/// A lossless image of one color takes no bits for its pixels: 2048 x 2048 of them fit into 30
/// bytes. Larger ones than the headers need are refused.
const WEBP_EXPANSION: u32 = 1 << 19;
/// Two bytes of a run are 255 pixels of three bytes.
const BMP_EXPANSION: u32 = 512;
/// Two bytes of a run are 128 pixels of four bytes.
const TGA_EXPANSION: u32 = 256;
/// Eight bytes are runs of 127 pixels in four channels, decoded to three floats; runs of the old
/// form are shorter than in other files.
const HDR_EXPANSION: u32 = 4096;

/// Radiance files start with `#?RADIANCE` or `#?RGBE`; the decoder accepts only the first, so the
/// second is replaced.
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
