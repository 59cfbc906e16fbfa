//! The runs of a plan: one render per scene, method, task and budget, with its options.

use super::method::{StudyMethod, StudyRenderer};
use super::plan::{StudyPlan, StudyScene, StudyTask};
use super::plan_text::expected;
use super::program::{RenderInterface, RenderSettings};
use crate::error::{LabError, PlanError};
use std::time::Duration;

/// One render of a plan.
#[derive(Debug)]
pub struct Run<'p> {
    /// The scene.
    pub scene: &'p StudyScene,
    /// The method.
    pub method: &'p StudyMethod,
    /// The task.
    pub task: &'p StudyTask,
    /// Name of the task with the budget.
    pub task_name: String,
    /// Options of `render` that determine the image.
    pub words: Vec<String>,
    /// Meaning of the options. For another program, only the time limit is meaningful.
    settings: RenderSettings,
}

/// All runs of a plan: task by task and scene by scene, so that the methods are measured close
/// together in time.
///
/// # Errors
/// A run with options that `render` refuses.
pub fn plan_runs<'p>(
    plan: &'p StudyPlan,
    program: &dyn RenderInterface,
) -> Result<Vec<Run<'p>>, LabError> {
    let mut runs = Vec::new();
    for task in &plan.tasks {
        for scene in plan.scenes_of(task) {
            for method in plan.methods_of(task) {
                for budget in task.budget_values() {
                    let words = words(&plan.options, scene, method, task, budget);
                    let settings = interpret(program, scene, &words)
                        .map_err(|message| refused(plan, task, method, &message))?;
                    runs.push(Run {
                        scene,
                        method,
                        task,
                        task_name: task.name_with(budget),
                        words,
                        settings,
                    });
                }
            }
        }
    }
    Ok(runs)
}

impl Run<'_> {
    /// Name of the files of this run, without extension.
    pub fn key(&self) -> String {
        run_key(&self.scene.name, &self.method.label, &self.task_name)
    }

    /// File name of the reference image.
    pub fn reference(&self) -> String {
        match &self.method.reference {
            Some(pattern) => pattern.replace('*', &self.scene.name),
            None => self.scene.reference.clone(),
        }
    }

    /// Name for people.
    pub fn title(&self) -> String {
        format!(
            "{}, {}, {}",
            self.scene.name, self.method.label, self.task_name
        )
    }

    /// Time that the render is asked to take; `None` if passes or an error end it.
    pub fn time_limit(&self) -> Option<Duration> {
        self.settings.time
    }

    /// The settings of its method as (option, value), defaults included; empty for another program.
    pub fn settings(&self) -> &[(&'static str, String)] {
        match &self.method.renderer {
            StudyRenderer::Manylight(_) => &self.settings.method,
            StudyRenderer::Program(_) => &[],
        }
    }

    /// A hash of everything that determines the result: scene, reference and options.
    pub fn fingerprint(&self) -> String {
        let reference = self.reference();
        let files = [&self.scene.file, &reference];
        let program = self.method.renderer.program();
        fnv1a(files.into_iter().chain(program).chain(&self.words))
    }
}

/// Name of the files of a run, without extension.
pub(super) fn run_key(scene: &str, method: &str, task: &str) -> String {
    format!("{scene}.{method}.{task}")
}

/// The options of a run. Later options override earlier ones: method, task, plan, scene.
fn words(
    plan_options: &str,
    scene: &StudyScene,
    method: &StudyMethod,
    task: &StudyTask,
    budget: Option<&str>,
) -> Vec<String> {
    let budget_option = task.budgets.as_ref().map(|budgets| budgets.option.as_str());
    let depth = scene.max_depth.to_string();
    let method_options = method.renderer.method_options().into_iter();
    method_options
        .chain(method.options.split_whitespace())
        .chain(task.options.split_whitespace())
        .chain(budget_option.into_iter().flat_map(str::split_whitespace))
        .chain(budget)
        .chain(plan_options.split_whitespace())
        .chain(scene.options.split_whitespace())
        .chain(["--size", &scene.size, "--max-depth", &depth])
        .map(str::to_owned)
        .collect()
}

fn interpret(
    program: &dyn RenderInterface,
    scene: &StudyScene,
    words: &[String],
) -> Result<RenderSettings, String> {
    let options = words.iter().map(String::as_str);
    let all: Vec<&str> = std::iter::once(scene.file.as_str())
        .chain(options)
        .collect();
    program.interpret(&all)
}

/// The options of a run are refused with `message`.
fn refused(
    plan: &StudyPlan,
    task: &StudyTask,
    method: &StudyMethod,
    message: &str,
) -> Box<PlanError> {
    let message = format!("task {}, method {}: {message}", task.name, method.label);
    let help = "options are those of `manylight render`; a task may list its methods";
    Box::new(plan.text.problem(&task.name, message, help))
}

/// 64-bit FNV-1a hash of words (Fowler, Noll, Vo) in hexadecimal. It is stored in files; the hash
/// functions of the standard library may change.
fn fnv1a<'w>(words: impl Iterator<Item = &'w String>) -> String {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for byte in words.flat_map(|word| word.bytes().chain([0])) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}")
}

/// The runs that the texts `only` select; all without texts.
///
/// A text selects the scenes, methods and tasks with this name, or, if there are none, those with
/// names that contain it. Several selected names of one kind are alternatives; a run must match in
/// every kind with a selected name.
///
/// # Errors
/// A text that selects nothing.
pub fn select_runs<'r, 'p>(
    runs: &'r [Run<'p>],
    only: &[String],
) -> Result<Vec<&'r Run<'p>>, LabError> {
    let names = |run: &Run| {
        [
            run.scene.name.clone(),
            run.method.label.clone(),
            run.task_name.clone(),
        ]
    };
    let all: Vec<[String; 3]> = runs.iter().map(names).collect();
    let mut wanted: [Vec<&str>; 3] = Default::default();
    for text in only {
        let exact = |name: &str| name == text;
        let within = |name: &str| name.contains(text.as_str());
        let is_exact = all.iter().flatten().any(|name| exact(name));
        let mut found = false;
        for names in &all {
            for (kind, name) in names.iter().enumerate() {
                if exact(name) || !is_exact && within(name) {
                    wanted[kind].push(name);
                    found = true;
                }
            }
        }
        if !found {
            let mut known: Vec<&str> = all.iter().flatten().map(String::as_str).collect();
            known.sort_unstable();
            known.dedup();
            return Err(LabError::usage(
                format!("--only {text}: no scene, method or task of the plan has this name"),
                expected(text, known.into_iter()),
            ));
        }
    }
    let fits = |names: &[String; 3]| {
        let pairs = names.iter().zip(&wanted);
        pairs.fold(true, |fits, (name, wanted)| {
            fits && (wanted.is_empty() || wanted.contains(&name.as_str()))
        })
    };
    let pairs = runs.iter().zip(&all);
    Ok(pairs
        .filter(|(_, names)| fits(names))
        .map(|(run, _)| run)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_standard() {
        // Published test vector of FNV-1a: the 64-bit hash of "a\0".
        assert_eq!(fnv1a([String::from("a")].iter()), "089be207b544f1e4");
        assert_ne!(
            fnv1a(["ab", "c"].map(String::from).iter()),
            fnv1a(["a", "bc"].map(String::from).iter())
        );
    }
}
