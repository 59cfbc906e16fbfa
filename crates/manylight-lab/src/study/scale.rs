//! Scales: variants of one plan, such as quick and full.
//!
//! Texts of a plan may contain placeholders `{key}`. Each scale defines their values.

use super::names::{NAMES, expected, is_file_name_part};
use super::plan_text::PlanText;
use crate::error::PlanError;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A variant of a plan.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanScale {
    /// Name, as `--scale` takes it; it also replaces `{scale}`.
    name: String,
    /// The replacement of each `{key}`.
    #[serde(default)]
    values: BTreeMap<String, String>,
}

/// The section `scales` of a plan. It is read before the rest.
#[derive(Debug, Deserialize)]
struct ScaleSection {
    #[serde(default)]
    scales: Vec<PlanScale>,
}

/// Fills in the placeholders of a plan for the scale `asked`, or for its first scale. Returns the new text and the name of the scale; a plan
/// without scales is unchanged.
///
/// # Errors
/// The text is no JSON object, has no such scale, or the scale has an invalid name or value.
pub(super) fn at_scale(
    text: PlanText,
    asked: Option<&str>,
) -> Result<(PlanText, Option<String>), Box<PlanError>> {
    let scales: Result<ScaleSection, _> = serde_json::from_str(text.as_str());
    let ScaleSection { scales } = scales.map_err(|error| text.malformed(&error))?;
    let chosen = match asked {
        None => scales.first(),
        Some(name) => scales.iter().find(|scale| scale.name == name),
    };
    let Some(scale) = chosen else {
        return match asked {
            None => Ok((text, None)),
            Some(name) => Err(Box::new(unknown(&text, name, &scales))),
        };
    };
    if !is_file_name_part(&scale.name) {
        let message = format!("the scale `{}` cannot be part of a file's name", scale.name);
        return Err(Box::new(text.problem(&scale.name, message, NAMES)));
    }
    let mut filled = text.as_str().replace("{scale}", &scale.name);
    for (key, value) in &scale.values {
        if value.contains(|c: char| c == '"' || c == '\\' || c.is_control()) {
            let message = format!(
                "the scale `{}` cannot have `{value}` for `{key}`",
                scale.name
            );
            let help =
                "values of scales become part of other texts: no quotation marks, no backslashes";
            return Err(Box::new(text.problem(key, message, help)));
        }
        filled = filled.replace(&format!("{{{key}}}"), value);
    }
    Ok((text.with(filled), Some(scale.name.clone())))
}

/// The scale `name` does not exist.
fn unknown(text: &PlanText, name: &str, scales: &[PlanScale]) -> PlanError {
    let help = match scales {
        [] => "the plan has no scales".into(),
        _ => expected(name, scales.iter().map(|scale| scale.name.as_str())),
    };
    text.problem("scales", format!("the plan has no scale `{name}`"), help)
}
