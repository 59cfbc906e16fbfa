//! Making one run: render in a child process, compare with the reference, record the result.

use super::child::{Ending, FinishedProcess, spawn_and_wait};
use super::folders::{StudyFolders, absolute};
use super::record::{Machine, Record, RunStatus, UNAVAILABLE};
use super::runs::Run;
use crate::compare::{ComparisonImage, compare_file, read_image};
use crate::error::LabError;
use crate::text::{date, quoted};
use manylight_io::FileError;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;
use tempfile::TempDir;

/// Longest stored error message in bytes, about a page of text. Longer ones are cut.
const MAX_MESSAGE_BYTES: usize = 4000;

/// Makes the runs of a study.
#[derive(Debug)]
pub struct Runner<'a> {
    /// Path of the program `manylight`.
    pub program: PathBuf,
    /// Folders of the scenes.
    pub scenes: StudyFolders,
    /// Folders of the references.
    pub references: StudyFolders,
    /// Existing folder in which the images are kept; `None` to delete them after the comparison.
    pub images: Option<&'a Path>,
    /// The computer, for the records.
    pub machine: Machine,
    /// Becomes true when the study is interrupted.
    pub interrupted: &'a AtomicBool,
}

impl Runner<'_> {
    /// Makes a run. A render or a comparison that fails is recorded as a failed run. `None` if the
    /// study was interrupted.
    ///
    /// # Errors
    /// Temporary files or kept images cannot be written.
    pub fn make(&self, run: &Run) -> Result<Option<Record>, LabError> {
        let folder = match self.images {
            Some(images) => TempDir::new_in(absolute(images)),
            None => TempDir::new(),
        };
        let folder = folder.map_err(|e| FileError::unwritable(&std::env::temp_dir(), e))?;
        let image = folder.path().join(format!("{}.exr", run.key()));
        let mut record = Record::new(run, displayed_command(run), &self.machine);
        let reference_path = self.references.path(&run.reference());
        if run.method.reference.is_some() && !reference_path.exists() {
            return Ok(Some(without_reference(record, run)));
        }
        // Read before the render, which may take long, so that a missing reference is found early.
        let outcome = match read_image(&reference_path, None) {
            Err(error) => Err(error.to_string()),
            Ok(reference) => match self.render(run, &image, folder.path(), &mut record) {
                None => return Ok(None),
                Some(outcome) => {
                    outcome.and_then(|()| metrics(&image, &reference_path, &reference))
                }
            },
        };
        match outcome {
            Ok(metrics) => record.metrics = metrics,
            Err(message) => {
                record.status = RunStatus::Failed;
                record.message = Some(self.without_folders(&message, folder.path()));
            }
        }
        record.date = date(SystemTime::now());
        if let Some(images) = self.images {
            keep_images(folder.path(), images)?;
        }
        Ok(Some(record))
    }

    /// Renders `image` and stores the report in `record`, or returns an error message. `None` if
    /// the study was interrupted.
    fn render(
        &self,
        run: &Run,
        image: &Path,
        folder: &Path,
        record: &mut Record,
    ) -> Option<Result<(), String>> {
        let mut command = self.command(run, image);
        let finished = spawn_and_wait(&mut command, run.task.limit, self.interrupted, folder);
        // A terminal sends the interrupt signal to the child too, which may have ended before.
        let complete = |finished: &FinishedProcess| finished.ending == Ending::Exited(Some(0));
        if self.interrupted.load(Ordering::Relaxed) && !finished.as_ref().is_ok_and(complete) {
            return None;
        }
        Some(match finished {
            Ok(finished) => store_report(record, &finished),
            Err(error) => {
                let program = command.get_program().to_string_lossy();
                Err(format!("{program} cannot be run: {error}"))
            }
        })
    }

    /// The command that renders `image`.
    fn command(&self, run: &Run, image: &Path) -> Command {
        let file = &run.scene.file;
        let renderer = &run.method.renderer;
        let words = renderer.command(&self.program, self.scenes.plan_folder());
        let (program, first) = words
            .split_first()
            .expect("invariant: a command has a program");
        let mut command = Command::new(program);
        command
            .current_dir(self.scenes.folder_of(file))
            .args(first)
            .arg(file)
            .args(&run.words)
            .args(["--json", "--progress", "none", "--quiet", "--output"])
            .arg(image);
        if self.images.is_some() {
            command.arg("--output").arg(image.with_extension("png"));
        }
        command
    }

    /// `message` without the folders of this computer, and cut to its longest length.
    fn without_folders(&self, message: &str, temporary: &Path) -> String {
        let folders = [&self.scenes, &self.references].into_iter();
        let folders = [temporary]
            .into_iter()
            .chain(folders.flat_map(StudyFolders::all));
        let mut message = message.to_owned();
        for folder in folders {
            message = message.replace(&format!("{}/", folder.display()), "");
        }
        message.truncate(message.floor_char_boundary(MAX_MESSAGE_BYTES));
        message.trim().to_owned()
    }
}

