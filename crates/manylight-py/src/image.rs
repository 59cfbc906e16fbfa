//! Pictures as numpy arrays.

use crate::errors::{exception, file_exception, usage};
use manylight::image::Image as Pixels;
use manylight_cli::embed::{DEFAULT_VIEW, Picture, display_transform, relit};
use manylight_io::image::{
    DisplayTransform, ImageCamera, ImageLayer, ImageWindow, LayeredImage, encode_png, interleave,
    read_layered_image, write_image,
};
use manylight_lab::noise::VARIANCE;
use numpy::PyArray;
use numpy::ndarray::{ArrayView2, ArrayView3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Name of the layer with the picture itself.
pub(crate) const BEAUTY: &str = "beauty";
/// Name of the layer with the coverage of each pixel. In files, it is a channel of the picture.
const ALPHA: &str = "alpha";

/// Factors on the light of a group.
#[derive(FromPyObject)]
enum GroupFactors {
    Number(f32),
    Color([f32; 3]),
}

/// The channels of a layer, interleaved.
struct Layer {
    name: String,
    channels: Vec<String>,
    pixels: Pixels,
}

/// A picture: layers of linear values, and metadata.
#[pyclass(frozen, module = "manylight._native")]
pub(crate) struct Image {
    layers: Vec<Layer>,
    width: usize,
    height: usize,
    metadata: Vec<(String, String)>,
    window: Option<ImageWindow>,
    camera: Option<ImageCamera>,
    passes: u32,
    relative_error: f32,
    interrupted: bool,
}

impl Image {
    /// The image of a picture. `label` replaces the scene in its metadata, if the scene has no file
    /// that lasts.
    pub(crate) fn new(picture: Picture, interrupted: bool, label: Option<&str>) -> Self {
        let mut image = Image {
            passes: picture.passes,
            relative_error: picture.relative_error,
            interrupted,
            ..Image::from_layers(picture.image)
        };
        if let Some(label) = label {
            image = image.without_command();
            for (name, value) in &mut image.metadata {
                if name == "scene" {
                    label.clone_into(value);
                }
            }
        }
        image
    }

    /// Without the command that repeats the render, for one that names files that do not last.
    pub(crate) fn without_command(mut self) -> Self {
        self.metadata.retain(|(name, _)| name != "command");
        self
    }

    fn from_layers(picture: LayeredImage) -> Self {
        let (width, height) = (picture.width, picture.height);
        let interleaved = |layer: ImageLayer| interleaved(layer, width, height);
        Image {
            layers: picture.layers.into_iter().flat_map(interleaved).collect(),
            width,
            height,
            metadata: picture.metadata,
            window: picture.window,
            camera: picture.camera,
            passes: 0,
            relative_error: f32::INFINITY,
            interrupted: false,
        }
    }

    /// The layers of an image file.
    pub(crate) fn picture(&self) -> LayeredImage {
        let mut layers: Vec<ImageLayer> = Vec::new();
        for layer in &self.layers {
            let name = match layer.name.as_str() {
                BEAUTY => "",
                name => name,
            };
            let planes = ImageLayer::from_image(name, layer.channels.clone(), &layer.pixels);
            match layers.first_mut() {
                Some(beauty) if layer.name == ALPHA => beauty.channels.extend(planes.channels),
                _ => layers.push(planes),
            }
        }
        LayeredImage {
            width: self.width,
            height: self.height,
            layers,
            metadata: self.metadata.clone(),
            window: self.window,
            camera: self.camera,
        }
    }

    fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// A read-only array of a layer, which shares its memory.
    fn array<'py>(slf: &Bound<'py, Self>, layer: &Layer) -> PyResult<Bound<'py, PyAny>> {
        let (height, width, channels) = (slf.get().height, slf.get().width, layer.channels.len());
        let (data, owner) = (layer.pixels.data.as_slice(), slf.clone().into_any());
        let shape = "invariant: a layer has a value for each pixel and channel";
        let array = if channels == 1 {
            let view = ArrayView2::from_shape((height, width), data).expect(shape);
            borrowed(&view, owner)
        } else {
            let view = ArrayView3::from_shape((height, width, channels), data).expect(shape);
            borrowed(&view, owner)
        };
        array.call_method1("setflags", (false,))?;
        Ok(array)
    }
}

/// An array over the memory of `view`, which `owner` keeps.
#[expect(unsafe_code, reason = "arrays without a copy of the pixels")]
fn borrowed<'py, D: numpy::ndarray::Dimension>(
    view: &numpy::ndarray::ArrayView<'_, f32, D>,
    owner: Bound<'py, PyAny>,
) -> Bound<'py, PyAny> {
    // SAFETY: the array holds a reference to `owner`, an `Image`. It is frozen, so that its pixels
    // neither move nor change, and the caller makes the array read-only before Python sees it.
    let array = unsafe { PyArray::borrow_from_array(view, owner) };
    array.into_any()
}

/// A layer with its channels interleaved; the alpha of the picture becomes a layer.
fn interleaved(layer: ImageLayer, width: usize, height: usize) -> impl Iterator<Item = Layer> {
    let is_beauty = layer.name.is_empty();
    let is_alpha = |(name, _): &(String, Vec<f32>)| is_beauty && name == "A";
    let (alpha, mut color): (Vec<_>, Vec<_>) = layer.channels.into_iter().partition(is_alpha);
    color.sort_by_key(|(name, _)| order(name));
    let name = if is_beauty {
        BEAUTY.to_owned()
    } else {
        layer.name
    };
    [(name, color), (ALPHA.to_owned(), alpha)]
        .into_iter()
        .filter(|(_, planes)| !planes.is_empty())
        .map(move |(name, channels)| {
            let planes: Vec<&[f32]> = channels.iter().map(|(_, v)| v.as_slice()).collect();
            let pixels = interleave(width, height, &planes);
            Layer {
                name,
                channels: channels.into_iter().map(|(name, _)| name).collect(),
                pixels,
            }
        })
}

