//! The data of a plan: scenes, methods, tasks and ratios.

use super::method::StudyMethod;
use super::plan_text::PlanText;
use super::quantity::Quantity;
use crate::text::parse_duration;
use serde::de::{Error, IgnoredAny};
use serde::{Deserialize, Deserializer};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A plan of measurements. It is read by [`load_plan`](super::load_plan).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyPlan {
    /// Title of the page.
    pub title: String,
    /// Text below the title.
    #[serde(default)]
    pub notes: String,
    /// File name of the page, relative to the plan.
    #[serde(default = "default_page")]
    page: PathBuf,
    /// Options of every render.
    #[serde(default)]
    pub options: String,
    /// Scenes: the columns of the tables.
    pub scenes: Vec<StudyScene>,
    /// Methods: the rows of the tables.
    pub methods: Vec<StudyMethod>,
    /// Tasks: the sections of the page.
    pub tasks: Vec<StudyTask>,
    /// Ratios between methods.
    #[serde(default)]
    pub ratios: Vec<Ratio>,
    /// Scales; they are filled in before the rest of the plan is read.
    #[serde(default, rename = "scales")]
    _scales: IgnoredAny,
    /// Name of the scale in use.
    #[serde(skip)]
    pub(super) scale: Option<String>,
    /// Path of the plan file.
    #[serde(skip)]
    pub(super) path: PathBuf,
    /// Text of the plan, for messages.
    #[serde(skip)]
    pub(super) text: PlanText,
}

/// A scene with its reference image.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyScene {
    /// Name in names of result files.
    pub name: String,
    /// Column heading.
    pub title: String,
    /// Scene file, relative to the folder of scenes, or to the plan if it begins with `./`.
    pub file: String,
    /// Reference image, relative to the folder of references, or to the plan if it begins with
    /// `./`.
    pub reference: String,
    /// Image size, as `--size` takes it.
    pub size: String,
    /// Longest path, as `--max-depth` takes it.
    pub max_depth: i64,
    /// Further options.
    #[serde(default)]
    pub options: String,
}

/// A task that all methods perform on all scenes, or those that it lists.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyTask {
    /// Name in names of result files.
    pub name: String,
    /// Section heading.
    pub title: String,
    /// Options of its renders.
    #[serde(default)]
    pub options: String,
    /// One option with several values, for the convergence of errors.
    #[serde(default)]
    pub budgets: Option<Budgets>,
    /// Labels of the methods; `None` for all.
    #[serde(default)]
    pub methods: Option<Vec<String>>,
    /// Names of the scenes; `None` for all.
    #[serde(default)]
    pub scenes: Option<Vec<String>>,
    /// Time limit of a run, from the start to the end of its process.
    #[serde(default, deserialize_with = "duration")]
    pub limit: Option<Duration>,
    /// Tables of the section; `None` for the default ones.
    #[serde(default)]
    pub figures: Option<Vec<Quantity>>,
    /// Text of the section.
    #[serde(default)]
    pub notes: String,
}

/// An option with several values, in increasing order of effort.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budgets {
    /// The option, such as `--time`.
    pub option: String,
    /// Its values, such as `8s` and `16s`.
    pub values: Vec<String>,
}

/// The ratio of the results of two methods.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ratio {
    /// Label of the method in the numerator.
    pub of: String,
    /// Label of the method in the denominator.
    pub over: String,
    /// Task, with its budget if it has several: `convergence-8s`.
    pub task: String,
    /// Quantity of the ratio, in addition to the time; `None` for the errors.
    #[serde(default)]
    figure: Option<Quantity>,
}

fn default_page() -> PathBuf {
    "methods.md".into()
}

fn duration<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Duration>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let time = parse_duration(&text);
    time.map(Some)
        .map_err(|expected| D::Error::custom(format!("found `{text}`, {expected}")))
}

impl StudyPlan {
    /// Path of the plan file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name of the scale in use; `None` for a plan without scales.
    pub fn scale(&self) -> Option<&str> {
        self.scale.as_deref()
    }

    /// Default folder of the results: `results` beside the plan, and in it one folder per scale.
    pub fn results_folder(&self) -> PathBuf {
        self.folder()
            .join("results")
            .join(self.scale().unwrap_or_default())
    }

    /// Folder of the plan.
    pub fn folder(&self) -> &Path {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if folder.as_os_str().is_empty() {
            return Path::new(".");
        }
        folder
    }

    /// Path of the page.
    pub fn page_path(&self) -> PathBuf {
        self.folder().join(&self.page)
    }

    /// The scenes of a task.
    pub fn scenes_of<'p>(&'p self, task: &'p StudyTask) -> impl Iterator<Item = &'p StudyScene> {
        let wanted = |scene: &&StudyScene| is_listed(task.scenes.as_deref(), &scene.name);
        self.scenes.iter().filter(wanted)
    }

    /// The methods of a task.
    pub fn methods_of<'p>(&'p self, task: &'p StudyTask) -> impl Iterator<Item = &'p StudyMethod> {
        let wanted = |method: &&StudyMethod| is_listed(task.methods.as_deref(), &method.label);
        self.methods.iter().filter(wanted)
    }
}

/// Whether `name` is in the list; no list contains all names.
fn is_listed(list: Option<&[String]>, name: &str) -> bool {
    list.is_none_or(|names| names.iter().any(|n| n == name))
}

impl Ratio {
    /// The quantities of the ratio.
    pub(super) fn quantities(&self) -> Vec<Quantity> {
        match self.figure {
            Some(Quantity::Seconds) => vec![Quantity::Seconds],
            Some(quantity) => vec![quantity, Quantity::Seconds],
            None => vec![Quantity::Rmse, Quantity::RootRelmse, Quantity::Seconds],
        }
    }
}

impl StudyTask {
    /// The values of the budget option; a single `None` for a task without budgets.
    pub fn budget_values(&self) -> Vec<Option<&str>> {
        match &self.budgets {
            Some(budgets) => budgets.values.iter().map(|v| Some(v.as_str())).collect(),
            None => vec![None],
        }
    }

    /// Name of the task with a budget: `convergence-8s`.
    pub fn name_with(&self, budget: Option<&str>) -> String {
        match budget {
            Some(value) => format!("{}-{value}", self.name),
            None => self.name.clone(),
        }
    }

    /// Names of the task with each of its budgets.
    pub(super) fn names(&self) -> Vec<String> {
        let budgets = self.budget_values().into_iter();
        budgets.map(|budget| self.name_with(budget)).collect()
    }
}