/// The record of a run whose method has references of its own, but none for the scene.
fn without_reference(record: Record, run: &Run) -> Record {
    Record {
        status: RunStatus::Unavailable,
        message: Some(format!("there is no file {}", run.reference())),
        date: date(SystemTime::now()),
        ..record
    }
}

/// The comparison of `image` with the reference as a JSON object; `None` if there is no image.
fn metrics(
    image: &Path,
    reference_path: &Path,
    reference: &ComparisonImage,
) -> Result<Option<Value>, String> {
    if !image.exists() {
        return Ok(None);
    }
    let compared = compare_file(image, reference_path, reference, None);
    let (_, comparison) = compared.map_err(|error| error.to_string())?;
    let mut metrics = serde_json::to_value(comparison).ok();
    if let Some(Value::Object(metrics)) = &mut metrics {
        // The path of a temporary file.
        metrics.shift_remove("image");
    }
    Ok(metrics)
}

/// The command that repeats a run in the folder of its scene file.
fn displayed_command(run: &Run) -> String {
    let image = format!("{}.exr", run.key());
    let renderer = &run.method.renderer;
    let start = renderer.command("manylight".as_ref(), "".as_ref());
    let words = start.iter().chain([&run.scene.file]).chain(&run.words);
    let words = words.map(String::as_str).chain(["--output", &image]);
    words.map(quoted).collect::<Vec<_>>().join(" ")
}

/// Stores in `record` how a render has ended and what it has reported.
///
/// # Errors
/// A message, if the render has failed.
pub(super) fn store_report(record: &mut Record, finished: &FinishedProcess) -> Result<(), String> {
    record.seconds = finished.seconds;
    record.render = serde_json::from_str(&finished.stdout).ok();
    if let Some(Value::Object(report)) = &mut record.render {
        report.shift_remove("outputs");
    }
    match finished.ending {
        Ending::Exited(Some(0)) if record.render.is_some() => {
            record.status = RunStatus::Done;
            Ok(())
        }
        Ending::Stopped => {
            record.status = RunStatus::Stopped;
            Ok(())
        }
        Ending::Exited(Some(UNAVAILABLE)) => {
            record.status = RunStatus::Unavailable;
            record.message = Some(finished.stderr.trim().to_owned());
            Ok(())
        }
        Ending::Exited(code) => {
            record.exit_code = code;
            let message = finished.stderr.trim();
            Err(match (message.is_empty(), code) {
                (false, _) => message.to_owned(),
                (true, Some(code)) => format!("ended with exit code {code} without a message"),
                (true, None) => "ended by a signal; perhaps there was not enough memory".into(),
            })
        }
        Ending::Interrupted => Err("interrupted".into()),
    }
}

/// Moves the images of a run from its temporary folder to the folder of kept images.
fn keep_images(folder: &Path, images: &Path) -> Result<(), LabError> {
    let entries = std::fs::read_dir(folder).map_err(|e| FileError::unreadable(folder, e))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let is_image = path.extension().is_some_and(|e| e == "exr" || e == "png");
        if let Some(name) = path.file_name().filter(|_| is_image) {
            let target = images.join(name);
            std::fs::rename(&path, &target).map_err(|e| FileError::unwritable(&target, e))?;
        }
    }
    Ok(())
}
