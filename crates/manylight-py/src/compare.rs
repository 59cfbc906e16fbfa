//! Comparison with a reference.

use crate::errors::usage;
use crate::image::Image;
use manylight_lab::compare::{ComparisonImage, compare as measure};
use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

/// A picture to be compared.
#[derive(FromPyObject)]
pub(crate) enum Compared<'py> {
    Image(PyRef<'py, Image>),
    /// (height, width, 3) linear values.
    Array(PyReadonlyArray3<'py, f32>),
}

impl Compared<'_> {
    fn image(&self, py: Python<'_>, layer: Option<&str>) -> PyResult<ComparisonImage> {
        match self {
            Compared::Image(image) => ComparisonImage::new(&image.picture(), layer)
                .map_err(|error| usage(py, &error.to_string(), "see `image.layers`")),
            Compared::Array(array) => {
                let view = array.as_array();
                let &[height, width, channels] = view.shape() else {
                    unreachable!("the array has three dimensions")
                };
                if channels != 3 || height == 0 || width == 0 {
                    let message = format!("found an array of shape {:?}", view.shape());
                    return Err(usage(py, &message, "expected (height, width, 3)"));
                }
                let rgb = view.rows();
                let rgb = rgb.into_iter().map(|row| [row[0], row[1], row[2]]);
                Ok(ComparisonImage::from_rgb(width, height, rgb.collect()))
            }
        }
    }
}

/// Measures how an image differs from a reference: JSON, and HDR-FLIP of each pixel.
#[pyfunction]
#[pyo3(signature = (image, reference, layer=None))]
pub(crate) fn compare(
    py: Python<'_>,
    image: Compared<'_>,
    reference: Compared<'_>,
    layer: Option<&str>,
) -> PyResult<(String, Vec<f32>)> {
    let (image, reference) = (image.image(py, layer)?, reference.image(py, layer)?);
    let size = |image: &ComparisonImage| (image.width, image.height);
    if size(&image) != size(&reference) {
        let message = format!(
            "found images of {:?} and {:?} pixels",
            size(&image),
            size(&reference)
        );
        return Err(usage(py, &message, "expected images of one size"));
    }
    let comparison = py.detach(|| measure("image", &image, &reference));
    let json = serde_json::to_string(&comparison)
        .map_err(|error| usage(py, &error.to_string(), "expected finite values"))?;
    Ok((json, comparison.flip_map))
}
