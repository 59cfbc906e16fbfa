//! The interim maps of a many-light method as numpy arrays.

use crate::errors::exception;
use crate::scene::Scene;
use crate::waiting::wait_for;
use manylight::integrators::PlacedLight;
use manylight_cli::Interrupt;
use manylight_cli::embed::interim_maps;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Maps of the first pass of a render, by name. `words` are options of `manylight render`.
#[pyfunction]
pub(crate) fn maps<'py>(
    py: Python<'py>,
    scene: &Scene,
    words: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (held, interrupt) = (scene.held(), Interrupt::default());
    let (maps, _) = wait_for(py, &interrupt, None, |_| {
        interim_maps(&held.session(&words)?, &interrupt)
    })?;
    let Some(maps) = maps.map_err(|failure| exception(py, &failure))? else {
        return Err(PyKeyboardInterrupt::new_err(()));
    };
    let (width, height) = (maps.size.x as usize, maps.size.y as usize);
    let gray = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([height, width]);
    let irradiance = maps.irradiance.iter().flat_map(|e| [e.r, e.g, e.b]);
    let irradiance = PyArray1::from_iter(py, irradiance).reshape([height, width, 3])?;
    let arrays = PyDict::new(py);
    arrays.set_item("importance", gray(maps.importance)?)?;
    arrays.set_item("irradiance", irradiance)?;
    arrays.set_item("product", gray(maps.product)?)?;
    arrays.set_item("shading", gray(maps.shading)?)?;
    arrays.set_item("placed", lights(py, &maps.placed)?)?;
    arrays.set_item("relaxed", lights(py, &maps.relaxed)?)?;
    Ok(arrays)
}

/// (positions, normals, film positions) of lights; a film position is NaN where the camera does not
/// see the light.
fn lights<'py>(py: Python<'py>, lights: &[PlacedLight]) -> PyResult<[Bound<'py, PyAny>; 3]> {
    let rows = |values: Vec<f32>, columns: usize| {
        let array = PyArray1::from_vec(py, values).reshape([lights.len(), columns]);
        array.map(Bound::into_any)
    };
    let seen = |light: &PlacedLight| light.film_position.map_or([f32::NAN; 2], |p| p.to_array());
    Ok([
        rows(
            lights.iter().flat_map(|light| light.p.to_array()).collect(),
            3,
        )?,
        rows(
            lights.iter().flat_map(|light| light.n.to_array()).collect(),
            3,
        )?,
        rows(lights.iter().flat_map(seen).collect(), 2)?,
    ])
}
