//! Faults of the machine: files of other kinds, full disks, signals at any time, odd names, closed
//! streams, wrong clocks.
//!
//! Some need a program or a right that is not everywhere; they are skipped with a printed note
//! then.

mod inputs;
mod killed;
mod machine;
mod names;
mod outputs;

use crate::support::{Ended, Folder};
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time of a run that should end at once.
const SOON: Duration = Duration::from_secs(20);

/// Runs `command` and fails if it does not end soon.
#[track_caller]
fn soon(command: &mut Command) -> Ended {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    ended(child.unwrap())
}

/// Waits for the end of a run, which should come soon.
#[track_caller]
fn ended(mut child: Child) -> Ended {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > SOON {
            child.kill().unwrap();
            panic!("the program did not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap().into()
}

/// A script for the shell, in which `"$M"` is the program.
fn shell(folder: &Folder, script: &str) -> Command {
    let mut command = Command::new("sh");
    command
        .args(["-c", script])
        .current_dir(folder.path(""))
        .env("M", env!("CARGO_BIN_EXE_manylight"))
        .env("NO_COLOR", "1");
    command
}

/// Whether a command can be run and succeeds.
fn succeeds(words: &[&str]) -> bool {
    let (program, arguments) = words.split_first().unwrap();
    let mut command = Command::new(program);
    let command = command
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn make_pipe(folder: &Folder, name: &str) {
    assert!(succeeds(&["mkfifo", folder.path(name).to_str().unwrap()]));
}

/// Starts a render and waits until it says that it loads its scene.
fn start(mut command: Command) -> (Child, BufReader<ChildStderr>) {
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("loading") {
        line.clear();
        assert_ne!(stderr.read_line(&mut line).unwrap(), 0, "the program ended");
    }
    (child, stderr)
}

fn send(signal: &str, child: &Child) {
    assert!(succeeds(&["kill", signal, &child.id().to_string()]));
}
