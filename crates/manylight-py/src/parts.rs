//! Shares of a render in part files.

use crate::errors::exception;
use crate::image::Image;
use crate::scene::Scene;
use crate::waiting::wait_for;
use manylight_cli::Interrupt;
use manylight_cli::embed::{self, PartBlocks};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// Renders a share (index from 1, count) or a range of blocks (first, end) to the part file `path`.
/// A render of blocks is `open` if it has no number of passes.
#[pyfunction]
#[pyo3(signature = (scene, words, path, share=None, blocks=None, open=false, progress=None))]
#[expect(clippy::too_many_arguments, reason = "arguments of Python have names")]
pub(crate) fn render_part(
    py: Python<'_>,
    scene: &Scene,
    words: Vec<String>,
    path: PathBuf,
    share: Option<(u32, NonZeroU32)>,
    blocks: Option<(u32, u32)>,
    open: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    let blocks = match (share, blocks) {
        (Some((index, count)), None) => PartBlocks::Share { index, count },
        (None, Some((first, end))) if open => PartBlocks::OpenBlocks(first..end),
        (None, Some((first, end))) => PartBlocks::Blocks(first..end),
        _ => {
            return Err(PyValueError::new_err(
                "expected either a share or a range of blocks",
            ));
        }
    };
    let (held, interrupt) = (scene.held(), Interrupt::default());
    let (result, _) = wait_for(py, &interrupt, progress.as_ref(), |observer| {
        let session = held.session(&words)?;
        embed::render_part(&session, blocks, &path, &interrupt, observer)
    })?;
    match result {
        Ok(true) => Ok(()),
        Ok(false) => Err(PyKeyboardInterrupt::new_err("no part was written")),
        Err(failure) => Err(exception(py, &failure)),
    }
}

/// Merges part files to a picture.
#[pyfunction]
pub(crate) fn merge(py: Python<'_>, parts: Vec<PathBuf>) -> PyResult<Image> {
    let picture = py.detach(|| embed::merge(&parts));
    let picture = picture.map_err(|failure| exception(py, &failure))?;
    Ok(Image::new(picture, false, None))
}

/// Checks a part file, and returns what it says, as JSON.
#[pyfunction]
pub(crate) fn part_info(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let header = py.detach(|| embed::part_header(&path));
    let header = header.map_err(|failure| exception(py, &failure))?;
    Ok(header.to_string())
}
