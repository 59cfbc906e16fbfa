//! The result of one run, and the computer that made it.

use super::runs::Run;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Version of the shape of result files.
pub(super) const SCHEMA: &str = "manylight.study/1";

/// Stages of a render that do not count as rendering.
const EXCLUDED_STAGES: [&str; 3] = ["load", "build", "write"];

/// Exit code by which a program states that it cannot make a run on this computer. Its standard
/// error names the reason.
pub(super) const UNAVAILABLE: i32 = 5;

/// Properties of a computer that determine the speed of a render.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Machine {
    /// Model name of the processor, or its architecture if the name is not known.
    pub cpu: String,
    /// Number of hardware threads.
    pub threads: usize,
}

impl Machine {
    /// The computer that runs this program.
    pub fn this() -> Self {
        let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = information
            .lines()
            .find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Machine {
            cpu: name
                .map_or(std::env::consts::ARCH, |(_, name)| name.trim())
                .into(),
            threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        }
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunStatus {
    /// It ended by itself, without an error.
    Done,
    /// It was stopped at its time limit.
    Stopped,
    /// It ended with an error.
    Failed,
    /// The program is not installed, or cannot render this scene: it exited with code 5.
    Unavailable,
}

/// The result of a run. Paths in it are relative to the folders of the study, so that results can
/// be shared.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Version of the shape of this object.
    pub schema: String,
    /// How the run ended.
    pub status: RunStatus,
    /// Error message of a failed run, or the reason why a run is unavailable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// Exit code of a failed run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exit_code: Option<i32>,
    /// Command that repeats the run in the folder of the scenes.
    pub command: String,
    /// Hash of scene, reference and options; see [`Run::fingerprint`].
    pub fingerprint: String,
    /// Version of the program.
    pub version: String,
    /// Time of its end in UTC, as RFC 3339.
    pub date: String,
    /// The computer.
    pub machine: Machine,
    /// Time limit in seconds.
    pub limit: Option<f64>,
    /// Time from the start to the end of the process in seconds.
    pub seconds: f64,
    /// JSON object of the comparison with the reference; `None` without an image.
    pub metrics: Option<Value>,
    /// JSON object that the render has printed; `None` if it has failed or was killed.
    pub render: Option<Value>,
}

impl Record {
    /// The record of a run that has not been made: its status is [`RunStatus::Failed`].
    pub(super) fn new(run: &Run, command: String, machine: &Machine) -> Self {
        Record {
            schema: SCHEMA.into(),
            status: RunStatus::Failed,
            message: None,
            exit_code: None,
            command,
            fingerprint: run.fingerprint(),
            version: env!("CARGO_PKG_VERSION").into(),
            date: String::new(),
            machine: machine.clone(),
            limit: run.task.limit.map(|limit| limit.as_secs_f64()),
            seconds: 0.0,
            metrics: None,
            render: None,
        }
    }

    /// Whether this is the result of `run` with its present options. A setting that the record
    /// lacks was added to the program later, and is ignored.
    pub fn is_of(&self, run: &Run) -> bool {
        let recorded = |name: &str| {
            let settings = self.render.as_ref()?.get("settings")?;
            match settings.get(name.replace('-', "_"))? {
                Value::String(text) => Some(text.clone()),
                other => Some(other.to_string()),
            }
        };
        let same =
            |(name, value): &(&str, String)| recorded(name).is_none_or(|found| found == *value);
        self.fingerprint == run.fingerprint() && run.settings().iter().all(same)
    }

    /// Whether `run` need not be repeated: it is done, or was stopped at its present time limit.
    /// Failed and unavailable runs are repeated, because most of their causes are external.
    pub fn settles(&self, run: &Run) -> bool {
        let limit = run.task.limit.map(|limit| limit.as_secs_f64());
        self.is_of(run)
            && match self.status {
                RunStatus::Done => true,
                RunStatus::Stopped => self.limit == limit,
                RunStatus::Failed | RunStatus::Unavailable => false,
            }
    }

    /// The relMSE of the image, if there is one.
    pub fn relmse(&self) -> Option<f64> {
        self.metric("/relmse")
    }

    /// A number of the comparison, by its JSON pointer.
    pub(super) fn metric(&self, pointer: &str) -> Option<f64> {
        self.metrics.as_ref()?.pointer(pointer)?.as_f64()
    }

    /// A number of the report of the render, by its JSON pointer.
    pub(super) fn report_number(&self, pointer: &str) -> Option<f64> {
        self.render.as_ref()?.pointer(pointer)?.as_f64()
    }

    /// The stages of rendering with their times in seconds, without loading the scene and writing
    /// the image.
    pub(super) fn stages(&self) -> Vec<(&str, f64)> {
        let stages = self
            .render
            .as_ref()
            .and_then(|render| render.get("stages")?.as_object());
        let stages = stages.into_iter().flatten();
        stages
            .filter(|(name, _)| !EXCLUDED_STAGES.contains(&name.as_str()))
            .filter_map(|(name, seconds)| Some((name.as_str(), seconds.as_f64()?)))
            .collect()
    }

    /// Rendering time in seconds; `None` without a report.
    pub(super) fn render_seconds(&self) -> Option<f64> {
        self.render.as_ref()?;
        Some(self.stages().iter().map(|stage| stage.1).sum())
    }

    /// The main line of the error message: the one marked with `×`, or else the first.
    pub fn headline(&self) -> &str {
        let message = self.message.as_deref().unwrap_or_default();
        let lines = || message.lines().map(str::trim).filter(|l| !l.is_empty());
        let marked = lines().find_map(|line| line.strip_prefix('×').map(str::trim));
        marked.or_else(|| lines().next()).unwrap_or("no message")
    }
}
