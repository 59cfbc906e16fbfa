//! The options of a render, for interfaces that name them as keywords.

use crate::args::{GltfArgs, RenderArgs};
use crate::failure::Failure;
use crate::request::RenderRequest;
use crate::usage::render_args;
use clap::{Arg, Args, Command};
use manylight::integrators::{KeptLights, MethodKind};
use serde::Serialize;
use serde_json::Value;

/// An option of `manylight render`.
#[derive(Clone, Debug, Serialize)]
pub struct RenderOption {
    /// Its name, without dashes before it.
    pub name: String,
    /// What it means.
    pub help: String,
    /// Its value where it is not given, if that does not depend on the scene or on other options.
    pub default: Option<Value>,
    /// Whether it belongs to loading the scene.
    pub loads_scene: bool,
}

/// The options of `manylight render`, in the order of its help.
pub fn render_options() -> Vec<RenderOption> {
    let loading = GltfArgs::augment_args(Command::new("load"));
    let loading = loading.get_arguments().map(Arg::get_id);
    let loading: Vec<_> = loading.collect();
    let command = RenderArgs::augment_args(Command::new("render"));
    let default = |argument: &Arg| {
        let text = argument.get_default_values().first()?.to_str()?;
        Some(serde_json::from_str(text).unwrap_or_else(|_| text.into()))
    };
    let described = |argument: &Arg| {
        Some(RenderOption {
            name: argument.get_long()?.to_owned(),
            help: argument
                .get_help()
                .map(ToString::to_string)
                .unwrap_or_default(),
            default: default(argument),
            loads_scene: loading.contains(&argument.get_id()) || argument.get_id() == "strict",
        })
    };
    command.get_arguments().filter_map(described).collect()
}

/// The number of passes of a render with these words of options; `None` if another limit ends it.
///
/// # Errors
/// An option is wrong.
pub fn pass_limit(words: &[String]) -> Result<Option<u32>, Failure> {
    Ok(args_of(words)?.budget.budget().passes)
}

/// Whether a render with these words of options has virtual lights that can be kept in a file.
///
/// # Errors
/// An option is wrong.
pub fn keeps_lights(words: &[String]) -> Result<bool, Failure> {
    let args = args_of(words)?;
    let request = RenderRequest::new(&args)?;
    Ok(match &request.kind {
        MethodKind::ManyLight(lights) => KeptLights::check(lights).is_ok(),
        _ => false,
    })
}

/// Options of a render of any scene.
fn args_of(words: &[String]) -> Result<Box<RenderArgs>, Failure> {
    render_args(
        ["scene"]
            .into_iter()
            .chain(words.iter().map(String::as_str)),
    )
}
