//! Studies: methods are measured on a set of scenes, and the results are shown as a page of tables.
//!
//! A plan is a JSON file, described in `docs/studies.md`. The modules, in reading order:
//!
//! * [`StudyPlan`], [`load_plan`]: scenes, methods, tasks and ratios, read at one of the plan's
//!   scales and checked.
//! * [`RenderInterface`]: what a study must know of the options of the program that renders. The
//!   program implements it.
//! * [`plan_runs`], [`select_runs`]: the single renders of a plan.
//! * [`Runner`]: makes a run as a child process and compares its image with the reference.
//! * [`Record`], [`Results`]: the result of a run, and one file per result.
//! * [`TimeEstimate`]: the remaining time.
//! * [`page`](page()): tables of the results, as a [`Document`](crate::document::Document).
//! * [`image_groups`]: the images of a study for the [viewer](crate::viewer).

mod child;
mod folders;
mod gallery;
mod load;
mod measured;
mod method;
mod pace;
mod page;
mod plan;
mod plan_text;
mod program;
mod quantity;
mod record;
mod results;
mod runner;
mod runs;
mod statistics;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use folders::StudyFolders;
pub use gallery::image_groups;
pub use load::load_plan;
pub use method::{StudyMethod, StudyRenderer};
pub use pace::TimeEstimate;
pub use page::page;
pub use plan::{Budgets, Ratio, StudyPlan, StudyScene, StudyTask};
pub use program::{MethodSummary, RenderInterface, RenderSettings};
pub use quantity::Quantity;
pub use record::{Machine, Record, RunStatus};
pub use results::Results;
pub use runner::Runner;
pub use runs::{Run, plan_runs, select_runs};
