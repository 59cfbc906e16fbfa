//! The options of a render as keywords.

use crate::errors::{exception, keywords};
use manylight_cli::embed;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

/// The options of a render by keyword, in the order of the help: (help, default or None, whether it
/// belongs to loading the scene).
#[pyfunction]
pub(crate) fn options(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let options = PyDict::new(py);
    for option in embed::render_options() {
        let default = match &option.default {
            Some(Value::Number(number)) if number.is_u64() => {
                Some(number.as_u64().into_pyobject(py)?.into_any())
            }
            Some(Value::Number(number)) => Some(number.as_f64().into_pyobject(py)?.into_any()),
            Some(Value::String(text)) => Some(text.into_pyobject(py)?.into_any()),
            _ => None,
        };
        let name = option.name.replace('-', "_");
        options.set_item(name, (keywords(&option.help), default, option.loads_scene))?;
    }
    Ok(options)
}

/// The number of passes of a render; None if another limit ends it. `words` are options of
/// `manylight render`.
#[pyfunction]
pub(crate) fn pass_limit(py: Python<'_>, words: Vec<String>) -> PyResult<Option<u32>> {
    embed::pass_limit(&words).map_err(|failure| exception(py, &failure))
}

/// Whether a render has virtual lights that can be kept in a file. `words` are options of
/// `manylight render`.
#[pyfunction]
pub(crate) fn keeps_lights(py: Python<'_>, words: Vec<String>) -> PyResult<bool> {
    embed::keeps_lights(&words).map_err(|failure| exception(py, &failure))
}
