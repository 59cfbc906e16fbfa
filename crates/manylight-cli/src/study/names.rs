//! The names in a plan: of what they are made, and that they name what is there.

use super::plan::{Plan, Task};
use super::plan_error::{PlanError, PlanText};

/// What names are made of.
pub(super) const NAMES: &str = "letters, digits, - and _ can";

/// Whether a name is made of what [`NAMES`] says.
pub(super) fn is_file_name_part(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.chars().all(fits)
}

/// The known names, the nearest one first.
pub(super) fn expected<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> String {
    let mut known: Vec<&str> = known.collect();
    let nearness = |other: &str| strsim::jaro_winkler(name, other);
    known.sort_by(|a, b| nearness(b).total_cmp(&nearness(a)));
    format!("expected one of {}", known.join(", "))
}

/// Whether names are there, tell what they name apart, and name what is there.
pub(super) fn check_names(plan: &Plan) -> Result<(), Box<PlanError>> {
    let scenes: Vec<&str> = plan.scenes.iter().map(|s| s.name.as_str()).collect();
    let methods: Vec<&str> = plan.methods.iter().map(|m| m.label.as_str()).collect();
    let tasks: Vec<String> = plan.tasks.iter().flat_map(Task::names).collect();
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
        if let Some(figure) = ratio.figures().into_iter().find(|f| !f.is_one_number()) {
            return Err(Box::new(plan.text.problem(
                figure.name(),
                format!("the figure `{}` is not one number", figure.name()),
                "ratios are taken of figures such as rmse or peak-memory",
            )));
        }
    }
    Ok(())
}

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
                "names tell the results apart",
            )));
        }
    }
    Ok(())
}

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
