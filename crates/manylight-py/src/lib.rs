//! The native module of the Python package `manylight`.
//!
//! It is a thin layer: [`manylight_cli::embed`] renders, `image` shows pictures as numpy arrays,
//! `errors` makes exceptions of failures. The public interface and its documentation are in the
//! Python sources; names, defaults and help of options come from the command line (`options`).
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers.
//!
//! ```text
//!  2 render passes parts maps compare
//!  1 scene image options waiting
//!  0 errors
//! ```

mod compare;
mod errors;
mod image;
mod maps;
mod options;
mod parts;
mod passes;
mod render;
mod scene;
mod waiting;

use manylight_lab::text::parse_duration;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Seconds of a text such as `10m`, as `--time` of the command takes it.
#[pyfunction]
fn seconds(py: Python<'_>, text: &str) -> PyResult<f64> {
    parse_duration(text)
        .map(|duration| duration.as_secs_f64())
        .map_err(|expected| errors::usage(py, &format!("found '{text}'"), &expected))
}

/// The relative error of a text such as `2%`, as `--target-error` of the command takes it.
#[pyfunction]
fn relative_error(py: Python<'_>, text: &str) -> PyResult<f32> {
    manylight_cli::embed::relative_error(text)
        .map_err(|expected| errors::usage(py, &format!("found '{text}'"), &expected))
}

/// The file of a frame of a walkthrough, counted from 1, for the name of all.
#[pyfunction]
fn frame_file(path: PathBuf, frame: u32) -> PathBuf {
    manylight_cli::embed::frame_file(&path, frame)
}

/// Runs the command `manylight` with these words, the first of which is its name. Returns its exit
/// code.
#[pyfunction]
fn run_command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| manylight_cli::run_command(words))
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    manylight_cli::select_instructions()
        .map_err(|failure| errors::exception(module.py(), &failure))?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("instruction_set", ::manylight::instruction_set())?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<image::Image>()?;
    module.add_class::<passes::Passes>()?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(scene::plugins, module)?)?;
    module.add_function(wrap_pyfunction!(scene::read_cameras, module)?)?;
    module.add_function(wrap_pyfunction!(render::render, module)?)?;
    module.add_function(wrap_pyfunction!(passes::passes, module)?)?;
    module.add_function(wrap_pyfunction!(parts::render_part, module)?)?;
    module.add_function(wrap_pyfunction!(parts::merge, module)?)?;
    module.add_function(wrap_pyfunction!(parts::part_info, module)?)?;
    module.add_function(wrap_pyfunction!(image::read_image, module)?)?;
    module.add_function(wrap_pyfunction!(maps::maps, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(options::options, module)?)?;
    module.add_function(wrap_pyfunction!(options::pass_limit, module)?)?;
    module.add_function(wrap_pyfunction!(options::keeps_lights, module)?)?;
    module.add_function(wrap_pyfunction!(frame_file, module)?)?;
    module.add_function(wrap_pyfunction!(seconds, module)?)?;
    module.add_function(wrap_pyfunction!(relative_error, module)?)?;
    module.add_function(wrap_pyfunction!(run_command, module)?)?;
    Ok(())
}
