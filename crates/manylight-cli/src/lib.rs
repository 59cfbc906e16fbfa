//! The front end of the renderer `manylight`: the command of that name, and the same renders for
//! programs that keep scenes and pictures in memory ([`embed`]).
//!
//! `args` and `light_options` define the command line, `request` gives the options of `render`
//! their meaning, and `command` has one file per subcommand. `session` is a scene with the settings
//! of a render, `picture` makes image files of a film, `part` the files of shares and checkpoints.
//! Data goes to standard output, messages go to standard error.
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers.
//!
//! ```text
//! 10 command embed
//!  9 prepared
//!  8 part pre_pass interim kept_lights target_error
//!  7 session memory
//!  6 report
//!  5 relight repeat steady study_interface
//!  4 choice denoiser light_groups request picture progress usage
//!  3 args method
//!  2 preset version
//!  1 light_options output interrupt frame_files film_window
//!  0 failure names values stated_error
//! ```

mod args;
mod choice;
mod command;
mod denoiser;
pub mod embed;
mod failure;
mod film_window;
mod frame_files;
mod interim;
mod interrupt;
mod kept_lights;
mod light_groups;
mod light_options;
mod memory;
mod method;
mod names;
mod output;
mod part;
mod picture;
mod pre_pass;
mod prepared;
mod preset;
mod progress;
mod relight;
mod repeat;
mod report;
mod request;
mod session;
mod stated_error;
mod steady;
mod study_interface;
mod target_error;
mod usage;
mod values;
mod version;

pub use failure::Failure;
pub use interrupt::Interrupt;
pub use session::Session;

use args::{Cli, Command};
use clap::Parser;
use clap::error::ErrorKind;
use output::print_message;
use std::ffi::OsString;

/// Selects the instruction set that the environment variable `MANYLIGHT_SIMD` names, if it is set.
/// Call it before anything is rendered.
///
/// # Errors
/// The machine lacks these instructions.
pub fn select_instructions() -> Result<(), Failure> {
    let Some(name) = std::env::var_os("MANYLIGHT_SIMD") else {
        return Ok(());
    };
    manylight::select_instruction_set(&name.to_string_lossy()).map_err(|message| {
        Failure::usage(
            format!("MANYLIGHT_SIMD: {message}"),
            "without this variable, the best instructions of the machine are used",
        )
    })
}

/// Runs the command with these words, the first of which is its name. Returns its exit code.
pub fn run_command(words: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::DisplayVersion => {
            return exit_code(select_instructions().and_then(|()| version::print()));
        }
        Err(error) => {
            // A closed stream does not change the exit code.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(failure::USAGE);
        }
    };
    std::panic::set_hook(Box::new(|panic| {
        print_message(format_args!("internal error: {panic}"))
    }));
    interrupt::survive_file_limit();
    match std::panic::catch_unwind(|| {
        select_instructions()?;
        run(&cli.command)
    }) {
        Ok(result) => exit_code(result),
        Err(_) => failure::INTERNAL,
    }
}

/// The exit code of a result; a failure is printed.
fn exit_code(result: Result<u8, Failure>) -> u8 {
    match result {
        Ok(code) => code,
        Err(Failure::ClosedPipe) => failure::DONE,
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}

fn run(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Render(args) => command::render::run(args),
        Command::Maps(args) => command::maps::run(args),
        Command::Merge(args) => command::merge::run(args),
        Command::Relight(args) => command::relight::run(args),
        Command::Steady(args) => command::steady::run(args),
        Command::Compare(args) => command::compare::run(args),
        Command::Study(args) => command::study::run(args),
        Command::Info(args) => command::info::run(args),
        Command::Check(args) => command::check::run(args),
        Command::List(args) => command::list::run(args),
        Command::Completions(args) => command::completions::run(args),
    }
}
