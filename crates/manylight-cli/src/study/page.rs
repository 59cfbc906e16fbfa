//! The page: a plan and its results. The same results give the same page.

use super::figures::{DEFAULT, Figure, number};
use super::method::Method;
use super::plan::{Plan, Ratio, Scene, Task};
use super::results::{Record, Results, Status};
use super::runs::{Run, key};
use super::statistics::{geometric_mean, log_log_slope};
use crate::document::{Cell, Document, Line, Plot, Table};
use crate::failure::plural;
use std::collections::BTreeSet;

/// A stage that takes a smaller share of every run's time has no row.
const SMALLEST_STAGE: f64 = 0.005;

/// The page of a plan; `command` is how it is called there.
pub(crate) fn page(plan: &Plan, runs: &[Run], results: &Results, command: &str) -> Document {
    let mut page = Page {
        plan,
        results,
        out: Document::default(),
    };
    page.head(runs, command);
    page.scenes(runs);
    page.methods();
    for task in &plan.tasks {
        page.task(task);
    }
    page.ratios();
    page.remarks(runs);
    page.out
}

struct Page<'p> {
    plan: &'p Plan,
    results: &'p Results,
    out: Document,
}

impl Page<'_> {
    fn head(&mut self, runs: &[Run], command: &str) {
        let records: Vec<&Record> = (runs.iter())
            .filter_map(|run| self.results.get(&run.key()))
            .collect();
        let one_of_each = |text: &dyn Fn(&Record) -> String| {
            let all: BTreeSet<String> = records.iter().map(|record| text(record)).collect();
            Vec::from_iter(all).join("; ")
        };
        self.out.heading(1, &self.plan.title);
        self.out
            .comment("Written by `manylight study`: change the plan, not this page.");
        let mut made = format!(
            "Made by `{command}`: {} of {} run{}",
            records.len(),
            runs.len(),
            plural(runs.len())
        );
        if !records.is_empty() {
            let day = |record: &Record| record.date.get(..10).map(str::to_owned);
            let days: BTreeSet<String> = records.iter().filter_map(|record| day(record)).collect();
            let (first, last) = (days.first(), days.last());
            let machines = one_of_each(&|r| {
                let threads = r.told("/settings/threads").unwrap_or(0.0);
                let used = match threads > 0.0 {
                    true => threads as usize,
                    false => r.machine.threads,
                };
                format!("{}, {used} thread{}", r.machine.cpu, plural(used))
            });
            let versions = one_of_each(&|r| r.version.clone());
            made += &format!(" by version {versions} on {machines}, ");
            made += &match (first, last) {
                (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
                _ => first.cloned().unwrap_or_default(),
            };
        }
        self.out.paragraph(format!("{made}."));
        self.out.paragraph(&self.plan.notes);
        self.out.paragraph(
            "The best of a column is **bold**; `-`: not measured, or there is no such figure; †: stopped at the limit of \
             time, and not compared.",
        );
    }

    fn scenes(&mut self, runs: &[Run]) {
        self.out.heading(2, "Scenes");
        let head = ["scene", "file", "size", "longest path", "reference's noise"];
        let mut table = Table::new(head.map(String::from));
        for scene in &self.plan.scenes {
            let depth = match scene.max_depth {
                -1 => "no limit".into(),
                depth => depth.to_string(),
            };
            let of_scene = runs.iter().filter(|run| run.scene.name == scene.name);
            let noise = (of_scene.filter_map(|run| self.results.get(&run.key())))
                .find_map(|record| record.metric("/reference_noise/relmse"))
                .map_or("-".into(), |relmse| {
                    format!("{} %", number(100.0 * relmse.sqrt()))
                });
            let cells = [
                &scene.title,
                &format!("`{}`", scene.file),
                &scene.size,
                &depth,
                &noise,
            ];
            table.push(cells.map(Cell::plain));
        }
        self.out.table(table);
        self.out.paragraph(
            "The noise of a reference is the root of the relMSE that it has by itself. Squared errors below are without it.",
        );
    }

    fn methods(&mut self) {
        self.out.heading(2, "Methods");
        let described = self.plan.methods.iter().map(|method| {
            let renderer = &method.renderer;
            let program = renderer.program().iter().map(String::as_str);
            let words = program.chain(renderer.first_options());
            let options: Vec<&str> = words.chain([method.options.as_str()]).collect();
            let options = options.join(" ");
            let (label, summary) = (&method.label, renderer.summary());
            let text = format!(
                "**{label}** (`{}`): {summary}. {}",
                options.trim(),
                method.notes
            );
            text.trim_end().to_owned()
        });
        self.out.list(described.collect());
        let settings: Vec<_> = (self.plan.methods.iter())
            .map(|method| (method, Run::settings_of(method)))
            .filter(|(_, settings)| !settings.is_empty())
            .collect();
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in settings.iter().flat_map(|(_, settings)| settings) {
            if !names.contains(name) {
                names.push(name);
            }
        }
        let mut table = Table::new(
            std::iter::once("settings")
                .chain(names.iter().copied())
                .map(String::from),
        );
        for (method, settings) in &settings {
            let value = |name: &&str| {
                let found = settings.iter().find(|(n, _)| n == name);
                Cell::plain(found.map_or("", |(_, value)| value))
            };
            table.push(std::iter::once(Cell::plain(&method.label)).chain(names.iter().map(value)));
        }
        self.out.table(table);
    }

    fn task(&mut self, task: &Task) {
        self.out.heading(2, &task.title);
        let budgets = task.budget_values();
        let last = budgets.last().copied().flatten();
        let mut asked = task.options.clone();
        if let Some(budgets) = &task.budgets {
            asked = format!("{asked} {} {}", budgets.option, budgets.values.join(" | "));
        }
        if !asked.is_empty() {
            self.out.paragraph(format!("`{}`", asked.trim()));
        }
        self.out.paragraph(&task.notes);
        let figures = task.figures.as_deref().unwrap_or(DEFAULT);
        if let (Some(budgets), Some(last)) = (&task.budgets, last) {
            self.convergence(task);
            if !figures.is_empty() {
                self.out
                    .paragraph(format!("What follows is for `{} {last}`.", budgets.option));
            }
        }
        for &figure in figures {
            let table = match figure {
                Figure::Stages => self.stages(task, last),
                figure => self.figure(task, last, figure),
            };
            self.out
                .heading(3, format!("{}: {}", task.title, figure.title()));
            self.out.paragraph(figure.remark());
            self.out.table(table);
        }
    }

    fn figure(&self, task: &Task, budget: Option<&str>, figure: Figure) -> Table {
        let cell =
            |scene: &Scene, method: &Method| figure.cell(self.record(task, budget, scene, method));
        self.by_method_and_scene(task, cell)
    }

    fn by_method_and_scene(&self, task: &Task, cell: impl Fn(&Scene, &Method) -> Cell) -> Table {
        let mut table = Table::new(self.head_of(task, &["method"]));
        for method in self.plan.methods_of(task) {
            let cells = self.plan.scenes_of(task).map(|scene| cell(scene, method));
            table.push(std::iter::once(Cell::plain(&method.label)).chain(cells));
        }
        table
    }

    fn stages(&self, task: &Task, budget: Option<&str>) -> Table {
        let mut table = Table::new(self.head_of(task, &["method", "stage"]));
        for method in self.plan.methods_of(task) {
            let records: Vec<Option<&Record>> = (self.plan.scenes_of(task))
                .map(|scene| self.record(task, budget, scene, method))
                .collect();
            let mut names: Vec<&str> = Vec::new();
            for record in records.iter().flatten() {
                let total = record.render_seconds().unwrap_or(0.0);
                for (name, seconds) in record.stages() {
                    if seconds > SMALLEST_STAGE * total && !names.contains(&name) {
                        names.push(name);
                    }
                }
            }
            for name in names {
                let seconds = |record: &Option<&Record>| {
                    let stages = record.map(Record::stages).unwrap_or_default();
                    let found = stages.iter().find(|(n, _)| *n == name);
                    Cell::plain(found.map_or(String::new(), |(_, seconds)| number(*seconds)))
                };
                let head = [&method.label, name].map(Cell::plain);
                table.push(head.into_iter().chain(records.iter().map(seconds)));
            }
        }
        table
    }

    /// How errors fall from budget to budget.
    fn convergence(&mut self, task: &Task) {
        let budgets = task.budget_values();
        let points = |scene: &Scene, method: &Method| -> Vec<Option<(f64, f64)>> {
            let record = |budget: &Option<&str>| self.record(task, *budget, scene, method);
            let point = |record: &Record| {
                let settled = record.status == Status::Done;
                let seconds = Figure::Seconds.value(record).filter(|_| settled)?;
                Some((seconds, Figure::RootRelmse.value(record)?))
            };
            budgets.iter().map(|b| record(b).and_then(point)).collect()
        };
        let errors = self.by_method_and_scene(task, |scene, method| {
            let points = points(scene, method);
            if points.iter().all(Option::is_none) {
                return Cell::default();
            }
            let texts = points.iter().map(|p| p.map_or("-".into(), |p| number(p.1)));
            Cell::plain(texts.collect::<Vec<String>>().join(" · "))
        });
        let slopes = self.by_method_and_scene(task, |scene, method| {
            let points = points(scene, method).into_iter().flatten();
            let mut points: Vec<(f64, f64)> = points.collect();
            // Where a budget bought no further pass, the picture is the same, and only its time is not.
            points.dedup_by(|next, last| next.1 == last.1);
            match log_log_slope(&points) {
                Some(slope) => Cell {
                    text: format!("{slope:.2}"),
                    rank: Some(slope),
                },
                None => Cell::default(),
            }
        });
        let plot = |scene: &Scene| Plot {
            title: scene.title.clone(),
            x: "seconds".into(),
            y: "root of relMSE".into(),
            lines: (self.plan.methods_of(task))
                .map(|method| Line {
                    name: method.label.clone(),
                    points: points(scene, method).into_iter().flatten().collect(),
                })
                .collect(),
        };
        let plots: Vec<Plot> = self.plan.scenes_of(task).map(plot).collect();
        self.out
            .heading(3, format!("{}: root of relMSE", task.title));
        plots.into_iter().for_each(|plot| self.out.plot(plot));
        self.out.table(errors);
        self.out
            .heading(3, format!("{}: slope of that over seconds", task.title));
        self.out.paragraph(
            "The exponent of time by least squares in logarithms. Noise of independent samples falls with -0.5; what is biased \
             and does not shrink flattens it.",
        );
        self.out.table(slopes);
    }

    fn ratios(&mut self) {
        if self.plan.ratios.is_empty() {
            return;
        }
        self.out.heading(2, "Ratios");
        self.out.paragraph(
            "Below 1, the first method's figure is the smaller one. The mean is the geometric one.",
        );
        for ratio in &self.plan.ratios {
            self.ratio(ratio);
        }
    }

    fn ratio(&mut self, ratio: &Ratio) {
        let tasks = self.plan.tasks.iter();
        let mut tasks =
            tasks.flat_map(|task| task.budget_values().into_iter().map(move |b| (task, b)));
        // The plan was checked: there is one.
        let Some((task, budget)) = tasks.find(|(task, b)| task.name_with(*b) == ratio.task) else {
            return;
        };
        let mut table =
            Table::new((self.head_of(task, &["figure"]).into_iter()).chain(["mean".to_string()]));
        for figure in ratio.figures() {
            let value = |scene: &Scene, label: &str| {
                let record = self.results.get(&key(&scene.name, label, &ratio.task))?;
                figure
                    .value(record)
                    .filter(|_| record.status == Status::Done)
            };
            let quotients: Vec<Option<f64>> = (self.plan.scenes_of(task))
                .map(|scene| Some(value(scene, &ratio.of)? / value(scene, &ratio.over)?))
                .map(|quotient| quotient.filter(|q| q.is_finite()))
                .collect();
            let known: Vec<f64> = quotients.iter().copied().flatten().collect();
            let cell = |q: Option<f64>| Cell::plain(q.map_or(String::new(), number));
            let cells = quotients.iter().copied().chain([geometric_mean(&known)]);
            table.push(std::iter::once(Cell::plain(figure.title())).chain(cells.map(cell)));
        }
        let budget = budget.map_or(String::new(), |budget| format!(" ({budget})"));
        let title = format!("{} over {}: {}{budget}", ratio.of, ratio.over, task.title);
        self.out.heading(3, title);
        self.out.table(table);
    }

    /// What a reader should know about single runs.
    fn remarks(&mut self, runs: &[Run]) {
        let mut list = Vec::new();
        for run in runs {
            let Some(record) = self.results.get(&run.key()) else {
                continue;
            };
            let title = run.title();
            match record.status {
                Status::Done => {}
                Status::Failed => list.push(format!("{title}: {}", record.headline())),
                Status::Stopped => list.push(format!(
                    "{title}: † stopped after {} s",
                    number(record.limit.unwrap_or(record.seconds))
                )),
            }
            if !record.is_of(run) {
                list.push(format!(
                    "{title}: measured before the plan or the method's settings were changed"
                ));
            }
        }
        if !list.is_empty() {
            self.out.heading(2, "Remarks");
            self.out.list(list);
        }
    }

    fn record(
        &self,
        task: &Task,
        budget: Option<&str>,
        scene: &Scene,
        method: &Method,
    ) -> Option<&Record> {
        let task = task.name_with(budget);
        self.results.get(&key(&scene.name, &method.label, &task))
    }

    fn head_of(&self, task: &Task, first: &[&str]) -> Vec<String> {
        let scenes = self.plan.scenes_of(task).map(|scene| scene.title.clone());
        first
            .iter()
            .copied()
            .map(String::from)
            .chain(scenes)
            .collect()
    }
}

#[cfg(test)]
mod tests;
