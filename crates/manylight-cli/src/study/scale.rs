//! Scales: one plan at several sizes. What differs is written as `{name}` in the plan's texts, and every scale says what that means.

use super::names::{NAMES, expected, is_file_name_part};
use super::plan_error::{PlanError, PlanText};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A size at which a plan can be carried out.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scale {
    /// As `--scale` takes it, and `{scale}` in the plan.
    name: String,
    /// What is written for `{key}`.
    #[serde(default)]
    values: BTreeMap<String, String>,
}

/// The scales of a plan, before anything else of it is looked at.
#[derive(Debug, Deserialize)]
struct Scales {
    #[serde(default)]
    scales: Vec<Scale>,
}

/// The text of a plan at the scale that is asked for, or at its first, with the name of that. A plan without scales stays as it is.
pub(super) fn at_scale(
    text: PlanText,
    asked: Option<&str>,
) -> Result<(PlanText, Option<String>), Box<PlanError>> {
    let scales: Result<Scales, _> = serde_json::from_str(text.as_str());
    let Scales { scales } = scales.map_err(|error| text.malformed(&error))?;
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
                "values of scales are written into other texts: no quotation marks, no backslashes";
            return Err(Box::new(text.problem(key, message, help)));
        }
        filled = filled.replace(&format!("{{{key}}}"), value);
    }
    Ok((text.with(filled), Some(scale.name.clone())))
}

fn unknown(text: &PlanText, name: &str, scales: &[Scale]) -> PlanError {
    let help = match scales {
        [] => "the plan has no scales".into(),
        _ => expected(name, scales.iter().map(|scale| scale.name.as_str())),
    };
    text.problem("scales", format!("the plan has no scale `{name}`"), help)
}
