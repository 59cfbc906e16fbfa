//! `manylight completions`.

use crate::args::{Cli, CompletionsArgs};
use crate::failure::Failure;
use crate::output::print_data;
use clap::CommandFactory;
use std::process::ExitCode;

/// Prints a completion script.
pub(crate) fn run(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "manylight", &mut script);
    print_data(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}
