//! `render --preview`: what viewers receive, and that they change nothing else.

mod http;
mod page;
#[cfg(unix)]
mod strangers;
mod tev;
mod tev_reader;

use crate::support::{BOX, Ended, Folder};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

/// A render of 300 x 200 pixels: three by two tiles of tev.
const RENDER: &str = "render scene.xml -m path --size 300x200 --filter box";

/// The bytes of the image without a preview.
fn plain_image(folder: &Folder, options: &str) -> Vec<u8> {
    let words = format!("{RENDER} {options} -o plain.pfm -q");
    folder.run(&words).code(0);
    std::fs::read(folder.path("plain.pfm")).unwrap()
}

/// Runs a render with a preview, checks that the image is `expected`, and returns the run with its
/// time.
fn run(folder: &Folder, options: &str, expected: &[u8]) -> (Ended, Duration) {
    let start = Instant::now();
    let ended = folder.run(&format!("{RENDER} {options} -o shown.pfm"));
    let ended = ended.code(0);
    let image = std::fs::read(folder.path("shown.pfm")).unwrap();
    assert!(image == expected, "the preview changes the image");
    (ended, start.elapsed())
}

/// Whether a layer of a file has variances or error bars, which viewers do not receive.
fn is_of_noise(layer: &str) -> bool {
    layer.contains("variance") || layer.contains("error")
}

/// Lines on standard error that are warnings.
fn warnings(ended: &Ended) -> Vec<String> {
    let text = ended.stderr();
    let lines = text.lines().filter(|line| line.contains("warning"));
    lines.map(String::from).collect()
}

/// A running render with a page.
pub(crate) struct Served {
    /// The program.
    pub(super) child: Child,
    /// What it writes after the address.
    pub(super) stderr: BufReader<ChildStderr>,
    /// Host and port.
    pub(crate) host: String,
    /// Path of the page.
    pub(crate) path: String,
}

impl Served {
    pub(crate) fn start(folder: &Folder, words: &str) -> Self {
        let mut command = folder.command(words);
        command.stderr(Stdio::piped()).stdout(Stdio::piped());
        Served::of(command)
    }

    /// The render that `command` starts, with pipes for its output.
    pub(super) fn of(mut command: Command) -> Self {
        let mut child = command.spawn().unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.starts_with("preview: ") {
            line.clear();
            assert_ne!(stderr.read_line(&mut line).unwrap(), 0, "no address");
        }
        let (host, path) = http::parts(line["preview: ".len()..].trim());
        Served {
            child,
            stderr,
            host,
            path,
        }
    }

    /// The answer to a request for a part of the page.
    fn get(&self, part: &str) -> http::Answer {
        http::answer(
            &self.host,
            "GET",
            &format!("{}{part}", self.path),
            &self.host,
        )
    }

    /// Waits for the end; what the program wrote to standard error after its address.
    pub(crate) fn end(mut self) -> (Ended, String) {
        let mut text = String::new();
        self.stderr.read_to_string(&mut text).unwrap();
        (self.child.wait_with_output().unwrap().into(), text)
    }
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

#[test]
fn the_memory_limit_counts_pictures() {
    let folder = Folder::new(BOX);
    // Two pictures of 26 channels.
    let words = "render scene.xml -m rich-vpl --size 1000x1000 --memory-limit 1M --preview browser";
    folder.run(words).code(2).says(&["preview 208.0 MB"]);
}
