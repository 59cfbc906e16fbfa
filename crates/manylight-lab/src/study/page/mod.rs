//! The page of a study: a plan and its results as tables. Equal results give an equal page.

mod data;
mod overview;
mod ratios;
mod tasks;
#[cfg(test)]
mod tests;

use super::plan::StudyPlan;
use super::record::RunStatus;
use super::results::Results;
use super::runs::Run;
use crate::document::Document;
use crate::text::three_digits;
use data::PageData;

/// The page of a plan. `command` is the command line of the study, as the page states it.
pub fn page(plan: &StudyPlan, runs: &[Run], results: &Results, command: &str) -> Document {
    let data = PageData { plan, results };
    let mut out = Document::default();
    overview::title(&mut out, data, runs, command);
    overview::scenes(&mut out, data, runs);
    overview::methods(&mut out, plan);
    for task in &plan.tasks {
        tasks::task(&mut out, data, task);
    }
    ratios::ratios(&mut out, data);
    remarks(&mut out, results, runs);
    out
}

/// Remarks on runs that failed, were stopped or unavailable, or do not belong to the present plan.
fn remarks(out: &mut Document, results: &Results, runs: &[Run]) {
    let mut list = Vec::new();
    for run in runs {
        let Some(record) = results.get(&run.key()) else {
            continue;
        };
        let title = run.title();
        match record.status {
            RunStatus::Done => {}
            RunStatus::Failed => list.push(format!("{title}: {}", record.headline())),
            RunStatus::Unavailable => {
                list.push(format!("{title}: unavailable: {}", record.headline()));
            }
            RunStatus::Stopped => list.push(format!(
                "{title}: † stopped after {} s",
                three_digits(record.limit.unwrap_or(record.seconds))
            )),
        }
        if !record.is_of(run) {
            list.push(format!(
                "{title}: measured before the plan or the settings of the method were changed"
            ));
        }
    }
    if !list.is_empty() {
        out.heading(2, "Remarks");
        out.list(list);
    }
}