/// The place of a channel in an array. Files sort channels by name.
fn order(channel: &str) -> usize {
    let last = channel.rsplit('.').next().unwrap_or_default();
    let known = ["R", "G", "B", "A", "X", "Y", "Z"];
    known
        .iter()
        .position(|&name| name == last)
        .unwrap_or(known.len())
}

/// How values become colors of 8 bits.
fn display(py: Python<'_>, exposure: f32, view: &str) -> PyResult<DisplayTransform> {
    display_transform(exposure, view).map_err(|failure| exception(py, &failure))
}

#[pymethods]
impl Image {
    /// Width in pixels.
    #[getter]
    fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[getter]
    fn height(&self) -> usize {
        self.height
    }

    /// Number of passes; 0 if it is unknown.
    #[getter]
    fn passes(&self) -> u32 {
        self.passes
    }

    /// Upper bound of the relative error, with 95 % confidence; infinite if it is unknown.
    #[getter]
    fn relative_error(&self) -> f32 {
        self.relative_error
    }

    /// Whether the render was interrupted.
    #[getter]
    fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// Arrays by the names of the layers.
    #[getter]
    fn layers<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let layers = PyDict::new(slf.py());
        for layer in &slf.get().layers {
            layers.set_item(&layer.name, Image::array(slf, layer)?)?;
        }
        Ok(layers)
    }

    /// Variance of the mean of each value of the picture; None if it is unknown.
    #[getter]
    fn variance<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let layer = slf.get().layer(VARIANCE);
        layer.map(|layer| Image::array(slf, layer)).transpose()
    }

    /// What is known of the render, as text by name.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let metadata = PyDict::new(py);
        for (name, value) in &self.metadata {
            metadata.set_item(name, value)?;
        }
        Ok(metadata)
    }

    /// The picture as an array.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let Some(beauty) = slf.get().layer(BEAUTY) else {
            return Err(usage(
                py,
                "the image has no picture, only layers",
                "see `image.layers`",
            ));
        };
        let array = Image::array(slf, beauty)?;
        let same = match &dtype {
            None => true,
            Some(dtype) => numpy::dtype::<f32>(py).eq(dtype)?,
        };
        match (same, copy) {
            (true, Some(true)) => array.call_method0("copy"),
            (true, _) => Ok(array),
            (false, Some(false)) => Err(pyo3::exceptions::PyValueError::new_err(
                "the picture is float32: another dtype needs a copy",
            )),
            (false, _) => array.call_method1("astype", (dtype,)),
        }
    }

    /// The picture with other factors on its light groups.
    fn relight(&self, py: Python<'_>, groups: BTreeMap<String, GroupFactors>) -> PyResult<Image> {
        let factors = |factors: GroupFactors| match factors {
            GroupFactors::Color(factors) => factors,
            GroupFactors::Number(factor) => [factor; 3],
        };
        let groups = groups.into_iter().map(|(name, f)| (name, factors(f)));
        let groups: Vec<(String, [f32; 3])> = groups.collect();
        let relit = py.detach(|| relit(&self.picture(), &groups));
        let relit = relit.map_err(|failure| exception(py, &failure))?;
        Ok(Image {
            passes: self.passes,
            interrupted: self.interrupted,
            ..Image::from_layers(relit)
        })
    }

    /// Writes the image to a file; the extension selects the format.
    #[pyo3(signature = (path, *, exposure=0.0, view=DEFAULT_VIEW))]
    fn save(&self, py: Python<'_>, path: PathBuf, exposure: f32, view: &str) -> PyResult<()> {
        let display = display(py, exposure, view)?;
        py.detach(|| write_image(&path, &self.picture(), display))
            .map_err(|error| file_exception(py, &error))
    }

    /// The picture as the bytes of a PNG file.
    #[pyo3(signature = (*, exposure=0.0, view=DEFAULT_VIEW))]
    fn png<'py>(
        &self,
        py: Python<'py>,
        exposure: f32,
        view: &str,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let display = display(py, exposure, view)?;
        let bytes = py.detach(|| encode_png(&self.picture(), display));
        let bytes = bytes.map_err(|error| file_exception(py, &error))?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py, 0.0, DEFAULT_VIEW)
    }

    fn __repr__(&self) -> String {
        let names: Vec<&str> = self
            .layers
            .iter()
            .map(|layer| layer.name.as_str())
            .collect();
        format!(
            "<manylight.Image {}x{}, {} passes, layers: {}>",
            self.width,
            self.height,
            self.passes,
            names.join(", ")
        )
    }
}

/// Reads an image file: exr with all layers, png, jpg, tga, bmp, hdr, pfm.
#[pyfunction]
pub(crate) fn read_image(py: Python<'_>, path: PathBuf) -> PyResult<Image> {
    let picture = py.detach(|| read_layered_image(&path));
    let picture = picture.map_err(|error| file_exception(py, &error))?;
    let mut image = Image::from_layers(picture);
    let number = |name: &str| {
        let entry = image.metadata.iter().find(|(key, _)| key == name);
        entry.and_then(|(_, value)| value.parse::<u32>().ok())
    };
    image.passes = number("passes").unwrap_or(0);
    Ok(image)
}
