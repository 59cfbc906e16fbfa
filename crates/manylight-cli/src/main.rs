//! The command `manylight`.
//!
//! `args` defines the command line, `request` gives the options of `render` their meaning, and `command` has one file per subcommand. `picture`
//! makes image files of a film, `part` the files of shares and checkpoints. Data goes to standard output, messages go to standard error.

mod args;
mod command;
mod failure;
mod interrupt;
mod method;
mod names;
mod output;
mod part;
mod picture;
mod preset;
mod progress;
mod repeat;
mod report;
mod request;
mod study_interface;
mod values;

use args::{Cli, Command};
use clap::Parser;
use failure::Failure;
use output::print_message;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // A closed stream does not change the exit code.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(failure::USAGE));
        }
    };
    std::panic::set_hook(Box::new(|panic| {
        print_message(format_args!("internal error: {panic}"))
    }));
    match std::panic::catch_unwind(|| run(&cli.command)) {
        Ok(Ok(code)) => code,
        Ok(Err(Failure::ClosedPipe)) => ExitCode::SUCCESS,
        Ok(Err(failure)) => {
            failure.print();
            ExitCode::from(failure.exit_code())
        }
        Err(_) => ExitCode::from(failure::INTERNAL),
    }
}

fn run(command: &Command) -> Result<ExitCode, Failure> {
    match command {
        Command::Render(args) => command::render::run(args),
        Command::Maps(args) => command::maps::run(args),
        Command::Merge(args) => command::merge::run(args),
        Command::Compare(args) => command::compare::run(args),
        Command::Study(args) => command::study::run(args),
        Command::Info(args) => command::info::run(args),
        Command::Check(args) => command::check::run(args),
        Command::List(args) => command::list::run(args),
        Command::Completions(args) => command::completions::run(args),
    }
}
