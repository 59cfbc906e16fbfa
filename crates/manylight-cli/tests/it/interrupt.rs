//! Signals: the first saves the image, the second ends the program at once.

use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

fn start(folder: &Folder, words: &str) -> (Child, BufReader<ChildStderr>) {
    let mut child = folder
        .command(words)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let stderr = BufReader::new(child.stderr.take().unwrap());
    (child, stderr)
}

/// Reads messages until one contains `word`.
fn wait_for(stderr: &mut impl BufRead, word: &str) {
    let mut line = String::new();
    while !line.contains(word) {
        line.clear();
        assert_ne!(
            stderr.read_line(&mut line).unwrap(),
            0,
            "the program ended before it said `{word}`"
        );
    }
}

fn send(signal: &str, child: &Child) {
    let status = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(status.success());
}

fn exit_code(child: &mut Child) -> Option<i32> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(30) {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    panic!("the program did not end");
}

#[test]
fn the_first_signal_saves_the_image() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let folder = Folder::new(BOX);
        let (mut child, mut stderr) =
            start(&folder, "render scene.xml -m path --time 60s -v -o a.exr");
        wait_for(&mut stderr, "loading");
        send(signal, &child);
        wait_for(&mut stderr, "wrote a.exr");
        assert_eq!(exit_code(&mut child), Some(code));
        let picture = read_layered_image(&folder.path("a.exr")).unwrap();
        assert!(picture.channel("R").unwrap().iter().any(|&v| v > 0.0));
        assert_eq!(folder.files(), ["a.exr", "scene.xml"]);
    }
}

#[test]
fn an_interrupted_image_is_denoised() {
    let folder = Folder::new(BOX);
    let (mut child, mut stderr) = start(
        &folder,
        "render scene.xml -m path --time 60s --denoise oidn -v --progress plain -o a.exr",
    );
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    if !line.contains("denoiser:") {
        println!("skipped: no Open Image Denoise");
        child.wait().unwrap();
        return;
    }
    wait_for(&mut stderr, "loading");
    send("-INT", &child);
    wait_for(&mut stderr, "wrote a.exr");
    assert_eq!(exit_code(&mut child), Some(130));
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    assert!(picture.channel("noisy.R").is_some());
}

#[test]
fn the_second_signal_ends_at_once_and_leaves_nothing() {
    let folder = Folder::new(BOX);
    // The first pass lasts long enough for both signals.
    let words = "render scene.xml -m rich-vpl --size 640x480 -n 20000 --photons 40000 -o a.exr";
    let (mut child, mut stderr) = start(&folder, &format!("{words} -v --progress plain"));
    wait_for(&mut stderr, "loading");
    send("-INT", &child);
    wait_for(&mut stderr, "interrupted");
    send("-INT", &child);
    assert_eq!(exit_code(&mut child), Some(130));
    assert_eq!(folder.files(), ["scene.xml"]);
}
