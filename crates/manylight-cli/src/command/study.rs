//! `manylight study`: make the runs of a plan that have no result yet, then write the page.

use crate::args::StudyArgs;
use crate::command::compare;
use crate::command::gallery::groups;
use crate::failure::{Failure, INTERNAL, plural};
use crate::interrupt::Interrupt;
use crate::output::{human_time, print_message};
use crate::repeat::quoted;
use crate::study::{
    Ended, Ending, Files, Machine, Pace, Plan, Record, Results, Run, Status, absolute, page,
    select, spawn_and_wait,
};
use crate::viewer::write_pages;
use manylight_io::FileError;
use manylight_io::image::write_file;
use serde_json::Value;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::SystemTime;
use tempfile::TempDir;

/// Longest message of a failed run that is kept, in bytes.
const LONGEST_MESSAGE: usize = 4000;

/// Makes the runs of a plan, and its page.
pub(crate) fn run(args: &StudyArgs) -> Result<ExitCode, Failure> {
    let plan = Plan::load(&args.plan, args.scale.as_deref())?;
    let runs = plan.runs()?;
    let default_folder = plan.results();
    let folder = args.results.as_deref().unwrap_or(&default_folder);
    let mut results = Results::read(folder, &runs)?;
    let path = absolute(&args.page.clone().unwrap_or_else(|| plan.page()));
    // Said now rather than after hours.
    if !path.parent().is_some_and(Path::is_dir) {
        let error = io::Error::from(io::ErrorKind::NotFound);
        return Err(FileError::unwritable(&path, error).into());
    }
    let mut code = ExitCode::SUCCESS;
    if !args.page_only {
        let selected = select(&runs, &args.only)?;
        code = make(args, &plan, &selected, &mut results)?;
    }
    let document = page(&plan, &runs, &results, &command_of(&plan));
    write_file(&path, document.markdown().as_bytes())?;
    print_message(format_args!("wrote {}", path.display()));
    if let (Some(folder), Some(images)) = (&args.html, &args.images) {
        let references = Files::references(args, &plan, &runs.iter().collect::<Vec<_>>())?;
        let groups = groups(&plan, &runs, &references, images);
        write_pages(folder, &plan.title, groups, &document.blocks)?;
        print_message(format_args!(
            "wrote {}",
            folder.join("index.html").display()
        ));
    }
    Ok(code)
}

/// How the study was called, as far as it is the same everywhere.
fn command_of(plan: &Plan) -> String {
    let here = std::env::current_dir().unwrap_or_default();
    let path = plan.path();
    let inside = path.strip_prefix(&here).unwrap_or(path);
    let shown = match inside.is_absolute() {
        true => Path::new(inside.file_name().unwrap_or(inside.as_os_str())),
        false => inside,
    };
    let scale = plan.scale().map(|name| format!(" --scale {name}"));
    format!(
        "manylight study {}{}",
        quoted(&shown.display().to_string()),
        scale.unwrap_or_default()
    )
}

