//! Checks of the names in a plan.

use super::names::{NAMES, expected, is_file_name_part};
use super::plan::{StudyPlan, StudyTask};
use super::plan_text::PlanText;
use crate::error::PlanError;

/// Checks that scenes, methods and tasks have distinct, valid names, and that tasks and ratios refer to existing ones.
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
