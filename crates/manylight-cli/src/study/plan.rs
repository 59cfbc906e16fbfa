//! The plan: scenes, methods, tasks, and what is to be set in relation.

use super::figures::Figure;
use super::method::Method;
use super::names::check_names;
use super::plan_error::{PlanError, PlanText};
use super::runs::Run;
use super::scale::at_scale;
use crate::failure::Failure;
use crate::values;
use manylight_io::FileError;
use serde::de::{Error, IgnoredAny};
use serde::{Deserialize, Deserializer};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A plan, as its file has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Plan {
    /// Head of the page.
    pub(crate) title: String,
    /// Text under it.
    #[serde(default)]
    pub(crate) notes: String,
    /// The page, relative to the plan.
    #[serde(default = "default_page")]
    page: PathBuf,
    /// Options of every render.
    #[serde(default)]
    pub(crate) options: String,
    /// Columns of the tables.
    pub(crate) scenes: Vec<Scene>,
    /// Rows of the tables.
    pub(crate) methods: Vec<Method>,
    /// What is asked of them.
    pub(crate) tasks: Vec<Task>,
    /// Methods set in relation to others.
    #[serde(default)]
    pub(crate) ratios: Vec<Ratio>,
    /// Sizes at which it can be carried out; see [`at_scale`].
    #[serde(default, rename = "scales")]
    _scales: IgnoredAny,
    /// The one that was chosen.
    #[serde(skip)]
    scale: Option<String>,
    #[serde(skip)]
    path: PathBuf,
    #[serde(skip)]
    pub(super) text: PlanText,
}

/// A scene with its reference.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scene {
    /// In names of files.
    pub(crate) name: String,
    /// Head of its column.
    pub(crate) title: String,
    /// Relative to the folder of scenes, or to the plan if it begins with `./`.
    pub(crate) file: String,
    /// Relative to the folder of references, or to the plan if it begins with `./`.
    pub(crate) reference: String,
    /// As `--size` takes it.
    pub(crate) size: String,
    /// As `--max-depth` takes it.
    pub(crate) max_depth: i64,
    /// Further options.
    #[serde(default)]
    pub(crate) options: String,
}

/// What is asked of the methods.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Task {
    /// In names of files.
    pub(crate) name: String,
    /// Head of its section.
    pub(crate) title: String,
    /// Options of its renders.
    #[serde(default)]
    pub(crate) options: String,
    /// Several runs that differ in one option: how errors fall.
    #[serde(default)]
    pub(crate) budgets: Option<Budgets>,
    /// Labels of the methods; all if absent.
    #[serde(default)]
    pub(crate) methods: Option<Vec<String>>,
    /// Names of the scenes; all if absent.
    #[serde(default)]
    pub(crate) scenes: Option<Vec<String>>,
    /// A run that takes longer is stopped.
    #[serde(default, deserialize_with = "duration")]
    pub(crate) limit: Option<Duration>,
    /// Tables of its section.
    #[serde(default)]
    pub(crate) figures: Option<Vec<Figure>>,
    /// Text of its section.
    #[serde(default)]
    pub(crate) notes: String,
}

/// One option with several values, from little to much.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Budgets {
    /// Such as `--time`.
    pub(crate) option: String,
    /// Such as `8s`, `16s`.
    pub(crate) values: Vec<String>,
}

/// One method over another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ratio {
    /// Label of the numerator.
    pub(crate) of: String,
    /// Label of the denominator.
    pub(crate) over: String,
    /// A task, with its budget where it has several: `convergence-8s`.
    pub(crate) task: String,
    /// What is divided, besides seconds; errors if absent.
    #[serde(default)]
    figure: Option<Figure>,
}

fn default_page() -> PathBuf {
    "methods.md".into()
}

fn duration<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Duration>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let time = values::duration(&text);
    time.map(Some)
        .map_err(|expected| D::Error::custom(format!("found `{text}`, {expected}")))
}

impl Plan {
    /// Reads and checks a plan at one of its scales, the first if none is asked for.
    ///
    /// # Errors
    /// The file cannot be read, is no plan, names what it does not define, or has no such scale.
    pub(crate) fn load(path: &Path, scale: Option<&str>) -> Result<Plan, Failure> {
        let text =
            std::fs::read_to_string(path).map_err(|error| FileError::unreadable(path, error))?;
        Ok(Plan::parse(path, text, scale)?)
    }