/// Makes those of the selected runs that are not settled.
fn make(
    args: &StudyArgs,
    plan: &Plan,
    selected: &[&Run],
    results: &mut Results,
) -> Result<ExitCode, Failure> {
    let settled = |run: &&&Run| {
        let record = results.get(&run.key());
        !args.again && record.is_some_and(|record| record.settles(run))
    };
    let mut pace = Pace::default();
    for run in selected {
        let record = results.get(&run.key());
        if let Some(record) = record.filter(|record| record.status != Status::Failed) {
            pace.note(run, record.seconds);
        }
    }
    let pending: Vec<&Run> = (selected.iter())
        .filter(|run| !settled(run))
        .copied()
        .collect();
    print_message(format_args!(
        "{} run{}, {} of them done already",
        selected.len(),
        plural(selected.len()),
        selected.len() - pending.len()
    ));
    if pending.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    let workshop = Workshop::new(args, plan, &pending)?;
    let mut failed = 0;
    for (i, run) in pending.iter().enumerate() {
        let left = match pace.remaining(&pending[i..]) {
            Some(seconds) => format!(" (about {} left)", human_time(seconds)),
            None => String::new(),
        };
        print_message(format_args!(
            "[{}/{}] {}{left}",
            i + 1,
            pending.len(),
            run.title()
        ));
        // A second signal waits until the child is gone and its result is written.
        let _no_half_run = workshop.interrupt.writing();
        let made = match workshop.interrupt.exit_code() {
            Some(_) => None,
            None => workshop.make(run)?,
        };
        let Some(record) = made else {
            print_message(
                "interrupted: what is done is kept, and the same command goes on from there",
            );
            break;
        };
        pace.note(run, record.seconds);
        failed += usize::from(record.status == Status::Failed);
        print_message(format_args!("    {}", summary(&record)));
        results.put(run.key(), record)?;
    }
    if let Some(code) = workshop.interrupt.exit_code() {
        return Ok(ExitCode::from(code));
    }
    if failed > 0 {
        print_message(format_args!(
            "{failed} run{} failed; the next start tries again",
            plural(failed)
        ));
        return Ok(ExitCode::from(INTERNAL));
    }
    Ok(ExitCode::SUCCESS)
}

/// A result in one line.
fn summary(record: &Record) -> String {
    let seconds = human_time(record.seconds);
    let metric = |name: &str| record.metrics.as_ref()?.get(name)?.as_f64();
    let error = metric("relmse").map_or(String::new(), |e| format!(", relMSE {e:.3e}"));
    match record.status {
        Status::Done => format!("{seconds}{error}"),
        Status::Stopped => format!("stopped at its limit after {seconds}{error}"),
        Status::Failed => format!("failed after {seconds}: {}", record.headline()),
    }
}

/// Everything that runs need.
struct Workshop<'a> {
    program: PathBuf,
    scenes: Files,
    references: Files,
    images: Option<&'a Path>,
    machine: Machine,
    interrupt: Interrupt,
}

impl<'a> Workshop<'a> {
    fn new(args: &'a StudyArgs, plan: &Plan, runs: &[&Run]) -> Result<Self, Failure> {
        let workshop = Workshop {
            program: std::env::current_exe()
                .map_err(|e| Failure::Internal(format!("this program is not found: {e}")))?,
            scenes: Files::scenes(args, plan, runs)?,
            references: Files::references(args, plan, runs)?,
            images: args.images.as_deref(),
            machine: Machine::this(),
            interrupt: Interrupt::install()?,
        };
        if let Some(images) = workshop.images {
            std::fs::create_dir_all(images).map_err(|e| FileError::unwritable(images, e))?;
        }
        Ok(workshop)
    }

    /// Makes a run; nothing if the study was interrupted.
    fn make(&self, run: &Run) -> Result<Option<Record>, Failure> {
        let bench = match self.images {
            Some(images) => TempDir::new_in(absolute(images)),
            None => TempDir::new(),
        };
        let bench = bench.map_err(|e| FileError::unwritable(&std::env::temp_dir(), e))?;
        let picture = bench.path().join(format!("{}.exr", run.key()));
        let mut record = Record::new(run, shown_command(run), &self.machine);

        let reference = &run.scene.reference;
        let reference_path = self.references.path(reference);
        // Before the render, which may take long.
        let reference = compare::read(&reference_path, None);
        let outcome = match &reference {
            Err(failure) => Err(failure.to_string()),
            Ok(_) => {
                let mut command = self.command(run, &picture);
                let limit = run.task.limit;
                let ended =
                    spawn_and_wait(&mut command, limit, self.interrupt.cancel(), bench.path());
                // A terminal interrupts the child as well, which may have ended by itself.
                let interrupted = self.interrupt.exit_code().is_some();
                let whole = |ended: &Ended| ended.ending == Ending::Exited(Some(0));
                if interrupted && !ended.as_ref().is_ok_and(whole) {
                    return Ok(None);
                }
                match ended {
                    Ok(ended) => note_ending(&mut record, &ended),
                    Err(error) => {
                        let program = command.get_program().to_string_lossy();
                        Err(format!("{program} cannot be run: {error}"))
                    }
                }
            }
        };
        let measured = outcome.and_then(|()| match &reference {
            Ok(reference) if picture.exists() => {
                let comparison = compare::measure(&picture, &reference_path, reference, None);
                let comparison = comparison.map(|(_, comparison)| Some(comparison));
                comparison.map_err(|failure| failure.to_string())
            }
            _ => Ok(None),
        });
        match measured {
            Ok(comparison) => {
                record.metrics = comparison.and_then(|c| serde_json::to_value(c).ok());
                if let Some(Value::Object(metrics)) = &mut record.metrics {
                    metrics.shift_remove("image");
                }
            }
            Err(message) => {
                record.status = Status::Failed;
                record.message = Some(self.without_folders(&message, bench.path()));
            }
        }
        record.date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        if let Some(images) = self.images {
            keep_pictures(bench.path(), images)?;
        }
        Ok(Some(record))
    }

