//! Loaded scenes.

use crate::errors::exception;
use manylight::math::{Affine3A, Mat4};
use manylight_cli::embed::HeldScene;
use manylight_io::{read_camera_path, supported};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// A loaded scene.
#[pyclass(frozen, module = "manylight._native")]
pub(crate) struct Scene {
    held: Arc<HeldScene>,
    /// What metadata of pictures names instead of a file, if the scene has none that lasts.
    label: Option<String>,
}

impl Scene {
    pub(crate) fn held(&self) -> &Arc<HeldScene> {
        &self.held
    }

    pub(crate) fn label(&self) -> Option<&str> {
        self.label.as_deref()
    }
}

#[pymethods]
impl Scene {
    /// SHA-256 of the files of the scene, in hexadecimal digits.
    #[getter]
    fn digest(&self) -> &str {
        self.held.digest()
    }

    /// Warnings about the scene, without repetitions.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.held.warnings().to_vec()
    }

    /// Names of the cameras; a name may be empty.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        self.held.cameras().map(str::to_owned).collect()
    }

    /// Number of frames of each camera: 0 for one that stands still.
    #[getter]
    fn frame_counts(&self) -> Vec<usize> {
        self.held.frame_counts().collect()
    }
}

/// Loads a scene. `words` are its file, and options of `manylight render` that belong to loading.
#[pyfunction]
#[pyo3(signature = (words, label=None))]
pub(crate) fn load(py: Python<'_>, words: Vec<String>, label: Option<String>) -> PyResult<Scene> {
    let held = py.detach(|| HeldScene::load(words));
    let held = held.map_err(|failure| exception(py, &failure))?;
    Ok(Scene {
        held: Arc::new(held),
        label,
    })
}

/// The matrices from the camera to the world in the file of `--cameras`, row by row.
#[pyfunction]
pub(crate) fn read_cameras(py: Python<'_>, path: PathBuf) -> PyResult<Vec<[[f32; 4]; 4]>> {
    let cameras = read_camera_path(&path).map_err(|error| exception(py, &error.into()))?;
    let rows = |camera: Affine3A| Mat4::from(camera).transpose().to_cols_array_2d();
    Ok(cameras.into_iter().map(rows).collect())
}

/// Names of the plugins of Mitsuba scenes that are supported, by family.
#[pyfunction]
pub(crate) fn plugins(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let families = PyDict::new(py);
    for family in supported().filter(|family| family.format == "mitsuba") {
        families.set_item(family.name, family.plugins)?;
    }
    Ok(families)
}
