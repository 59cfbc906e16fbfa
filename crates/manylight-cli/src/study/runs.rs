//! One run: a scene by a method under a task, as words for `render`.

use super::method::{Method, Renderer};
use super::names::expected;
use super::plan::{Scene, Task};
use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::preset;
use crate::request::RenderRequest;
use clap::Parser;
use std::time::Duration;

/// A run of the plan.
#[derive(Debug)]
pub(crate) struct Run<'p> {
    /// Of what.
    pub(crate) scene: &'p Scene,
    /// By what.
    pub(crate) method: &'p Method,
    /// What for.
    pub(crate) task: &'p Task,
    /// The task's name with the budget.
    pub(crate) task_name: String,
    /// Options of `render` that decide the picture.
    pub(crate) words: Vec<String>,
    /// What they mean; to another program as far as they say nothing of a method.
    request: RenderRequest,
}

impl<'p> Run<'p> {
    /// Spells out a run; or what `render` would say against it.
    pub(super) fn new(
        options: &str,
        scene: &'p Scene,
        method: &'p Method,
        task: &'p Task,
        budget: Option<&str>,
    ) -> Result<Self, String> {
        let budget_option = task.budgets.as_ref().map(|budgets| budgets.option.as_str());
        let depth = scene.max_depth.to_string();
        let words: Vec<String> = method
            .renderer
            .first_options()
            .into_iter()
            .chain(method.options.split_whitespace())
            .chain(task.options.split_whitespace())
            .chain(budget_option.into_iter().flat_map(str::split_whitespace))
            .chain(budget)
            .chain(options.split_whitespace())
            .chain(scene.options.split_whitespace())
            .chain(["--size", &scene.size, "--max-depth", &depth])
            .map(str::to_owned)
            .collect();
        Ok(Run {
            scene,
            method,
            task,
            task_name: task.name_with(budget),
            request: request(scene, &words)?,
            words,
        })
    }

    /// Name of its files.
    pub(crate) fn key(&self) -> String {
        key(&self.scene.name, &self.method.label, &self.task_name)
    }

    /// For people.
    pub(crate) fn title(&self) -> String {
        format!(
            "{}, {}, {}",
            self.scene.name, self.method.label, self.task_name
        )
    }

    /// How long it is to render, where that is given.
    pub(crate) fn time(&self) -> Option<Duration> {
        self.request.budget.time
    }

    /// The settings of its method as (option, value), defaults included; none of another program.
    pub(crate) fn settings(&self) -> Vec<(&'static str, String)> {
        match &self.method.renderer {
            Renderer::Own(_) => preset::settings(&self.request.kind),
            Renderer::Other(_) => Vec::new(),
        }
    }

    /// The same where only the method says what is asked; its options have been checked with those of a task.
    pub(super) fn settings_of(method: &Method) -> Vec<(&'static str, String)> {
        let Renderer::Own(preset) = &method.renderer else {
            return Vec::new();
        };
        let options = method.options.split_whitespace();
        let words = ["manylight", "render", "scene.xml", "-m", preset.name];
        let parsed = Cli::try_parse_from(words.into_iter().chain(options));
        let request = parsed.ok().and_then(|cli| match cli.command {
            Command::Render(args) => RenderRequest::new(&args).ok(),
            _ => None,
        });
        request.map_or_else(Vec::new, |request| preset::settings(&request.kind))
    }

    /// A number that changes with whatever is asked of the run: scene, reference, options.
    pub(crate) fn fingerprint(&self) -> String {
        let asked = [&self.scene.file, &self.scene.reference];
        let program = self.method.renderer.program();
        fnv1a(asked.into_iter().chain(program).chain(&self.words))
    }
}

/// Name of the files of a run.
pub(super) fn key(scene: &str, method: &str, task: &str) -> String {
    format!("{scene}.{method}.{task}")
}

fn request(scene: &Scene, words: &[String]) -> Result<RenderRequest, String> {
    let start = ["manylight", "render", &scene.file].map(str::to_owned);
    let parsed = Cli::try_parse_from(start.iter().chain(words));
    let cli = parsed.map_err(|error| {
        let text = error.to_string();
        let first = text.split("\n\n").next().unwrap_or_default().trim();
        first.strip_prefix("error: ").unwrap_or(first).to_owned()
    })?;
    match cli.command {
        Command::Render(args) if !args.outputs.is_empty() || args.display.json => {
            Err("options of a plan name no outputs".into())
        }
        Command::Render(args) => RenderRequest::new(&args).map_err(|failure| failure.to_string()),
        _ => Err("options of `render` are expected".into()),
    }
}

/// The FNV-1a hash of words (Fowler, Noll, Vo), which is the same for ever, as one kept in files must be.
fn fnv1a<'w>(words: impl Iterator<Item = &'w String>) -> String {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for byte in words.flat_map(|word| word.bytes().chain([0])) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}")
}

/// The runs that `--only` leaves: of every kind (scene, method, task) that a text names, those that are named. A text names
/// what is called so, or else what contains it.
///
/// # Errors
/// A text that names nothing.
pub(crate) fn select<'r, 'p>(
    runs: &'r [Run<'p>],
    only: &[String],
) -> Result<Vec<&'r Run<'p>>, Failure> {
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
            return Err(Failure::usage(
                format!("--only {text}: no scene, method or task of the plan is called so"),
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
