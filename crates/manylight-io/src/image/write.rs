//! Writing of images. Files are replaced atomically: a file is complete or does not change.

use super::layered::LayeredImage;
use super::view::DisplayTransform;
use super::{exr_file, pfm, png_file};
use crate::file_error::{Fault, FileError, FileErrorKind};
use crate::replace::{check_replaceable, write_file};
use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use manylight::image::Image;
use std::path::Path;

/// Format of a written image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// OpenEXR: all channels as 32-bit floats, and metadata.
    Exr,
    /// PNG: 8 bit sRGB.
    Png,
    /// JPEG: 8 bit sRGB.
    Jpg,
    /// Radiance RGBE: linear.
    Hdr,
    /// Portable float map: linear.
    Pfm,
}

impl ImageFormat {
    /// The format of the extension of `path`.
    ///
    /// # Errors
    /// The extension is missing or unknown. The message lists the supported ones.
    pub fn from_path(path: &Path) -> Result<ImageFormat, FileError> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(ImageFormat::Exr),
            Some("png") => Ok(ImageFormat::Png),
            Some("jpg" | "jpeg") => Ok(ImageFormat::Jpg),
            Some("hdr") => Ok(ImageFormat::Hdr),
            Some("pfm") => Ok(ImageFormat::Pfm),
            other => {
                let found = other.map_or_else(
                    || "no extension".to_owned(),
                    |e| format!("the extension '.{e}'"),
                );
                let message = format!("found {found}, expected .exr, .png, .jpg, .hdr or .pfm");
                Err(FileError {
                    kind: FileErrorKind::UnknownFormat,
                    ..FileError::malformed(path, message)
                })
            }
        }
    }
}

/// Writes `image` in the format of the extension of `path`. OpenEXR stores all channels, the other
/// formats the beauty layer. PNG and JPEG store the colors that `display` gives (a number is an
/// exposure in stops), HDR and PFM linear values. PNG files are tagged as sRGB and have the
/// metadata for readers of pictures.
///
/// The data is written to a temporary file in the same folder, flushed to disk, and renamed to
/// `path`.
///
/// # Errors
/// The extension is unknown, the channels are inconsistent or missing, or the file cannot be
/// written.
pub fn write_image(
    path: &Path,
    image: &LayeredImage,
    display: impl Into<DisplayTransform>,
) -> Result<(), FileError> {
    let format = ImageFormat::from_path(path)?;
    let bytes = check_channels(image)
        .and_then(|()| encode(format, image, display.into()))
        .map_err(|fault| fault.in_file(path))?;
    write_file(path, &bytes)
}

/// The picture of `image` as the bytes of a PNG file, as [`write_image`] writes them.
///
/// # Errors
/// The channels are inconsistent or missing.
pub fn encode_png(
    image: &LayeredImage,
    display: impl Into<DisplayTransform>,
) -> Result<Vec<u8>, FileError> {
    check_channels(image)
        .and_then(|()| encode(ImageFormat::Png, image, display.into()))
        .map_err(|fault| fault.in_file(Path::new("picture.png")))
}

/// Checks before a long computation that [`write_image`] can write `path`: the format is known and
/// the folder is writable.
///
/// # Errors
/// The extension is unknown, or the file cannot be written.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    ImageFormat::from_path(path)?;
    check_replaceable(path)
}

fn check_channels(image: &LayeredImage) -> Result<(), Fault> {
    let count = image.width * image.height;
    if count == 0 {
        return Err(Fault::new("the image has no pixels; expected at least one"));
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, values) in image.layers.iter().flat_map(|layer| &layer.channels) {
        if values.len() != count {
            return Err(Fault::new(format!(
                "the channel {name} has {} values, expected {count}, the number of pixels",
                values.len()
            )));
        }
        if names.contains(&name.as_str()) {
            return Err(Fault::new(format!(
                "two channels have the name {name}; expected distinct names"
            )));
        }
        names.push(name);
    }
    if names.is_empty() {
        Err(Fault::new(
            "the image has no channels; expected at least one",
        ))
    } else {
        Ok(())
    }
}

fn encode(
    format: ImageFormat,
    image: &LayeredImage,
    display: DisplayTransform,
) -> Result<Vec<u8>, Fault> {
    if format == ImageFormat::Exr {
        return exr_file::encode(image);
    }
    let beauty = image
        .beauty()
        .ok_or_else(|| Fault::new("the image has no channels R, G, B or Y, which this format requires; use .exr for other channels"))?;
    let mut bytes = Vec::new();
    let encoded = match format {
        ImageFormat::Exr | ImageFormat::Pfm => {
            bytes = pfm::encode(&beauty);
            Ok(())
        }
        ImageFormat::Hdr => HdrEncoder::new(&mut bytes).encode(
            &radiance_pixels(&beauty),
            beauty.width,
            beauty.height,
        ),
        ImageFormat::Png => {
            let values = display_values(&beauty, display);
            return png_file::encode(&beauty, &values, &image.metadata);
        }
        ImageFormat::Jpg => {
            /// JPEG quality in percent; trades file size against artifacts.
            const QUALITY: u8 = 95;
            let values = display_values(&beauty, display);
            let color = if beauty.channels == 3 {
                ExtendedColorType::Rgb8
            } else {
                ExtendedColorType::L8
            };
            JpegEncoder::new_with_quality(&mut bytes, QUALITY).write_image(
                &values,
                beauty.width as u32,
                beauty.height as u32,
                color,
            )
        }
    };
    encoded
        .map(|()| bytes)
        .map_err(|error| Fault::new(format!("the image cannot be encoded: {error}")))
}

/// The 8 bit sRGB values of an image, with its number of channels.
fn display_values(image: &Image, display: DisplayTransform) -> Vec<u8> {
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    let pixels = image.data.chunks_exact(image.channels);
    pixels
        .flat_map(|pixel| {
            let color = [0, 1, 2].map(|c| pixel[c.min(image.channels - 1)]);
            let srgb = display.srgb(color).map(byte);
            srgb.into_iter().take(image.channels)
        })
        .collect()
}

/// Pixels for RGBE, which stores neither negative values nor NaN: both become 0.
fn radiance_pixels(image: &Image) -> Vec<image::Rgb<f32>> {
    let positive = |v: f32| if v > 0.0 { v.min(f32::MAX) } else { 0.0 };
    (0..image.width * image.height)
        .map(|i| image.rgb(i % image.width, i / image.width).map(positive))
        .map(|c| image::Rgb(c.to_array()))
        .collect()
}
