//! Plans of studies.

use crate::folder::with_file;
use crate::messages::check_diagnostic;
use manylight_lab::study::{MethodSummary, RenderInterface, RenderSettings, load_plan, plan_runs};

/// Reads a plan at its first scale and at one called `quick`, and lists its runs.
pub(crate) fn check(input: &[u8]) {
    with_file(input, "plan.json", |path| {
        for scale in [None, Some("quick")] {
            let plan = match load_plan(path, scale, &Program) {
                Ok(plan) => plan,
                Err(error) => {
                    check_diagnostic(&error);
                    continue;
                }
            };
            match plan_runs(&plan, &Program) {
                Ok(runs) => runs.iter().for_each(|run| {
                    let _ = (run.key(), run.title(), run.reference());
                }),
                Err(error) => check_diagnostic(&error),
            }
        }
    });
}

/// A program with some methods, which accepts all options but one.
struct Program;

impl RenderInterface for Program {
    fn methods(&self) -> Vec<MethodSummary> {
        ["rich-vpl", "vpl", "path"]
            .map(|name| MethodSummary {
                name,
                summary: "A method",
            })
            .to_vec()
    }

    fn interpret(&self, words: &[&str]) -> Result<RenderSettings, String> {
        if words.contains(&"--json") {
            return Err("options of a plan name no outputs".into());
        }
        Ok(RenderSettings::default())
    }
}
