//! What came out, one file per run.

use super::machine::Machine;
use super::runs::Run;
use crate::failure::Failure;
use manylight_io::image::write_file;
use manylight_io::{FileError, FileErrorKind};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Version of the files' shape.
const SCHEMA: &str = "manylight.study/1";

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// As asked.
    Done,
    /// At its limit of time.
    Stopped,
    /// With an error.
    Failed,
}

/// The result of a run. Paths in it are relative to the folders of the study, so that it can be kept with the project.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// [`SCHEMA`].
    pub(crate) schema: String,
    /// How it ended.
    pub(crate) status: Status,
    /// What was said if it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) message: Option<String>,
    /// What `render` ended with if it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) exit_code: Option<i32>,
    /// How to make it again, in the folder of the scenes.
    pub(crate) command: String,
    /// Of scene, reference and options.
    pub(crate) fingerprint: String,
    /// Of the program.
    pub(crate) version: String,
    /// When it ended, in UTC.
    pub(crate) date: String,
    /// On what.
    pub(crate) machine: Machine,
    /// Seconds after which it was to be stopped.
    pub(crate) limit: Option<f64>,
    /// Seconds from the start of the process to its end.
    pub(crate) seconds: f64,
    /// What `compare` says; nothing if there is no picture.
    pub(crate) metrics: Option<Value>,
    /// What `render` says about itself; nothing if it failed or was killed.
    pub(crate) render: Option<Value>,
}

impl Record {
    /// What is known of a run before it is made.
    pub(crate) fn new(run: &Run, command: String, machine: &Machine) -> Self {
        Record {
            schema: SCHEMA.into(),
            status: Status::Failed,
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

    /// Whether it is the result of this very run. Settings that are not in the record are new to the program, and cannot have
    /// been different.
    pub(crate) fn is_of(&self, run: &Run) -> bool {
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

    /// Whether the run need not be made again: it has ended, or was stopped at the limit that still holds. What failed is
    /// tried again, for its cause is mostly elsewhere.
    pub(crate) fn settles(&self, run: &Run) -> bool {
        let limit = run.task.limit.map(|limit| limit.as_secs_f64());
        self.is_of(run)
            && match self.status {
                Status::Done => true,
                Status::Stopped => self.limit == limit,
                Status::Failed => false,
            }
    }

    /// A number that `compare` found.
    pub(super) fn metric(&self, pointer: &str) -> Option<f64> {
        self.metrics.as_ref()?.pointer(pointer)?.as_f64()
    }

    /// A number that `render` told.
    pub(super) fn told(&self, pointer: &str) -> Option<f64> {
        self.render.as_ref()?.pointer(pointer)?.as_f64()
    }

    /// The stages with their seconds, without reading the scene and writing the picture.
    pub(super) fn stages(&self) -> Vec<(&str, f64)> {
        const APART: [&str; 3] = ["load", "build", "write"];
        let stages = self
            .render
            .as_ref()
            .and_then(|render| render.get("stages")?.as_object());
        let stages = stages.into_iter().flatten();
        stages
            .filter(|(name, _)| !APART.contains(&name.as_str()))
            .filter_map(|(name, seconds)| Some((name.as_str(), seconds.as_f64()?)))
            .collect()
    }

    /// Seconds of rendering; `None` without a report.
    pub(super) fn render_seconds(&self) -> Option<f64> {
        self.render.as_ref()?;
        Some(self.stages().iter().map(|stage| stage.1).sum())
    }

    /// The line of its message that says most.
    pub(crate) fn headline(&self) -> &str {
        let message = self.message.as_deref().unwrap_or_default();
        let lines = || message.lines().map(str::trim).filter(|l| !l.is_empty());
        let marked = lines().find_map(|line| line.strip_prefix('×').map(str::trim));
        marked.or_else(|| lines().next()).unwrap_or("no message")
    }
}

/// The results of a plan's runs.
#[derive(Debug, Default)]
pub(crate) struct Results {
    folder: PathBuf,
    records: BTreeMap<String, Record>,
}

impl Results {
    /// Reads the results of `runs` that are in `folder`.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub(crate) fn read(folder: &Path, runs: &[Run]) -> Result<Self, Failure> {
        let mut results = Results {
            folder: folder.to_owned(),
            records: BTreeMap::new(),
        };
        for key in runs.iter().map(Run::key) {
            let path = results.path(&key);
            let text = match std::fs::read_to_string(&path) {
                Ok(text) => text,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => return Err(FileError::unreadable(&path, error).into()),
            };
            results.records.insert(key, parse(&path, &text)?);
        }
        Ok(results)
    }

    /// The result of the run of this name.
    pub(crate) fn get(&self, key: &str) -> Option<&Record> {
        self.records.get(key)
    }

    /// Keeps a result, in its file too, which appears whole.
    ///
    /// # Errors
    /// The file system refuses.
    pub(crate) fn put(&mut self, key: String, record: Record) -> Result<(), Failure> {
        let path = self.path(&key);
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| FileError::unwritable(&self.folder, error))?;
        let mut text = serde_json::to_string_pretty(&record)
            .map_err(|error| Failure::Internal(format!("{}: {error}", path.display())))?;
        text.push('\n');
        write_file(&path, text.as_bytes())?;
        self.records.insert(key, record);
        Ok(())
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.json"))
    }

    #[cfg(test)]
    pub(super) fn of(records: impl IntoIterator<Item = (String, Record)>) -> Self {
        Results {
            folder: PathBuf::new(),
            records: records.into_iter().collect(),
        }
    }
}

fn parse(path: &Path, text: &str) -> Result<Record, Failure> {
    let failure = |line, column, message| {
        Failure::from(FileError {
            path: path.to_owned(),
            line,
            column,
            message,
            kind: FileErrorKind::Malformed,
        })
    };
    let record: Record = serde_json::from_str(text).map_err(|error| {
        let place = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
        let message = format!("no result of a study: {error}; without the file, it is made again");
        failure(place(error.line()), place(error.column()), message)
    })?;
    if record.schema != SCHEMA {
        let message = format!("found the schema {}, expected {SCHEMA}", record.schema);
        return Err(failure(None, None, message));
    }
    Ok(record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Plan;
    use serde_json::json;

    fn plan(options: &str, limit: &str) -> Plan {
        let plan = json!({
            "title": "T",
            "scenes": [{"name": "s", "title": "S", "file": "s.xml", "reference": "s.exr", "size": "8x8", "max_depth": 4}],
            "methods": [{"label": "m", "method": "vpl"}],
            "tasks": [{"name": "t", "title": "T", "options": options, "limit": limit}],
        });
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), plan.to_string()).unwrap();
        Plan::load(file.path(), None).unwrap()
    }

