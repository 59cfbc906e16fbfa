//! The command `manylight`.

use std::process::ExitCode;

fn main() -> ExitCode {
    manylight_cli::run_command(std::env::args_os()).into()
}
