//! `--version`.

use crate::failure::{self, Failure};
use crate::output::print_data;

/// The commit of the sources, where the build knew it; else empty.
const COMMIT: &str = env!("MANYLIGHT_COMMIT");

/// Prints the version, the commit, and the instruction set in use.
///
/// # Errors
/// Standard output fails.
pub(crate) fn print() -> Result<u8, Failure> {
    let version = env!("CARGO_PKG_VERSION");
    let instructions = manylight::instruction_set();
    print_data(match COMMIT {
        "" => format!("manylight {version} ({instructions})"),
        commit => format!("manylight {version} (commit {commit}, {instructions})"),
    })?;
    Ok(failure::DONE)
}
