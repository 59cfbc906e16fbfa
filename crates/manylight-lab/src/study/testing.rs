//! A program for tests of plans.

use super::load::parse_plan;
use super::plan::StudyPlan;
use super::program::{MethodSummary, RenderInterface, RenderSettings};
use crate::error::LabError;
use crate::text::parse_duration;
use std::path::Path;

/// It has three methods, and understands some options.
pub(super) struct TestProgram;

impl RenderInterface for TestProgram {
    fn methods(&self) -> Vec<MethodSummary> {
        let method = |name, summary| MethodSummary { name, summary };
        vec![
            method("rich-vpl", "Rich virtual point lights"),
            method("vpl", "Virtual point lights"),
            method("path", "Path tracing"),
        ]
    }

    fn interpret(&self, words: &[&str]) -> Result<RenderSettings, String> {
        let value = |option: &str| {
            let place = words.iter().position(|word| *word == option)?;
            words.get(place + 1).copied()
        };
        if words.contains(&"--pases") {
            return Err("unexpected argument `--pases`".into());
        }
        let has_lights = value("-m") != Some("path");
        if !has_lights && value("-n").is_some() {
            return Err("--lights has no meaning".into());
        }
        let setting = |name, option, default: &str| (name, value(option).unwrap_or(default).into());
        let lights = [
            setting("lights", "-n", "512"),
            setting("photons", "--photons", "262144"),
            ("clamp", "auto".to_string()),
        ];
        Ok(RenderSettings {
            method: has_lights.then_some(lights).into_iter().flatten().collect(),
            time: value("--time").and_then(|text| parse_duration(text).ok()),
        })
    }
}

/// A plan from its text, in the file `p/plan.json`.
pub(super) fn plan(text: &str, scale: Option<&str>) -> Result<StudyPlan, LabError> {
    Ok(parse_plan(
        Path::new("p/plan.json"),
        text.into(),
        scale,
        &TestProgram,
    )?)
}
