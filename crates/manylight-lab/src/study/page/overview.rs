//! The first sections: origin of the results, scenes, methods.

use super::super::plan::StudyPlan;
use super::super::record::{Record, RunStatus};
use super::super::runs::Run;
use super::data::PageData;
use crate::document::{Document, DocumentTable, TableCell};
use crate::text::{plural, three_digits};
use std::collections::BTreeSet;

/// Title, origin of the results, and how to read the tables.
pub(super) fn title(out: &mut Document, data: PageData, runs: &[Run], command: &str) {
    out.heading(1, &data.plan.title);
    out.comment("Written by `manylight study`: change the plan, not this page.");
    out.paragraph(origin(data, runs, command));
    out.paragraph(&data.plan.notes);
    out.paragraph(
        "The best value of a column is **bold**; `-`: not measured or not defined; †: stopped at the time limit, and excluded from the \
         comparison.",
    );
}

/// The command, the number of results of available programs, and their versions, computers and
/// dates.
fn origin(data: PageData, runs: &[Run], command: &str) -> String {
    let records: Vec<&Record> = (runs.iter())
        .filter_map(|run| data.results.get(&run.key()))
        .filter(|record| record.status != RunStatus::Unavailable)
        .collect();
    let start = format!(
        "Made by `{command}`: {} of {} run{}",
        records.len(),
        runs.len(),
        plural(runs.len())
    );
    if records.is_empty() {
        return format!("{start}.");
    }
    let distinct = |text: &dyn Fn(&Record) -> String| {
        let all: BTreeSet<String> = records.iter().map(|record| text(record)).collect();
        Vec::from_iter(all).join("; ")
    };
    let machines = distinct(&|r| {
        let threads = r.report_number("/settings/threads").unwrap_or(0.0);
        let used = match threads > 0.0 {
            true => threads as usize,
            false => r.machine.threads,
        };
        format!("{}, {used} thread{}", r.machine.cpu, plural(used))
    });
    let versions = distinct(&|r| r.version.clone());
    let day = |record: &Record| record.date.get(..10).map(str::to_owned);
    let days: BTreeSet<String> = records.iter().filter_map(|record| day(record)).collect();
    let dates = match (days.first(), days.last()) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (first, _) => first.cloned().unwrap_or_default(),
    };
    format!("{start} by version {versions} on {machines}, {dates}.")
}

/// Table of the scenes, with the noise of their references.
pub(super) fn scenes(out: &mut Document, data: PageData, runs: &[Run]) {
    out.heading(2, "Scenes");
    let head = ["scene", "file", "size", "longest path", "reference's noise"];
    let mut table = DocumentTable::new(head.map(String::from));
    for scene in &data.plan.scenes {
        let depth = match scene.max_depth {
            -1 => "no limit".into(),
            depth => depth.to_string(),
        };
        let of_scene = (runs.iter())
            .filter(|run| run.scene.name == scene.name && run.method.reference.is_none());
        let noise = (of_scene.filter_map(|run| data.results.get(&run.key())))
            .find_map(|record| record.metric("/reference_noise/relmse"))
            .map_or("-".into(), |relmse| {
                format!("{} %", three_digits(100.0 * relmse.sqrt()))
            });
        let cells = [
            &scene.title,
            &format!("`{}`", scene.file),
            &scene.size,
            &depth,
            &noise,
        ];
        table.push(cells.map(TableCell::plain));
    }
    out.table(table);
    out.paragraph(
        "The noise of a reference is the square root of its expected relMSE. It is subtracted from the squared errors below.",
    );
}

/// List of the methods with their options, and table of their settings.
pub(super) fn methods(out: &mut Document, plan: &StudyPlan) {
    out.heading(2, "Methods");
    let described = plan.methods.iter().map(|method| {
        let renderer = &method.renderer;
        let program = renderer.program().iter().map(String::as_str);
        let words = program.chain(renderer.method_options());
        let options: Vec<&str> = words.chain([method.options.as_str()]).collect();
        let options = options.join(" ");
        let (label, summary) = (&method.label, &method.summary);
        let compared = match &method.reference {
            Some(file) => format!("Compared with its own converged images `{file}`. "),
            None => String::new(),
        };
        let text = format!(
            "**{label}** (`{}`): {summary}. {compared}{}",
            options.trim(),
            method.notes
        );
        text.trim_end().to_owned()
    });
    out.list(described.collect());
    out.table(settings(plan));
}

/// Settings of the methods: one row per method, one column per setting.
fn settings(plan: &StudyPlan) -> DocumentTable {
    let with_settings = || plan.methods.iter().filter(|m| !m.settings.is_empty());
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in with_settings().flat_map(|method| &method.settings) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let head = std::iter::once("settings").chain(names.iter().copied());
    let mut table = DocumentTable::new(head.map(String::from));
    for method in with_settings() {
        let value = |name: &&str| {
            let found = method.settings.iter().find(|(n, _)| n == name);
            TableCell::plain(found.map_or("", |(_, value)| value))
        };
        let label = TableCell::plain(&method.label);
        table.push(std::iter::once(label).chain(names.iter().map(value)));
    }
    table
}
