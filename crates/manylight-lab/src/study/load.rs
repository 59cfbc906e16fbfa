//! Reading and checking a plan.

use super::check::check_names;
use super::plan::StudyPlan;
use super::plan_text::PlanText;
use super::program::RenderInterface;
use super::scale::at_scale;
use crate::error::{LabError, PlanError};
use manylight_io::read_text;
use std::path::Path;

/// Reads the plan at `path` and checks its names. `scale` selects one of its scales, by default the first.
///
/// # Errors
/// The file cannot be read, is not a plan, refers to something that it or `program` does not define, or has no such scale.
pub fn load_plan(
    path: &Path,
    scale: Option<&str>,
    program: &dyn RenderInterface,
) -> Result<StudyPlan, LabError> {
    let text = read_text(path)?;
    Ok(parse_plan(path, text, scale, program)?)
}

/// [`load_plan`] for the text of the file.
pub(super) fn parse_plan(
    path: &Path,
    text: String,
    scale: Option<&str>,
    program: &dyn RenderInterface,
) -> Result<StudyPlan, Box<PlanError>> {
    let (text, scale) = at_scale(PlanText::new(path, text), scale)?;
    let plan: Result<StudyPlan, _> = serde_json::from_str(text.as_str());
    let mut plan = plan.map_err(|error| text.malformed(&error))?;
    plan.path = path.to_owned();
    plan.scale = scale;
    for method in &mut plan.methods {
        method.resolve(program).map_err(|[name, message]| {
            let help = "`manylight list methods` lists the methods";
            Box::new(text.problem(&name, message, help))
        })?;
    }
    plan.text = text;
    check_names(&plan)?;
    Ok(plan)
}
