//! Runs a fuzz target on files: `replay TARGET FILE...`. Prints the path of each file before it is
//! read, so that the last one is the one that ended the program.

use cap::Cap;
use manylight_fuzz::{TARGETS, limited_allocator};
use std::alloc::System;
use std::io::{Write, stdout};
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

fn main() -> ExitCode {
    limited_allocator(&ALLOCATOR);
    let words: Vec<String> = std::env::args().skip(1).collect();
    let target = TARGETS
        .iter()
        .find(|target| words.first().is_some_and(|word| word == target.name));
    let Some(target) = target else {
        let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
        let usage = format!(
            "usage: replay TARGET FILE...\ntargets: {}\n",
            names.join(" ")
        );
        let _ = std::io::stderr().write_all(usage.as_bytes());
        return ExitCode::from(2);
    };
    for file in &words[1..] {
        let written = writeln!(stdout(), "{file}").and_then(|()| stdout().flush());
        let input = written.and_then(|()| std::fs::read(file));
        match input {
            Ok(input) => (target.run)(&input),
            Err(error) => {
                let _ = writeln!(std::io::stderr(), "{file}: {error}");
                return ExitCode::from(4);
            }
        }
    }
    ExitCode::SUCCESS
}