    fn parse(path: &Path, text: String, scale: Option<&str>) -> Result<Plan, Box<PlanError>> {
        let (text, scale) = at_scale(PlanText::new(path, text), scale)?;
        let plan: Result<Plan, _> = serde_json::from_str(text.as_str());
        let mut plan = plan.map_err(|error| text.malformed(&error))?;
        plan.path = path.to_owned();
        plan.text = text;
        plan.scale = scale;
        check_names(&plan)?;
        Ok(plan)
    }

    /// Where the plan is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The scale that it is at, if it has any.
    pub(crate) fn scale(&self) -> Option<&str> {
        self.scale.as_deref()
    }

    /// Where results lie if nothing else is said: beside the plan, those of each scale in a folder of their own.
    pub(crate) fn results(&self) -> PathBuf {
        self.folder()
            .join("results")
            .join(self.scale().unwrap_or_default())
    }

    /// The folder of the plan.
    pub(crate) fn folder(&self) -> &Path {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if folder.as_os_str().is_empty() {
            return Path::new(".");
        }
        folder
    }

    /// The page that the plan asks for.
    pub(crate) fn page(&self) -> PathBuf {
        self.folder().join(&self.page)
    }

    /// Every run of the plan: task by task, and scene by scene, so that methods are measured close together.
    ///
    /// # Errors
    /// A run whose options `render` would not take.
    pub(crate) fn runs(&self) -> Result<Vec<Run<'_>>, Failure> {
        let mut runs = Vec::new();
        for task in &self.tasks {
            for scene in self.scenes_of(task) {
                for method in self.methods_of(task) {
                    for budget in task.budget_values() {
                        let run = Run::new(&self.options, scene, method, task, budget);
                        runs.push(run.map_err(|message| self.refused(task, method, &message))?);
                    }
                }
            }
        }
        Ok(runs)
    }

    /// The scenes of a task.
    pub(crate) fn scenes_of<'p>(&'p self, task: &'p Task) -> impl Iterator<Item = &'p Scene> {
        let wanted = |scene: &&Scene| is_listed(task.scenes.as_deref(), &scene.name);
        self.scenes.iter().filter(wanted)
    }

    /// The methods of a task.
    pub(crate) fn methods_of<'p>(&'p self, task: &'p Task) -> impl Iterator<Item = &'p Method> {
        let wanted = |method: &&Method| is_listed(task.methods.as_deref(), &method.label);
        self.methods.iter().filter(wanted)
    }

    fn refused(&self, task: &Task, method: &Method, message: &str) -> Box<PlanError> {
        let message = format!("task {}, method {}: {message}", task.name, method.label);
        let help = "options are those of `manylight render`; a task may list its methods";
        Box::new(self.text.problem(&task.name, message, help))
    }
}

fn is_listed(list: Option<&[String]>, name: &str) -> bool {
    list.is_none_or(|names| names.iter().any(|n| n == name))
}

impl Ratio {
    /// What is divided.
    pub(super) fn figures(&self) -> Vec<Figure> {
        match self.figure {
            Some(Figure::Seconds) => vec![Figure::Seconds],
            Some(figure) => vec![figure, Figure::Seconds],
            None => vec![Figure::Rmse, Figure::RootRelmse, Figure::Seconds],
        }
    }
}

impl Task {
    /// The values of its option, or one run without.
    pub(crate) fn budget_values(&self) -> Vec<Option<&str>> {
        match &self.budgets {
            Some(budgets) => budgets.values.iter().map(|v| Some(v.as_str())).collect(),
            None => vec![None],
        }
    }

    /// Its name with a budget.
    pub(crate) fn name_with(&self, budget: Option<&str>) -> String {
        match budget {
            Some(value) => format!("{}-{value}", self.name),
            None => self.name.clone(),
        }
    }

    pub(super) fn names(&self) -> Vec<String> {
        let budgets = self.budget_values().into_iter();
        budgets.map(|budget| self.name_with(budget)).collect()
    }
}