    #[test]
    fn a_result_settles_the_run_that_it_is_of() {
        let plan_now = plan("-n 20", "10s");
        let run = &plan_now.runs().unwrap()[0];
        let mut record = Record::new(run, String::new(), &Machine::this());
        assert!(!record.settles(run), "what failed is tried again");
        record.status = Status::Done;
        record.render = Some(json!({"settings": {"lights": 20, "clamp": "auto"}}));
        assert!(record.settles(run));
        let other = plan("-n 21", "10s");
        assert!(!record.settles(&other.runs().unwrap()[0]));
        // The same words, but the program's defaults have changed since.
        let mut older = record.clone();
        older.render = Some(json!({"settings": {"lights": 20, "clamp": "none"}}));
        assert!(!older.settles(run));
        let longer = plan("-n 20", "20s");
        let longer_run = &longer.runs().unwrap()[0];
        assert!(record.settles(longer_run));
        record.status = Status::Stopped;
        assert!(record.settles(run) && !record.settles(longer_run));
    }

    #[test]
    fn the_headline_of_a_message() {
        let plan = plan("", "1s");
        let mut record = Record::new(&plan.runs().unwrap()[0], String::new(), &Machine::this());
        assert_eq!(record.headline(), "no message");
        record.message =
            Some("manylight::scene\n\n  × unknown plugin `x`\n   ╭─[s.xml:3:5]".into());
        assert_eq!(record.headline(), "unknown plugin `x`");
        record.message = Some("\n  killed\nmore".into());
        assert_eq!(record.headline(), "killed");
    }

    #[test]
    fn a_file_that_is_no_result_is_refused_with_its_place() {
        let message = parse(Path::new("r/a.json"), "{\n  \"schema\": 3\n}")
            .unwrap_err()
            .to_string();
        assert!(message.contains("r/a.json:2:13"), "{message}");
    }
}
