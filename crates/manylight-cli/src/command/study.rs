//! `manylight study`: make the runs of a plan that have no result yet, and write the page.

use crate::args::StudyArgs;
use crate::failure::{DONE, Failure, INTERNAL};
use crate::interrupt::Interrupt;
use crate::output::{human_time, print_message};
use crate::study_interface::ThisProgram;
use manylight_io::FileError;
use manylight_io::write_file;
use manylight_lab::study::{
    Machine, Record, Results, Run, RunStatus, Runner, StudyFolders, StudyPlan, TimeEstimate,
    image_groups, load_plan, page, plan_runs, select_runs,
};
use manylight_lab::text::{plural, quoted};
use manylight_lab::viewer::write_pages;
use std::io;
use std::path::{Path, PathBuf};

/// Makes the runs of a plan, and its page.
pub(crate) fn run(args: &StudyArgs) -> Result<u8, Failure> {
    let plan = load_plan(&args.plan, args.scale.as_deref(), &ThisProgram)?;
    let runs = plan_runs(&plan, &ThisProgram)?;
    let default_folder = plan.results_folder();
    let folder = args.results.as_deref().unwrap_or(&default_folder);
    let mut results = Results::read(folder, &runs)?;
    let page_path = args.page.clone().unwrap_or_else(|| plan.page_path());
    check_folder(&page_path)?;
    let mut code = DONE;
    if !args.page_only {
        let selected = select_runs(&runs, &args.only)?;
        code = make_pending(args, &plan, &selected, &mut results)?;
    }
    let document = page(&plan, &runs, &results, &command_of(&plan));
    write_file(&page_path, document.markdown().as_bytes())?;
    print_message(format_args!("wrote {}", page_path.display()));
    if let (Some(folder), Some(images)) = (&args.html, &args.images) {
        let all: Vec<&Run> = runs.iter().collect();
        let references = StudyFolders::references(args.references.as_deref(), &plan, &all)?;
        let groups = image_groups(&plan, &runs, &references, images);
        write_pages(folder, &plan.title, groups, &document.parts)?;
        print_message(format_args!(
            "wrote {}",
            folder.join("index.html").display()
        ));
    }
    Ok(code)
}

/// Checks that the folder of the page exists, before hours are spent on rendering.
fn check_folder(page: &Path) -> Result<(), Failure> {
    let path = std::path::absolute(page).unwrap_or_else(|_| page.to_owned());
    if path.parent().is_some_and(Path::is_dir) {
        return Ok(());
    }
    let error = io::Error::from(io::ErrorKind::NotFound);
    Err(FileError::unwritable(&path, error).into())
}

/// The command of a study for its page, without paths of this computer.
fn command_of(plan: &StudyPlan) -> String {
    let here = std::env::current_dir().unwrap_or_default();
    let path = plan.path();
    let inside = path.strip_prefix(&here).unwrap_or(path);
    let displayed = match inside.is_absolute() {
        true => Path::new(inside.file_name().unwrap_or(inside.as_os_str())),
        false => inside,
    };
    let scale = plan.scale().map(|name| format!(" --scale {name}"));
    format!(
        "manylight study {}{}",
        quoted(&displayed.display().to_string()),
        scale.unwrap_or_default()
    )
}

/// Makes the selected runs that have no valid result, or all with `--again`.
fn make_pending(
    args: &StudyArgs,
    plan: &StudyPlan,
    selected: &[&Run],
    results: &mut Results,
) -> Result<u8, Failure> {
    let is_pending = |run: &&&Run| {
        let record = results.get(&run.key());
        args.again || !record.is_some_and(|record| record.settles(run))
    };
    let pending: Vec<&Run> = selected.iter().filter(is_pending).copied().collect();
    print_message(format_args!(
        "{} run{}, {} of them done already",
        selected.len(),
        plural(selected.len()),
        selected.len() - pending.len()
    ));
    if pending.is_empty() {
        return Ok(DONE);
    }
    let interrupt = Interrupt::install()?;
    let runner = runner(args, plan, &pending, &interrupt)?;
    let mut estimate = TimeEstimate::default();
    for run in selected {
        let record = results.get(&run.key());
        let made = |record: &&Record| matches!(record.status, RunStatus::Done | RunStatus::Stopped);
        if let Some(record) = record.filter(made) {
            estimate.note(run, record.seconds);
        }
    }
    let failed = make_all(&runner, &pending, &interrupt, estimate, results)?;
    if let Some(code) = interrupt.exit_code() {
        return Ok(code);
    }
    if failed > 0 {
        print_message(format_args!(
            "{failed} run{} failed; the next start tries again",
            plural(failed)
        ));
        return Ok(INTERNAL);
    }
    Ok(DONE)
}

/// The runner for `runs`, which starts this program.
fn runner<'a>(
    args: &'a StudyArgs,
    plan: &StudyPlan,
    runs: &[&Run],
    interrupt: &'a Interrupt,
) -> Result<Runner<'a>, Failure> {
    let program: PathBuf = std::env::current_exe()
        .map_err(|e| Failure::Internal(format!("the path of this program is not known: {e}")))?;
    let scenes = StudyFolders::scenes(args.scenes.as_deref(), plan, runs)?;
    let references = StudyFolders::references(args.references.as_deref(), plan, runs)?;
    let images = args.images.as_deref();
    if let Some(images) = images {
        std::fs::create_dir_all(images).map_err(|e| FileError::unwritable(images, e))?;
    }
    Ok(Runner {
        program,
        scenes,
        references,
        images,
        machine: Machine::this(),
        interrupted: interrupt.cancel(),
    })
}

/// Makes the pending runs until an interrupt. Returns the number of failed runs.
fn make_all(
    runner: &Runner,
    pending: &[&Run],
    interrupt: &Interrupt,
    mut estimate: TimeEstimate,
    results: &mut Results,
) -> Result<usize, Failure> {
    let mut failed = 0;
    for (i, run) in pending.iter().enumerate() {
        let left = match estimate.remaining(&pending[i..]) {
            Some(seconds) => format!(" (about {} left)", human_time(seconds)),
            None => String::new(),
        };
        print_message(format_args!(
            "[{}/{}] {}{left}",
            i + 1,
            pending.len(),
            run.title()
        ));
        // A second signal waits until the child process has ended and its result is written.
        let _complete_run = interrupt.writing();
        let made = match interrupt.exit_code() {
            Some(_) => None,
            None => runner.make(run)?,
        };
        let Some(record) = made else {
            print_message("interrupted: finished runs are kept; the same command continues");
            break;
        };
        estimate.note(run, record.seconds);
        failed += usize::from(record.status == RunStatus::Failed);
        print_message(format_args!("    {}", summary(&record)));
        results.put(run.key(), record)?;
    }
    Ok(failed)
}

/// A result in one line.
fn summary(record: &Record) -> String {
    let seconds = human_time(record.seconds);
    let error = (record.relmse()).map_or(String::new(), |e| format!(", relMSE {e:.3e}"));
    match record.status {
        RunStatus::Done => format!("{seconds}{error}"),
        RunStatus::Stopped => format!("stopped at its limit after {seconds}{error}"),
        RunStatus::Failed => format!("failed after {seconds}: {}", record.headline()),
        RunStatus::Unavailable => format!("unavailable: {}", record.headline()),
    }
}
