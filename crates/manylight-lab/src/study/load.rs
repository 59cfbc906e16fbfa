//! Reading a plan: at one of its scales, variants such as quick and full; and checking its names.
//!
//! Texts of a plan may contain placeholders `{key}`. Each scale defines their values.

use super::plan::{StudyPlan, StudyTask};
use super::plan_text::{NAMES, PlanText, expected, is_file_name_part};
use super::program::RenderInterface;
use crate::error::{LabError, PlanError};
use manylight_io::read_text;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads the plan at `path` and checks its names. `scale` selects one of its scales, by default the
/// first.
///
/// # Errors
/// The file cannot be read, is not a plan, refers to something that it or `program` does not
/// define, or has no such scale.
pub fn load_plan(
    path: &Path,
    scale: Option<&str>,
    program: &dyn RenderInterface,
) -> Result<StudyPlan, LabError> {
    let text = read_text(path)?;
    Ok(parse_plan(path, text, scale, program)?)
}

/// [`load_plan`] for the text of the file.
pub(super) fn parse_plan(
    path: &Path,
    text: String,
    scale: Option<&str>,
    program: &dyn RenderInterface,
) -> Result<StudyPlan, Box<PlanError>> {
    let (text, scale) = at_scale(PlanText::new(path, text), scale)?;
    let plan: Result<StudyPlan, _> = serde_json::from_str(text.as_str());
    let mut plan = plan.map_err(|error| text.malformed(&error))?;
    plan.path = path.to_owned();
    plan.scale = scale;
    for method in &mut plan.methods {
        method.resolve(program).map_err(|[name, message]| {
            let help = "`manylight list methods` lists the methods";
            Box::new(text.problem(&name, message, help))
        })?;
    }
    plan.text = text;
    check_names(&plan)?;
    Ok(plan)
}

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

/// Fills in the placeholders of a plan for the scale `asked`, or for its first scale. Returns the
/// new text and the name of the scale; a plan without scales is unchanged.
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

/// Checks that scenes, methods and tasks have distinct, valid names, and that tasks and ratios
/// refer to existing ones.
///
/// # Errors
/// The first problem, with its place in the plan.
pub(super) fn check_names(plan: &StudyPlan) -> Result<(), Box<PlanError>> {
    let scenes: Vec<&str> = plan.scenes.iter().map(|s| s.name.as_str()).collect();
    let methods: Vec<&str> = plan.methods.iter().map(|m| m.label.as_str()).collect();
    let tasks: Vec<String> = plan.tasks.iter().flat_map(StudyTask::names).collect();
    let tasks: Vec<&str> = tasks.iter().map(String::as_str).collect();
    check_definitions(&plan.text, "scenes", &scenes)?;
    check_definitions(&plan.text, "methods", &methods)?;
    check_definitions(&plan.text, "tasks", &tasks)?;
    for task in &plan.tasks {
        if task.budget_values().is_empty() {
            return Err(Box::new(plan.text.problem(
                &task.name,
                format!("the budgets of the task `{}` have no values", task.name),
                "a task has budgets with at least one value, or none at all",
            )));
        }
        check_uses(
            &plan.text,
            "method",
            task.methods.iter().flatten(),
            &methods,
        )?;
        check_uses(&plan.text, "scene", task.scenes.iter().flatten(), &scenes)?;
    }
    for ratio in &plan.ratios {
        check_uses(&plan.text, "method", [&ratio.of, &ratio.over], &methods)?;
        check_uses(&plan.text, "task", [&ratio.task], &tasks)?;
        if let Some(quantity) = ratio.quantities().into_iter().find(|q| !q.is_scalar()) {
            return Err(Box::new(plan.text.problem(
                quantity.name(),
                format!("the figure `{}` is not one number", quantity.name()),
                "ratios are computed of figures such as rmse or peak-memory",
            )));
        }
    }
    Ok(())
}

/// Checks the names that the section `what` of the plan defines.
fn check_definitions(text: &PlanText, what: &str, names: &[&str]) -> Result<(), Box<PlanError>> {
    if names.is_empty() {
        let message = format!("the plan has no {what}");
        let help = "scenes, methods and tasks have at least one entry each";
        return Err(Box::new(text.problem(what, message, help)));
    }
    for (i, name) in names.iter().enumerate() {
        if !is_file_name_part(name) {
            return Err(Box::new(text.problem(
                name,
                format!("among the {what}: the name `{name}` cannot be part of a file's name"),
                NAMES,
            )));
        }
        if names[..i].contains(name) {
            return Err(Box::new(text.problem(
                name,
                format!("among the {what}: `{name}` is there twice"),
                "names identify the results, so each is used once",
            )));
        }
    }
    Ok(())
}

/// Checks that `names` are among the `known` names of the kind `what`.
fn check_uses<'n>(
    text: &PlanText,
    what: &str,
    names: impl IntoIterator<Item = &'n String>,
    known: &[&str],
) -> Result<(), Box<PlanError>> {
    for name in names {
        if !known.contains(&name.as_str()) {
            let message = format!("the plan has no {what} `{name}`");
            let help = expected(name, known.iter().copied());
            return Err(Box::new(text.problem(name, message, help)));
        }
    }
    Ok(())
}
