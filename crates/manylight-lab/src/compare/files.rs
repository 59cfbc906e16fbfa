//! Comparison of image files.

use super::comparison::{Comparison, compare};
use super::image::ComparisonImage;
use crate::error::LabError;
use manylight_io::image::read_layered_image;
use std::path::Path;

/// Reads an image file, or its layer `layer`, for comparison.
///
/// # Errors
/// The file cannot be read, or has no such color channels.
pub fn read_image(path: &Path, layer: Option<&str>) -> Result<ComparisonImage, LabError> {
    let picture = read_layered_image(path)?;
    ComparisonImage::new(&picture, layer).map_err(|error| {
        let hint = if error.is_ambiguous() {
            "choose one of them by `--layer`"
        } else {
            "images with color channels can be compared"
        };
        LabError::usage(format!("{}: {error}", path.display()), hint)
    })
}

/// Reads the image file at `path` and compares it with `reference`, which [`read_image`] has read
/// from `reference_path`.
///
/// # Errors
/// The file cannot be read, has no such color channels, or has another size than the reference.
pub fn compare_file(
    path: &Path,
    reference_path: &Path,
    reference: &ComparisonImage,
    layer: Option<&str>,
) -> Result<(ComparisonImage, Comparison), LabError> {
    let image = read_image(path, layer)?;
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(LabError::usage(
            format!(
                "{} is {}x{} pixels, {} is {}x{}",
                path.display(),
                image.width,
                image.height,
                reference_path.display(),
                reference.width,
                reference.height
            ),
            "render both at the same --size",
        ));
    }
    let comparison = compare(path.display().to_string(), &image, reference);
    Ok((image, comparison))
}
