//! Renders.

use crate::errors::exception;
use crate::image::Image;
use crate::scene::Scene;
use crate::waiting::wait_for;
use manylight_cli::Interrupt;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeWarning};
use pyo3::prelude::*;
use std::ffi::CString;

/// Renders a scene. `words` are options of `manylight render`; `progress` is called with (passes,
/// total passes or None, seconds) after each pass. The metadata has no command to repeat the render
/// if files that `words` name do not stay.
#[pyfunction]
#[pyo3(signature = (scene, words, progress=None, files_stay=true))]
pub(crate) fn render(
    py: Python<'_>,
    scene: &Scene,
    words: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
    files_stay: bool,
) -> PyResult<Image> {
    let (held, interrupt) = (scene.held(), Interrupt::default());
    let (rendered, _) = wait_for(py, &interrupt, progress.as_ref(), |observer| {
        held.session(&words)?.render(&interrupt, observer)
    })?;
    let Some(rendered) = rendered.map_err(|failure| exception(py, &failure))? else {
        return Err(PyKeyboardInterrupt::new_err(
            "neither lights nor a picture were made",
        ));
    };
    for failure in &rendered.failures {
        warn(py, &failure.to_string())?;
    }
    let image = Image::new(rendered.picture, rendered.interrupted, scene.label());
    Ok(match files_stay {
        true => image,
        false => image.without_command(),
    })
}

/// Issues a warning.
pub(crate) fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let message = CString::new(message.replace('\0', ""))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 2)
}
