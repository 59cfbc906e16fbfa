//! Whether two parts belong to one render.

use crate::failure::Failure;
use manylight_io::part::PartFile;
use serde_json::{Map, Value};

/// Refuses a part of another render. `other` names the render with the identity `expected`, such as
/// "this command".
///
/// # Errors
/// The first setting in which they differ, with both values.
pub(crate) fn check_identity(
    part: &PartFile,
    expected: &Map<String, Value>,
    other: &str,
) -> Result<(), Failure> {
    let found = &part.header().render;
    let keys = expected.keys().chain(found.keys());
    let Some(key) = keys
        .into_iter()
        .find(|key| found.get(*key) != expected.get(*key))
    else {
        return Ok(());
    };
    let text = |map: &Map<String, Value>| match map.get(key) {
        Some(Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
        None => "nothing".into(),
    };
    Err(Failure::usage(
        format!(
            "{} is a part of another render: its {key} is {}, that of {other} {}",
            part.path().display(),
            text(found),
            text(expected)
        ),
        "parts of one render have the same scene, settings, seed, program and instruction set",
    ))
}
