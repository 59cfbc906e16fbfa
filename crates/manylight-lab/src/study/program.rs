//! What a study must know of the program that renders.

use std::time::Duration;

/// Knowledge of the options of `manylight render`. The command line program implements it, so that
/// the laboratory does not depend on the definition of the options.
pub trait RenderInterface {
    /// All methods, the default first.
    fn methods(&self) -> Vec<MethodSummary>;

    /// What the words after `manylight render` mean: the scene file, then options.
    ///
    /// # Errors
    /// A message for people if `render` would refuse the words, or if they name outputs.
    fn interpret(&self, words: &[&str]) -> Result<RenderSettings, String>;
}

/// A method of `manylight render`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodSummary {
    /// Name, as `--method` takes it.
    pub name: &'static str,
    /// Description in one line, without a final period.
    pub summary: &'static str,
}

/// The meaning of the options of one render.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RenderSettings {
    /// Settings of the method, defaults included: option name without dashes in front, and value.
    pub method: Vec<(&'static str, String)>,
    /// Time limit of the render; `None` if passes or an error end it.
    pub time: Option<Duration>,
}
