//! Replays the committed corpus: small inputs that reach different code, and every input that once
//! broke a promise.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use manylight_fuzz::TARGETS;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time for all inputs of one target.
const LIMIT: Duration = Duration::from_secs(120);

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

/// The inputs of a target, sorted.
fn inputs(target: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(corpus().join(target)).unwrap();
    let mut inputs: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    inputs.sort();
    inputs
}

/// Waits for the end of a program; `None` if it takes too long, and is killed.
fn ended(mut child: Child) -> Option<std::process::Output> {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Some(child.wait_with_output().unwrap())
}

/// Runs a target on its inputs in a child process: an abort or a stack overflow must not end the
/// tests.
fn replay(target: &str) -> Result<(), String> {
    let child = Command::new(env!("CARGO_BIN_EXE_replay"))
        .arg(target)
        .args(inputs(target))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let Some(output) = ended(child) else {
        return Err(format!("{target}: not done after {LIMIT:?}"));
    };
    if output.status.success() {
        return Ok(());
    }
    let printed = String::from_utf8_lossy(&output.stdout);
    let last = printed.lines().last().unwrap_or("no input");
    let message = String::from_utf8_lossy(&output.stderr);
    Err(format!("{last}: {}\n{message}", output.status))
}

#[test]
fn the_corpus_breaks_no_promise() {
    let failures: Vec<String> = TARGETS
        .iter()
        .filter_map(|target| replay(target.name).err())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_target_has_inputs_and_every_folder_a_target() {
    /// Largest committed file in bytes, so that the corpus stays small.
    const LARGEST: u64 = 16 << 10;
    for target in TARGETS {
        let inputs = inputs(target.name);
        assert!(!inputs.is_empty(), "{}", target.name);
        for input in inputs {
            let bytes = std::fs::metadata(&input).unwrap().len();
            assert!(bytes <= LARGEST, "{}: {bytes} bytes", input.display());
        }
    }
    for folder in std::fs::read_dir(corpus()).unwrap() {
        let name = folder.unwrap().file_name();
        let is_target = TARGETS.iter().any(|target| name == target.name);
        assert!(is_target, "{name:?} belongs to no target");
    }
}

#[test]
fn every_target_has_a_program() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let manifest = std::fs::read_to_string(fuzz.join("Cargo.toml")).unwrap();
    for target in TARGETS {
        let name = target.name;
        let program =
            std::fs::read_to_string(fuzz.join(format!("fuzz_targets/{name}.rs"))).unwrap();
        assert!(program.contains(&format!("program!({name})")), "{name}");
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name}");
    }
}

#[test]
fn unknown_targets_and_absent_files_are_refused() {
    let run = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_replay"))
            .args(words)
            .output();
        output.unwrap().status.code()
    };
    assert_eq!(run(&["nothing"]), Some(2));
    assert_eq!(run(&["xml", "/absent/file"]), Some(4));
    assert_eq!(run(&["xml"]), Some(0));
}
