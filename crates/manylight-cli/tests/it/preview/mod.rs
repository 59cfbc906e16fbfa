//! `render --preview`: what viewers receive, and that they change nothing else.

mod http;
mod page;
mod tev;
mod tev_reader;

use crate::support::{BOX, Ended, Folder};
use std::time::{Duration, Instant};

/// A render of 300 x 200 pixels: three by two tiles of tev.
const RENDER: &str = "render scene.xml -m path --size 300x200 --filter box";

/// The bytes of the image without a preview.
fn plain_image(folder: &Folder, options: &str) -> Vec<u8> {
    let words = format!("{RENDER} {options} -o plain.pfm -q");
    folder.run(&words).code(0);
    std::fs::read(folder.path("plain.pfm")).unwrap()
}

/// Runs a render with a preview, checks that the image is `expected`, and returns the run with its time.
fn run(folder: &Folder, options: &str, expected: &[u8]) -> (Ended, Duration) {
    let start = Instant::now();
    let ended = folder.run(&format!("{RENDER} {options} -o shown.pfm"));
    let ended = ended.code(0);
    let image = std::fs::read(folder.path("shown.pfm")).unwrap();
    assert!(image == expected, "the preview changes the image");
    (ended, start.elapsed())
}

/// Number of lines on standard error that are warnings.
fn warnings(ended: &Ended) -> Vec<String> {
    let text = ended.stderr();
    let lines = text.lines().filter(|line| line.contains("warning"));
    lines.map(String::from).collect()
}

#[test]
fn other_viewers_are_usage_errors() {
    let folder = Folder::new(BOX);
    for (viewer, word) in [
        ("tv", "expected tev, tev:HOST:PORT, browser or browser:PORT"),
        ("tev:14158", "tev:127.0.0.1:14158"),
        ("tev:host:99999", "1 to 65535"),
        ("browser:http", "0 to 65535"),
    ] {
        let words = format!("render scene.xml --preview {viewer}");
        folder.run(&words).code(2).says(&["--preview", word]);
    }
    assert_eq!(folder.files(), ["scene.xml"]);
}