    /// What makes a run.
    fn command(&self, run: &Run, picture: &Path) -> Command {
        let file = &run.scene.file;
        let call = run
            .method
            .renderer
            .call(&self.program, self.scenes.beside_plan());
        let (program, first) = call.split_first().expect("invariant: a call has a program");
        let mut command = Command::new(program);
        command
            .current_dir(self.scenes.folder_of(file))
            .args(first)
            .arg(file)
            .args(&run.words)
            .args(["--json", "--progress", "none", "--quiet", "--output"])
            .arg(picture);
        if self.images.is_some() {
            command.arg("--output").arg(picture.with_extension("png"));
        }
        command
    }

    /// Folders of this machine say nothing elsewhere.
    fn without_folders(&self, message: &str, bench: &Path) -> String {
        let folders = [&self.scenes, &self.references].into_iter();
        let folders = [bench].into_iter().chain(folders.flat_map(Files::folders));
        let mut message = message.to_owned();
        for folder in folders {
            message = message.replace(&format!("{}/", folder.display()), "");
        }
        message.truncate(message.floor_char_boundary(LONGEST_MESSAGE));
        message.trim().to_owned()
    }
}

/// How to make a run by hand, in the folder of its scene file.
fn shown_command(run: &Run) -> String {
    let picture = format!("{}.exr", run.key());
    let call = run.method.renderer.call("manylight".as_ref(), "".as_ref());
    let words = call.iter().chain([&run.scene.file]).chain(&run.words);
    let words = words.map(String::as_str).chain(["--output", &picture]);
    words.map(quoted).collect::<Vec<_>>().join(" ")
}

/// How a run ended and what it told; or why it failed.
fn note_ending(record: &mut Record, ended: &Ended) -> Result<(), String> {
    record.seconds = ended.seconds;
    record.render = serde_json::from_str(&ended.stdout).ok();
    if let Some(Value::Object(report)) = &mut record.render {
        report.shift_remove("outputs");
    }
    match ended.ending {
        Ending::Exited(Some(0)) if record.render.is_some() => {
            record.status = Status::Done;
            Ok(())
        }
        Ending::Stopped => {
            record.status = Status::Stopped;
            Ok(())
        }
        Ending::Exited(code) => {
            record.exit_code = code;
            let said = ended.stderr.trim();
            Err(match (said.is_empty(), code) {
                (false, _) => said.to_owned(),
                (true, Some(code)) => format!("ended with exit code {code} and said nothing"),
                (true, None) => "ended by a signal; perhaps there was not enough memory".into(),
            })
        }
        Ending::Interrupted => Err("interrupted".into()),
    }
}

/// Moves the pictures of a run to where they are kept.
fn keep_pictures(bench: &Path, images: &Path) -> Result<(), Failure> {
    let entries = std::fs::read_dir(bench).map_err(|e| FileError::unreadable(bench, e))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let is_picture = path.extension().is_some_and(|e| e == "exr" || e == "png");
        if let Some(name) = path.file_name().filter(|_| is_picture) {
            let target = images.join(name);
            std::fs::rename(&path, &target).map_err(|e| FileError::unwritable(&target, e))?;
        }
    }
    Ok(())
}
