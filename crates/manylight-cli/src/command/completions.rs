//! `manylight completions`.

use crate::args::{Cli, CompletionsArgs};
use crate::failure::{DONE, Failure};
use crate::output::print_data;
use clap::CommandFactory;

/// Prints a completion script.
pub(crate) fn run(args: &CompletionsArgs) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "manylight", &mut script);
    print_data(String::from_utf8_lossy(&script).trim_end())?;
    Ok(DONE)
}
