//! The command `manylight`.
//!
//! `args` says what can be typed, `request` what it means, `command` does it. Standard output carries data only;
//! everything else goes to standard error.

mod args;
mod command;
mod compare;
mod failure;
mod interrupt;
mod output;
mod preset;
mod progress;
mod repeat;
mod report;
mod request;
mod values;

use args::{Cli, Command};
use clap::Parser;
use failure::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // A closed stream is no reason to end otherwise than asked.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(failure::USAGE));
        }
    };
    match run(&cli.command) {
        Ok(code) => code,
        Err(Failure::ClosedPipe) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(command: &Command) -> Result<ExitCode, Failure> {
    match command {
        Command::Render(args) => command::render::run(args),
        Command::Compare(args) => command::compare::run(args),
        Command::Info(args) => command::info::run(args),
        Command::Check(args) => command::check::run(args),
        Command::List(args) => command::list::run(args),
        Command::Completions(args) => command::completions::run(args),
    }
}
