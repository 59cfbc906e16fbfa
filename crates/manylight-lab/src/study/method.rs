//! A method of a study: a method of `manylight render`, or another program.

use super::plan_text::expected;
use super::program::RenderInterface;
use serde::Deserialize;
use std::path::Path;

/// A method of a study: a row of the tables.
#[derive(Debug, Deserialize)]
#[serde(try_from = "MethodEntry")]
pub struct StudyMethod {
    /// Name in tables and in names of result files.
    pub label: String,
    /// The program that renders.
    pub renderer: StudyRenderer,
    /// Further options.
    pub options: String,
    /// Text for the page.
    pub notes: String,
    /// File name of references of this method alone, in which `*` stands for the name of the scene;
    /// `None` for the references of the scenes.
    pub reference: Option<String>,
    /// Description in one line, from [`StudyMethod::resolve`].
    pub(super) summary: String,
    /// Settings of the method with its own options alone, from [`StudyMethod::resolve`].
    pub(super) settings: Vec<(&'static str, String)>,
}

/// The program that renders the images of a method.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StudyRenderer {
    /// `manylight render` with the method of this name.
    Manylight(String),
    /// Another program with its first arguments. It accepts the same words after them as `manylight
    /// render`, `--json` included. Words that begin with `./` are files beside the plan.
    Program(Vec<String>),
}

/// A method as a plan file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MethodEntry {
    label: String,
    /// Name, as `--method` takes it.
    method: Option<String>,
    #[serde(default)]
    program: Vec<String>,
    #[serde(default)]
    options: String,
    #[serde(default)]
    notes: String,
    reference: Option<String>,
}

impl TryFrom<MethodEntry> for StudyMethod {
    type Error = String;

    fn try_from(entry: MethodEntry) -> Result<Self, String> {
        let renderer = match (entry.method, entry.program) {
            (Some(method), program) if program.is_empty() => StudyRenderer::Manylight(method),
            (None, program) if !program.is_empty() => StudyRenderer::Program(program),
            _ => {
                return Err(format!(
                    "it is not clear what renders `{}`, expected either a `method` of `manylight render` or another `program`",
                    entry.label
                ));
            }
        };
        Ok(StudyMethod {
            label: entry.label,
            renderer,
            options: entry.options,
            notes: entry.notes,
            reference: entry.reference,
            summary: String::new(),
            settings: Vec::new(),
        })
    }
}

impl StudyMethod {
    /// Looks up the description and the settings of the method.
    ///
    /// # Errors
    /// The name of a method that `program` does not have, and a message.
    pub(super) fn resolve(&mut self, program: &dyn RenderInterface) -> Result<(), [String; 2]> {
        let StudyRenderer::Manylight(name) = &self.renderer else {
            self.summary = "Another program".into();
            return Ok(());
        };
        let methods = program.methods();
        let Some(method) = methods.iter().find(|method| method.name == name) else {
            let names = methods.iter().map(|method| method.name);
            let message = format!("unknown method `{name}`; {}", expected(name, names));
            return Err([name.clone(), message]);
        };
        self.summary = method.summary.into();
        let start = ["scene.xml", "-m", name];
        let words: Vec<&str> = start
            .into_iter()
            .chain(self.options.split_whitespace())
            .collect();
        // Wrong options are reported for the runs, with the task that they belong to.
        self.settings = program
            .interpret(&words)
            .map_or_else(|_| Vec::new(), |settings| settings.method);
        Ok(())
    }
}

impl StudyRenderer {
    /// The options that select the method of `manylight render`.
    pub(super) fn method_options(&self) -> Vec<&str> {
        match self {
            StudyRenderer::Manylight(name) => vec!["-m", name],
            StudyRenderer::Program(_) => Vec::new(),
        }
    }

    /// The other program with its arguments; empty for `manylight render`.
    pub(super) fn program(&self) -> &[String] {
        match self {
            StudyRenderer::Manylight(_) => &[],
            StudyRenderer::Program(program) => program,
        }
    }

    /// The command up to the scene file, with `manylight` as the path of this program and
    /// `plan_folder` as the folder of the plan.
    pub(super) fn command(&self, manylight: &Path, plan_folder: &Path) -> Vec<String> {
        match self {
            StudyRenderer::Manylight(_) => {
                vec![manylight.display().to_string(), "render".into()]
            }
            StudyRenderer::Program(program) => {
                let in_folder = |word: &String| match word.strip_prefix("./") {
                    Some(file) => plan_folder.join(file).display().to_string(),
                    None => word.clone(),
                };
                program.iter().map(in_folder).collect()
            }
        }
    }
}