impl From<Box<PlanError>> for Failure {
    fn from(error: Box<PlanError>) -> Self {
        Failure::Plan(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::select;

    const GOOD: &str = r#"{
        "title": "T",
        "options": "--filter box",
        "scenes": [{"name": "a", "title": "A", "file": "a/s.xml", "reference": "a.exr", "size": "16x9", "max_depth": -1}],
        "methods": [
            {"label": "rich", "method": "rich-vpl", "options": "--photons 1000"},
            {"label": "path", "method": "path"}
        ],
        "tasks": [
            {"name": "work", "title": "W", "options": "-n 20 --passes 1", "methods": ["rich"], "limit": "2m"},
            {"name": "time", "title": "T", "budgets": {"option": "--time", "values": ["8s", "16s"]}}
        ],
        "ratios": [{"of": "rich", "over": "path", "task": "time-16s"}]
    }"#;

    fn parse(text: &str) -> Result<Plan, Failure> {
        let plan = Plan::parse(Path::new("p/plan.json"), text.into(), None)?;
        plan.runs()?;
        Ok(plan)
    }

    #[test]
    fn runs_are_spelled_out() {
        let plan = parse(GOOD).unwrap();
        let runs = plan.runs().unwrap();
        let keys: Vec<String> = runs.iter().map(Run::key).collect();
        assert_eq!(
            keys,
            [
                "a.rich.work",
                "a.rich.time-8s",
                "a.rich.time-16s",
                "a.path.time-8s",
                "a.path.time-16s"
            ]
        );
        assert_eq!(
            runs[0].words.join(" "),
            "-m rich-vpl --photons 1000 -n 20 --passes 1 --filter box --size 16x9 --max-depth -1"
        );
        assert_eq!(runs[2].time(), Some(Duration::from_secs(16)));
        assert_eq!(runs[0].task.limit, Some(Duration::from_secs(120)));
        assert_eq!(plan.page(), Path::new("p/methods.md"));
    }

    #[test]
    fn runs_are_selected_by_name() {
        let plan = parse(GOOD).unwrap();
        let runs = plan.runs().unwrap();
        let keys = |only: &[&str]| -> Vec<String> {
            let only: Vec<String> = only.iter().map(|text| text.to_string()).collect();
            let selected = select(&runs, &only).unwrap();
            selected.iter().map(|run| run.key()).collect()
        };
        assert_eq!(keys(&[]).len(), 5);
        assert_eq!(keys(&["rich"]).len(), 3);
        assert_eq!(keys(&["a"]).len(), 5, "the scene, not all names with an a");
        assert_eq!(keys(&["time"]).len(), 4);
        assert_eq!(keys(&["path", "8s"]), ["a.path.time-8s"]);
        assert_eq!(
            keys(&["work", "time-8s", "rich"]),
            ["a.rich.work", "a.rich.time-8s"]
        );
        assert_eq!(keys(&["path", "work"]), [""; 0]);
        assert!(select(&runs, &["wrk".into()]).is_err());
    }

    #[test]
    fn another_program_may_be_a_method() {
        let text = GOOD.replace(
            r#""label": "path", "method": "path""#,
            r#""label": "path", "program": ["python3", "./other.py"]"#,
        );
        let plan = parse(&text).unwrap();
        let runs = plan.runs().unwrap();
        let other = runs.iter().find(|run| run.method.label == "path").unwrap();
        assert_eq!(
            other.words.join(" "),
            "--time 8s --filter box --size 16x9 --max-depth -1"
        );
        assert!(other.settings().is_empty());
        let call = |run: &Run| {
            let renderer = &run.method.renderer;
            renderer.call(Path::new("b/manylight"), Path::new("p"))
        };
        assert_eq!(call(other), ["python3", "p/other.py"]);
        assert_eq!(call(&runs[0]), ["b/manylight", "render"]);
        let elsewhere_text = text.replace("other.py", "another.py");
        let elsewhere = parse(&elsewhere_text).unwrap();
        let runs_elsewhere = elsewhere.runs().unwrap();
        let changed = |k: usize| runs[k].fingerprint() != runs_elsewhere[k].fingerprint();
        assert_eq!([0, 4].map(changed), [false, true]);
    }

    #[test]
    fn a_plan_has_scales() {
        let scaled = GOOD.replace("16x9", "{size}").replace(
            "\"ratios\"",
            "\"scales\": [{\"name\": \"quick\", \"values\": {\"size\": \"32x18\"}}, {\"name\": \"full\", \"values\": {\"size\": \"64x36\"}}],\n\"page\": \"{scale}.md\", \"ratios\"",
        );
        let at = |scale| Plan::parse(Path::new("p/plan.json"), scaled.clone(), scale);
        for (asked, name, size) in [
            (None, "quick", "32x18"),
            (Some("quick"), "quick", "32x18"),
            (Some("full"), "full", "64x36"),
        ] {
            let plan = at(asked).unwrap();
            assert_eq!(plan.scale(), Some(name));
            assert_eq!(plan.scenes[0].size, size);
            assert_eq!(plan.page(), Path::new("p").join(format!("{name}.md")));
            assert_eq!(plan.results(), Path::new("p/results").join(name));
        }
        let said = |scale, text: &str| {
            let path = Path::new("p/plan.json");
            let error = Plan::parse(path, text.into(), scale).unwrap_err();
            crate::failure::Rendered(&Failure::from(error)).to_string()
        };
        assert!(said(Some("ful"), &scaled).contains("expected one of full, quick"));
        assert!(said(Some("full"), GOOD).contains("the plan has no scales"));
        let outside = scaled.replace("\"full\"", "\"../full\"");
        assert!(said(Some("../full"), &outside).contains("cannot be part of a file's name"));
        let quoted = scaled.replace("64x36", "64\\\"x36");
        assert!(said(Some("full"), &quoted).contains("no quotation marks"));
        assert_eq!(parse(GOOD).unwrap().results(), Path::new("p/results/"));
    }

    #[test]
    fn what_is_wrong_is_shown_at_its_place() {
        for (from, to, place, words) in [
            (
                "\"title\": \"T\",\n        \"opt",
                "\"titel\": \"T\",\n        \"opt",
                ":2:",
                "unknown field `titel`, expected one of `title`",
            ),
            (
                "\"limit\": \"2m\"",
                "\"limit\": \"soon\"",
                ":10:",
                "found `soon`, expected a length of time",
            ),
            (
                "\"method\": \"path\"",
                "\"method\": \"pth\"",
                ":7:",
                "unknown method `pth`; expected one of path",
            ),
            (
                "\"methods\": [\"rich\"]",
                "\"methods\": [\"rch\"]",
                ":10:",
                "the plan has no method `rch`",
            ),
            (
                "\"methods\": [\"rich\"], ",
                "",
                ":10:",
                "task work, method path: --lights has no meaning",
            ),
            (
                "\"method\": \"path\"",
                "\"method\": \"path\", \"program\": [\"python3\"]",
                ":8:",
                "not clear what renders `path`",
            ),
            (
                ", \"method\": \"path\"",
                "",
                ":8:",
                "not clear what renders `path`",
            ),
            (
                "--passes 1",
                "--pases 1",
                ":10:",
                "unexpected argument '--pases'",
            ),
            ("--passes 1", "-o x.exr", ":10:", "name no outputs"),
            (
                "time-16s",
                "time-32s",
                ":13:",
                "the plan has no task `time-32s`",
            ),
            (
                "\"label\": \"path\"",
                "\"label\": \"rich\"",
                ":13:",
                "`rich` is there twice",
            ),
            (
                "\"label\": \"path\"",
                "\"label\": \"a.b\"",
                ":7:",
                "`a.b` cannot be part of a file's name",
            ),
            ("[\"8s\", \"16s\"]", "[]", ":11:", "have no values"),
            (
                "\"task\": \"time-16s\"",
                "\"task\": \"time-16s\", \"figure\": \"stages\"",
                ":13:",
                "is not one number",
            ),
            (
                "\"task\": \"time-16s\"}]",
                "\"task\": \"time-16s\"",
                ":14:",
                "EOF while parsing a list",
            ),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let failure = parse(&GOOD.replacen(from, to, 1)).unwrap_err();
            assert_eq!(failure.exit_code(), crate::failure::USAGE);
            let text = crate::failure::Rendered(&failure).to_string();
            assert!(text.contains(words), "{words}:\n{text}");
            assert!(
                text.contains(&format!("p/plan.json{place}")),
                "{place}:\n{text}"
            );
        }
    }

    #[test]
    fn the_plans_of_the_project_are_sound() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        for (file, scale) in [
            ("study/plan.json", None),
            ("paper/plan.json", Some("quick")),
            ("paper/plan.json", Some("full")),
        ] {
            let plan = Plan::load(&docs.join(file), scale).unwrap();
            let runs = plan.runs().unwrap();
            assert!(runs.iter().all(|run| run.words.contains(&"box".into())));
            let unfilled = |run: &Run| run.words.iter().any(|word| word.contains('{'));
            assert!(!runs.iter().any(unfilled), "{file} at {scale:?}");
        }
    }
}
