//! A program that is killed or stopped at any instant: whole files stay whole, and a render can be
//! continued.

use super::{ended, send, shell, soon, start};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use manylight_io::part::PartFile;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// How often a program is killed; `MANYLIGHT_KILLS` sets another number.
fn kills() -> u32 {
    let number = std::env::var("MANYLIGHT_KILLS").ok();
    number.and_then(|text| text.parse().ok()).unwrap_or(24)
}

/// Runs `words` and kills the program after `delay`. Whether it was killed before its end.
fn run_killed(folder: &Folder, words: &str, delay: Duration) -> bool {
    let mut command = folder.command(words);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(delay);
    let ran = child.try_wait().unwrap().is_none();
    child.kill().unwrap();
    child.wait().unwrap();
    ran
}

fn check_part(path: &Path) {
    let part = PartFile::open(path).unwrap_or_else(|error| panic!("{error}"));
    part.verify().unwrap_or_else(|error| panic!("{error}"));
}

/// Names of files that a killed program leaves: they are hidden, and none has the name of an
/// output.
fn leftovers(folder: &Folder) -> usize {
    let names = folder.files();
    names
        .iter()
        .filter(|name| name.starts_with(".manylight-"))
        .count()
}

#[test]
fn images_and_parts_are_whole_when_the_program_is_killed() {
    let folder = Folder::new(BOX);
    let image = "render scene.xml -m direct --passes 1 -q --size 160x120 -o a.exr -o a.png";
    let part = "render scene.xml -m direct --passes 1 -q --size 160x120 --shard 1/1 -o a.part";
    let begun = Instant::now();
    for words in [image, part] {
        soon(&mut folder.command(words)).code(0);
    }
    // The time of one run; the last third of it writes.
    let whole = begun.elapsed() / 2;
    let mut killed = 0;
    for i in 0..kills() {
        let share = f64::from(i) / f64::from(kills());
        let delay = whole.mul_f64(0.2 + 1.1 * share);
        let words = if i % 3 == 2 { part } else { image };
        killed += u32::from(run_killed(&folder, words, delay));
        for name in ["a.exr", "a.png"] {
            read_layered_image(&folder.path(name)).unwrap_or_else(|error| panic!("{error}"));
        }
        check_part(&folder.path("a.part"));
    }
    println!(
        "{killed} of {} were killed before their end, {} temporary files",
        kills(),
        leftovers(&folder)
    );
    assert!(killed > 0);
    let names = folder
        .files()
        .into_iter()
        .filter(|name| !name.starts_with(".manylight-"));
    assert_eq!(
        names.collect::<Vec<_>>(),
        ["a.exr", "a.part", "a.png", "scene.xml"]
    );
}

#[test]
fn a_render_that_is_killed_again_and_again_has_the_bits_of_one_run() {
    let folder = Folder::new(BOX);
    let render = "render scene.xml -m path --size 64x48 -q";
    soon(&mut folder.command(&format!("{render} --passes 150 -o whole.pfm"))).code(0);
    let resumed = format!(
        "{render} --passes 150 --checkpoint c.part --resume c.part --checkpoint-every 1ms -o a.pfm"
    );
    let mut survived = Vec::new();
    for i in 0..kills() {
        run_killed(
            &folder,
            &resumed,
            Duration::from_millis(u64::from(20 + 13 * (i % 11))),
        );
        if folder.path("c.part").exists() {
            check_part(&folder.path("c.part"));
            survived.push(fs::metadata(folder.path("c.part")).unwrap().len());
        }
        if folder.path("a.pfm").exists() {
            break;
        }
    }
    println!(
        "{} checkpoints survived, {} temporary files",
        survived.len(),
        leftovers(&folder)
    );
    assert!(!survived.is_empty());
    soon(&mut folder.command(&resumed)).code(0);
    assert!(fs::read(folder.path("a.pfm")).unwrap() == fs::read(folder.path("whole.pfm")).unwrap());
}

#[test]
fn a_stopped_render_goes_on() {
    let folder = Folder::new(BOX);
    // Stopped within its time, and beyond it.
    for (time, pause) in [(1500, 500), (600, 1500)] {
        let words = format!("render scene.xml -m path --time {time}ms -v --progress json -o a.exr");
        let begun = Instant::now();
        let (child, mut stderr) = start(folder.command(&words));
        std::thread::sleep(Duration::from_millis(200));
        send("-STOP", &child);
        std::thread::sleep(Duration::from_millis(pause));
        send("-CONT", &child);
        let mut text = String::new();
        stderr.read_to_string(&mut text).unwrap();
        ended(child).code(0);
        assert!(begun.elapsed() > Duration::from_millis(time.max(pause)));
        let picture = read_layered_image(&folder.path("a.exr")).unwrap();
        let values = picture.channel("R").unwrap();
        assert!(values.iter().all(|v| v.is_finite()) && values.iter().any(|&v| v > 0.0));
    }
}

#[test]
fn a_closed_terminal_saves_the_image_unless_the_signal_is_ignored() {
    if !Path::new("/proc/self/status").exists() {
        println!("skipped: this system does not tell whether SIGHUP is ignored");
        return;
    }
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --time 60s -v -o a.exr";
    let (child, _stderr) = start(folder.command(words));
    send("-HUP", &child);
    ended(child).code(129);
    read_layered_image(&folder.path("a.exr")).unwrap();

    let ignoring = format!("trap '' HUP; exec \"$M\" {words}");
    let (mut child, _stderr) = start(shell(&folder, &ignoring));
    send("-HUP", &child);
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none());
    send("-INT", &child);
    ended(child).code(130);
}
