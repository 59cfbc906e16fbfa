//! Pictures into files. A file appears complete under its name or not at all.

use super::picture::Picture;
use super::transfer::srgb_from_linear;
use super::{exr_file, pfm};
use crate::file_error::{Fault, FileError, FileErrorKind};
use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use manylight::image::Image;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// OpenEXR: all channels as 32-bit floats, with metadata.
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
    /// The format that the extension of `path` names; the error lists the known ones.
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
                let message =
                    format!("found {found}; images are written as .exr, .png, .jpg, .hdr or .pfm");
                Err(FileError {
                    kind: FileErrorKind::UnknownFormat,
                    ..FileError::malformed(path, message)
                })
            }
        }
    }
}

/// Writes `picture` in the format that the extension names. PNG and JPEG show the beauty layer times 2^`exposure_ev`;
/// the other formats keep linear values as they are. The file is written under another name in the same folder, brought to
/// the disk and renamed.
pub fn write_image(path: &Path, picture: &Picture, exposure_ev: f32) -> Result<(), FileError> {
    let format = ImageFormat::from_path(path)?;
    let bytes = check_channels(picture)
        .and_then(|()| encode(format, picture, exposure_ev))
        .map_err(|fault| fault.in_file(path))?;
    write_file(path, &bytes)
}

/// Writes a file of these bytes as [`write_image`] does: under another name, brought to the disk, renamed.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    replace(path, bytes).map_err(|error| FileError::unwritable(path, error))
}

/// Whether [`write_image`] can write `path`: the format is known and the folder takes files. To be asked before a long
/// computation.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    ImageFormat::from_path(path)?;
    let target = target_of(path);
    let open = || match std::fs::metadata(&target) {
        Ok(metadata) if metadata.is_dir() => Err(std::io::Error::other("it is a folder")),
        Ok(metadata) if !metadata.is_file() => std::fs::OpenOptions::new()
            .write(true)
            .open(&target)
            .map(drop),
        _ => temporary_beside(&target).map(drop),
    };
    open().map_err(|error| FileError::unwritable(path, error))
}

fn check_channels(picture: &Picture) -> Result<(), Fault> {
    let count = picture.width * picture.height;
    if count == 0 {
        return Err(Fault::new("an image without pixels cannot be written"));
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, values) in picture.layers.iter().flat_map(|layer| &layer.channels) {
        if values.len() != count {
            return Err(Fault::new(format!(
                "the channel {name} has {} values, the image {count} pixels",
                values.len()
            )));
        }
        if names.contains(&name.as_str()) {
            return Err(Fault::new(format!("there are two channels {name}")));
        }
        names.push(name);
    }
    if names.is_empty() {
        Err(Fault::new("an image without channels cannot be written"))
    } else {
        Ok(())
    }
}

fn encode(format: ImageFormat, picture: &Picture, exposure_ev: f32) -> Result<Vec<u8>, Fault> {
    if format == ImageFormat::Exr {
        return exr_file::encode(picture);
    }
    let beauty = picture
        .beauty()
        .ok_or_else(|| Fault::new("this format needs the channels R, G, B or Y"))?;
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
        ImageFormat::Png => encode_display(PngEncoder::new(&mut bytes), &beauty, exposure_ev),
        ImageFormat::Jpg => {
            const QUALITY: u8 = 95;
            encode_display(
                JpegEncoder::new_with_quality(&mut bytes, QUALITY),
                &beauty,
                exposure_ev,
            )
        }
    };
    encoded
        .map(|()| bytes)
        .map_err(|error| Fault::new(format!("the image cannot be encoded: {error}")))
}

fn encode_display(
    encoder: impl ImageEncoder,
    image: &Image,
    exposure_ev: f32,
) -> image::ImageResult<()> {
    let exposure = exposure_ev.exp2();
    let byte = |v: f32| (srgb_from_linear((v * exposure).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    let bytes: Vec<u8> = image.data.iter().map(|&v| byte(v)).collect();
    let color = if image.channels == 3 {
        ExtendedColorType::Rgb8
    } else {
        ExtendedColorType::L8
    };
    encoder.write_image(&bytes, image.width as u32, image.height as u32, color)
}

/// RGBE has neither negative values nor NaN.
fn radiance_pixels(image: &Image) -> Vec<image::Rgb<f32>> {
    let positive = |v: f32| if v > 0.0 { v.min(f32::MAX) } else { 0.0 };
    (0..image.width * image.height)
        .map(|i| image.rgb(i % image.width, i / image.width).map(positive))
        .map(|c| image::Rgb(c.to_array()))
        .collect()
}

/// Where the bytes go: the file behind a symbolic link, so that the link survives.
fn target_of(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let target = target_of(path);
    if std::fs::metadata(&target).is_ok_and(|m| !m.is_file()) {
        // Devices and pipes are written to; renaming would replace them by a file.
        return std::fs::OpenOptions::new()
            .write(true)
            .open(&target)?
            .write_all(bytes);
    }
    let mut file = temporary_beside(&target)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    Ok(())
}

/// A temporary file in the folder of `target`, with the permissions of an ordinary new file.
fn temporary_beside(target: &Path) -> std::io::Result<NamedTempFile> {
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".manylight-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The error names the temporary file, which means nothing to anybody; the kind says the rest.
    builder
        .tempfile_in(folder)
        .map_err(|error| std::io::Error::from(error.kind()))
}
