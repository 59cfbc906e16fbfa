//! Tells the program the commit of its sources, as `MANYLIGHT_COMMIT`: from the checkout, or from
//! the file that `cargo package` adds. Empty where neither is there.

use std::path::Path;
use std::process::Command;

/// What `cargo package` notes about the repository.
const PACKAGED: &str = ".cargo_vcs_info.json";
/// The repository from the folder of this crate: one above it, such as that of a home folder, is
/// not meant.
const CHECKOUT: &str = "../../.git";
/// Changes with every commit and checkout.
const HEAD_LOG: &str = "../../.git/logs/HEAD";
/// Digits of a commit that are shown.
const DIGITS: usize = 10;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for file in [PACKAGED, HEAD_LOG] {
        if Path::new(file).exists() {
            println!("cargo::rerun-if-changed={file}");
        }
    }
    let commit = packaged().or_else(checked_out).unwrap_or_default();
    let shown = commit.get(..DIGITS).unwrap_or_default();
    println!("cargo::rustc-env=MANYLIGHT_COMMIT={shown}");
}

/// The commit that a package was made of.
fn packaged() -> Option<String> {
    let text = std::fs::read_to_string(PACKAGED).ok()?;
    let (_, value) = text.split_once("\"sha1\":")?;
    checked(value.split('"').nth(1)?)
}

/// The commit that is checked out.
fn checked_out() -> Option<String> {
    if !Path::new(CHECKOUT).exists() {
        return None;
    }
    let output = Command::new("git")
        .args(["rev-parse", "HEAD"])
        .output()
        .ok()?;
    checked(std::str::from_utf8(&output.stdout).ok()?.trim())
}

/// `text`, if it is a commit.
fn checked(text: &str) -> Option<String> {
    let is_commit = text.len() >= DIGITS && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_commit.then(|| text.to_owned())
}
