//! The section of ratios between methods.

use super::super::measured::value;
use super::super::plan::{Ratio, StudyScene};
use super::super::record::RunStatus;
use super::super::runs::run_key;
use super::super::statistics::geometric_mean;
use super::data::PageData;
use crate::document::{Document, DocumentTable, TableCell};
use crate::text::three_digits;

/// All ratios of the plan.
pub(super) fn ratios(out: &mut Document, data: PageData) {
    if data.plan.ratios.is_empty() {
        return;
    }
    out.heading(2, "Ratios");
    out.paragraph(
        "Value of the first method over value of the second; the mean is the geometric mean over the scenes.",
    );
    for ratio in &data.plan.ratios {
        self::ratio(out, data, ratio);
    }
}

/// The table of one ratio: one row per quantity, one column per scene.
fn ratio(out: &mut Document, data: PageData, ratio: &Ratio) {
    let tasks = data.plan.tasks.iter();
    let mut tasks = tasks.flat_map(|task| task.budget_values().into_iter().map(move |b| (task, b)));
    let (task, budget) = tasks
        .find(|(task, budget)| task.name_with(*budget) == ratio.task)
        .expect("invariant: the tasks of ratios were checked");
    let mut head = data.head_of(task, &["figure"]);
    head.push("mean".into());
    let mut table = DocumentTable::new(head);
    for quantity in ratio.quantities() {
        let value_of = |scene: &StudyScene, label: &str| {
            let record = data
                .results
                .get(&run_key(&scene.name, label, &ratio.task))?;
            value(quantity, record).filter(|_| record.status == RunStatus::Done)
        };
        let quotients: Vec<Option<f64>> = (data.plan.scenes_of(task))
            .map(|scene| Some(value_of(scene, &ratio.of)? / value_of(scene, &ratio.over)?))
            .map(|quotient| quotient.filter(|q| q.is_finite()))
            .collect();
        let known: Vec<f64> = quotients.iter().copied().flatten().collect();
        let cell = |q: Option<f64>| TableCell::plain(q.map_or(String::new(), three_digits));
        let cells = quotients.iter().copied().chain([geometric_mean(&known)]);
        table.push(std::iter::once(TableCell::plain(quantity.title())).chain(cells.map(cell)));
    }
    let budget = budget.map_or(String::new(), |budget| format!(" ({budget})"));
    let title = format!("{} over {}: {}{budget}", ratio.of, ratio.over, task.title);
    out.heading(3, title);
    out.table(table);
}
