//! A study: every method on a set of scenes, measured run by run and shown as a page of tables.
//!
//! `plan` says what is to be measured, at what `scale`, and `runs` spells it out; `child` makes one run, a process of its own; `results` keeps
//! what came out, one file per run; `page` shows `figures` of them.

mod child;
mod figures;
mod files;
mod machine;
mod method;
mod names;
mod pace;
mod page;
mod plan;
mod plan_error;
mod results;
mod runs;
mod scale;
mod statistics;

pub(crate) use child::{Ended, Ending, spawn_and_wait};
pub(crate) use files::{Files, absolute};
pub(crate) use machine::Machine;
pub(crate) use pace::Pace;
pub(crate) use page::page;
pub(crate) use plan::Plan;
pub(crate) use plan_error::PlanError;
pub(crate) use results::{Record, Results, Status};
pub(crate) use runs::{Run, select};
