//! The section of a task.

use super::super::measured::{cell, value};
use super::super::method::StudyMethod;
use super::super::plan::{StudyScene, StudyTask};
use super::super::quantity::{DEFAULT_QUANTITIES, Quantity};
use super::super::record::{Record, RunStatus};
use super::super::statistics::log_log_slope;
use super::data::PageData;
use crate::document::{Document, DocumentTable, Plot, PlotLine, TableCell};
use crate::text::three_digits;

/// A stage with less than this fraction of the rendering time in all runs of a method has no row.
/// Times of equal runs differ by more.
const MIN_STAGE_FRACTION: f64 = 0.005;

/// The tables of a task.
pub(super) fn task(out: &mut Document, data: PageData, task: &StudyTask) {
    out.heading(2, &task.title);
    let last = task.budget_values().last().copied().flatten();
    let mut options = task.options.clone();
    if let Some(budgets) = &task.budgets {
        options = format!(
            "{options} {} {}",
            budgets.option,
            budgets.values.join(" | ")
        );
    }
    if !options.is_empty() {
        out.paragraph(format!("`{}`", options.trim()));
    }
    out.paragraph(&task.notes);
    let quantities = task.figures.as_deref().unwrap_or(DEFAULT_QUANTITIES);
    if let (Some(budgets), Some(last)) = (&task.budgets, last) {
        convergence(out, data, task);
        if !quantities.is_empty() {
            out.paragraph(format!(
                "The tables below are for `{} {last}`.",
                budgets.option
            ));
        }
    }
    for &quantity in quantities {
        let table = match quantity {
            Quantity::Stages => stages(data, task, last),
            quantity => data.by_method_and_scene(task, |scene, method| {
                cell(quantity, data.record(task, last, scene, method))
            }),
        };
        out.heading(3, format!("{}: {}", task.title, quantity.title()));
        out.paragraph(quantity.remark());
        out.table(table);
    }
}

/// Times of the stages: one row per method and stage.
fn stages(data: PageData, task: &StudyTask, budget: Option<&str>) -> DocumentTable {
    let mut table = DocumentTable::new(data.head_of(task, &["method", "stage"]));
    for method in data.plan.methods_of(task) {
        let records: Vec<Option<&Record>> = (data.plan.scenes_of(task))
            .map(|scene| data.record(task, budget, scene, method))
            .collect();
        for name in stage_names(&records) {
            let seconds = |record: &Option<&Record>| {
                let stages = record.map(Record::stages).unwrap_or_default();
                let found = stages.iter().find(|(n, _)| *n == name);
                TableCell::plain(found.map_or(String::new(), |(_, seconds)| three_digits(*seconds)))
            };
            let head = [&method.label, name].map(TableCell::plain);
            table.push(head.into_iter().chain(records.iter().map(seconds)));
        }
    }
    table
}

/// Names of the stages that take a considerable part of the time of a run.
fn stage_names<'r>(records: &[Option<&'r Record>]) -> Vec<&'r str> {
    let mut names: Vec<&str> = Vec::new();
    for record in records.iter().flatten() {
        let total = record.render_seconds().unwrap_or(0.0);
        for (name, seconds) in record.stages() {
            if seconds > MIN_STAGE_FRACTION * total && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// Errors over time: plots, and tables of the errors and of their slopes.
fn convergence(out: &mut Document, data: PageData, task: &StudyTask) {
    let scenes = data.plan.scenes_of(task);
    let plots: Vec<Plot> = scenes.map(|scene| plot(data, task, scene)).collect();
    let errors = data.by_method_and_scene(task, |scene, method| {
        let points = points(data, task, scene, method);
        if points.iter().all(Option::is_none) {
            return TableCell::default();
        }
        let texts = points
            .iter()
            .map(|p| p.map_or("-".into(), |p| three_digits(p.1)));
        TableCell::plain(texts.collect::<Vec<String>>().join(" · "))
    });
    let slopes = data.by_method_and_scene(task, |scene, method| slope(data, task, scene, method));
    out.heading(3, format!("{}: root of relMSE", task.title));
    plots.into_iter().for_each(|plot| out.plot(plot));
    out.table(errors);
    out.heading(3, format!("{}: slope of that over seconds", task.title));
    out.paragraph(
        "The exponent of the error as a power of the time, by least squares in logarithms. The noise of independent samples has the exponent \
         -0.5; bias that does not decrease brings the exponent closer to 0.",
    );
    out.table(slopes);
}

/// For each budget, the rendering time in seconds and the square root of relMSE; `None` if the run
/// is not done.
fn points(
    data: PageData,
    task: &StudyTask,
    scene: &StudyScene,
    method: &StudyMethod,
) -> Vec<Option<(f64, f64)>> {
    let point = |record: &Record| {
        let is_done = record.status == RunStatus::Done;
        let seconds = value(Quantity::Seconds, record).filter(|_| is_done)?;
        Some((seconds, value(Quantity::RootRelmse, record)?))
    };
    let budgets = task.budget_values().into_iter();
    budgets
        .map(|budget| data.record(task, budget, scene, method).and_then(point))
        .collect()
}

/// The exponent of the error as a power of the time.
fn slope(data: PageData, task: &StudyTask, scene: &StudyScene, method: &StudyMethod) -> TableCell {
    let points = points(data, task, scene, method).into_iter().flatten();
    let mut points: Vec<(f64, f64)> = points.collect();
    // Equal errors mean equal images: a larger budget did not suffice for another pass.
    points.dedup_by(|next, last| next.1 == last.1);
    match log_log_slope(&points) {
        Some(slope) => TableCell {
            text: format!("{slope:.2}"),
            rank: Some(slope),
        },
        None => TableCell::default(),
    }
}

/// Errors over time in one scene, with one line per method.
fn plot(data: PageData, task: &StudyTask, scene: &StudyScene) -> Plot {
    let line = |method: &StudyMethod| PlotLine {
        name: method.label.clone(),
        points: points(data, task, scene, method)
            .into_iter()
            .flatten()
            .collect(),
    };
    Plot {
        title: scene.title.clone(),
        x: "seconds".into(),
        y: "root of relMSE".into(),
        lines: data.plan.methods_of(task).map(line).collect(),
    }
}
