//! What renders: a method of this program, or another program.

use super::names::expected;
use crate::preset::{self, PRESETS, Preset};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::path::Path;

/// A row of the tables.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Entry")]
pub(crate) struct Method {
    /// In names of files and in tables.
    pub(crate) label: String,
    /// Who makes its pictures.
    pub(crate) renderer: Renderer,
    /// Further options.
    pub(crate) options: String,
    /// Text for the page.
    pub(crate) notes: String,
}

/// Who makes pictures.
#[derive(Clone, Debug)]
pub(crate) enum Renderer {
    /// `manylight render` by this method.
    Own(&'static Preset),
    /// A program, with its first arguments, that takes what `render` takes behind its name, `--json` included. Words that begin with `./` are
    /// files beside the plan.
    Other(Vec<String>),
}

/// A method as a plan has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    label: String,
    /// As `--method` takes it.
    #[serde(default, deserialize_with = "preset")]
    method: Option<&'static Preset>,
    #[serde(default)]
    program: Vec<String>,
    #[serde(default)]
    options: String,
    #[serde(default)]
    notes: String,
}

impl TryFrom<Entry> for Method {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let renderer = match (entry.method, entry.program) {
            (Some(preset), program) if program.is_empty() => Renderer::Own(preset),
            (None, program) if !program.is_empty() => Renderer::Other(program),
            _ => {
                return Err(format!(
                    "it is not clear what renders `{}`, expected either a `method` of `manylight render` or another `program`",
                    entry.label
                ));
            }
        };
        Ok(Method {
            label: entry.label,
            renderer,
            options: entry.options,
            notes: entry.notes,
        })
    }
}

impl Renderer {
    /// The words with which the options of a run begin.
    pub(super) fn first_options(&self) -> Vec<&str> {
        match self {
            Renderer::Own(preset) => vec!["-m", preset.name],
            Renderer::Other(_) => Vec::new(),
        }
    }

    /// Another program's words.
    pub(super) fn program(&self) -> &[String] {
        match self {
            Renderer::Own(_) => &[],
            Renderer::Other(program) => program,
        }
    }

    /// What a page says of it.
    pub(super) fn summary(&self) -> &str {
        match self {
            Renderer::Own(preset) => preset.summary,
            Renderer::Other(_) => "Another program",
        }
    }

    /// How it is called up to the scene's file, with files beside the plan as they are seen from its `folder`.
    pub(crate) fn call(&self, own: &Path, folder: &Path) -> Vec<String> {
        match self {
            Renderer::Own(_) => vec![own.display().to_string(), "render".into()],
            Renderer::Other(program) => {
                let in_folder = |word: &String| match word.strip_prefix("./") {
                    Some(file) => folder.join(file).display().to_string(),
                    None => word.clone(),
                };
                program.iter().map(in_folder).collect()
            }
        }
    }
}

fn preset<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<&'static Preset>, D::Error> {
    let name = String::deserialize(deserializer)?;
    let found = preset::find(&name).ok_or_else(|| {
        let names = PRESETS.iter().map(|preset| preset.name);
        D::Error::custom(format!(
            "unknown method `{name}`; {}",
            expected(&name, names)
        ))
    });
    found.map(Some)
}
