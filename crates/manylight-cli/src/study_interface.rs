//! What the laboratory must know of the options of `manylight render`.

use crate::light_options;
use crate::preset::{PRESETS, Preset};
use crate::request::RenderRequest;
use crate::usage::render_args;
use manylight_lab::study::{MethodSummary, RenderInterface, RenderSettings};

/// The options of this program.
pub(crate) struct ThisProgram;

impl RenderInterface for ThisProgram {
    fn methods(&self) -> Vec<MethodSummary> {
        let summary = |preset: &Preset| MethodSummary {
            name: preset.name,
            summary: preset.summary,
        };
        PRESETS.iter().map(summary).collect()
    }

    fn interpret(&self, words: &[&str]) -> Result<RenderSettings, String> {
        let args = render_args(words.iter().copied()).map_err(|failure| failure.to_string())?;
        if !args.outputs.is_empty() || args.display.json {
            return Err("options of a plan name no outputs".into());
        }
        let request = RenderRequest::new(&args).map_err(|failure| failure.to_string())?;
        Ok(RenderSettings {
            method: light_options::settings(&request.kind),
            time: request.budget.time,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight_lab::study::{Run, load_plan, plan_runs};
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn options_have_their_meaning() {
        let words = ["s.xml", "-m", "rich-vpl", "-n", "20", "--time", "16s"];
        let settings = ThisProgram.interpret(&words).unwrap();
        assert_eq!(settings.time, Some(Duration::from_secs(16)));
        assert!(settings.method.contains(&("lights", "20".into())));
        let path = ThisProgram.interpret(&["s.xml", "-m", "path"]).unwrap();
        assert_eq!(path, RenderSettings::default());
    }

    #[test]
    fn refused_options_have_a_message() {
        for (words, message) in [
            (
                vec!["s.xml", "-m", "path", "-n", "20"],
                "--lights has no meaning",
            ),
            (
                vec!["s.xml", "--pases", "1"],
                "unexpected argument '--pases'",
            ),
            (vec!["s.xml", "-o", "x.exr"], "name no outputs"),
            (vec!["s.xml", "--json"], "name no outputs"),
        ] {
            let found = ThisProgram.interpret(&words).unwrap_err();
            assert!(found.contains(message) && !found.contains('\n'), "{found}");
        }
    }

    #[test]
    fn the_plans_of_the_project_are_sound() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measurements");
        for (file, scale) in [
            ("study/plan.json", None),
            ("paper/plan.json", Some("quick")),
            ("paper/plan.json", Some("full")),
        ] {
            let plan = load_plan(&docs.join(file), scale, &ThisProgram).unwrap();
            let runs = plan_runs(&plan, &ThisProgram).unwrap();
            assert!(runs.iter().all(|run| run.words.contains(&"box".into())));
            let unfilled = |run: &Run| run.words.iter().any(|word| word.contains('{'));
            assert!(!runs.iter().any(unfilled), "{file} at {scale:?}");
        }
    }
}
