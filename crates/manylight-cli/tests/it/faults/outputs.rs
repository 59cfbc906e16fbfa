//! Places where nothing can be written: the message names the file, what was there stays, and
//! nothing else is left.

use super::{SOON, ended, make_pipe, send, shell, soon, start, succeeds};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use std::fs;
use std::io::{BufRead, Read};
use std::os::unix::fs::{FileTypeExt, symlink};
use std::process::Stdio;

const QUICK: &str = "render scene.xml -m path --passes 1 -q";

#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_none() {
    let folder = Folder::new(BOX);
    let full = "standard output: No space left on device";
    soon(&mut shell(&folder, "\"$M\" list methods > /dev/full"))
        .code(4)
        .says(&[full]);
    let render = format!("\"$M\" {QUICK} -o a.exr --json > /dev/full");
    soon(&mut shell(&folder, &render)).code(4).says(&[full]);
    read_layered_image(&folder.path("a.exr")).unwrap();

    let mut command = folder.command("list methods");
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(ended(child).code(0).stderr(), "");
}

#[test]
fn a_full_or_closed_standard_error_does_not_stop_a_render() {
    let folder = Folder::new(BOX);
    let render = "\"$M\" render scene.xml -m path --passes 2 -v --progress json";
    for (i, streams) in ["2> /dev/full", "2>&-", "<&- >&- 2>&-"].iter().enumerate() {
        let script = format!("{render} -o {i}.pfm {streams}");
        soon(&mut shell(&folder, &script)).code(0);
        assert!(
            fs::metadata(folder.path(&format!("{i}.pfm")))
                .unwrap()
                .len()
                > 2000
        );
    }
    // The reader of the messages leaves.
    let mut command =
        folder.command("render scene.xml -m path --passes 2000 -v --progress json -o b.pfm");
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert!(child.wait().unwrap().success());
    assert!(folder.path("b.pfm").exists());
}

#[test]
fn a_file_beyond_the_limit_is_an_error() {
    let folder = Folder::new(BOX);
    soon(&mut folder.command(&format!("{QUICK} -o a.exr"))).code(0);
    let before = fs::read(folder.path("a.exr")).unwrap();
    // Blocks of 512 or 1024 bytes. The shell raises the signal again if the program leaves it at
    // its default.
    let limited = |options: &str| format!("ulimit -f 8; \"$M\" {QUICK} {options}");
    let image = limited("--size 200x150 -o a.exr");
    let ended = soon(&mut shell(&folder, &image)).code(4);
    ended.says(&["a.exr: cannot be written: File too large"]);
    assert!(fs::read(folder.path("a.exr")).unwrap() == before);
    // The other image is written, and so is the image without its checkpoint.
    let two = limited("--size 40x30 -o b.exr -o b.jpg");
    soon(&mut shell(&folder, &two))
        .code(4)
        .says(&["b.exr: cannot be written"]);
    let checkpoint = limited("--size 40x30 --checkpoint c.part -o c.jpg");
    soon(&mut shell(&folder, &checkpoint))
        .code(4)
        .says(&["c.part: cannot be written"]);
    let part = limited("--size 40x30 --shard 1/1 -o d.part");
    soon(&mut shell(&folder, &part))
        .code(4)
        .says(&["d.part: cannot be written"]);
    assert_eq!(folder.files(), ["a.exr", "b.jpg", "c.jpg", "scene.xml"]);
}

#[test]
fn a_full_disk_and_a_read_only_one_keep_what_they_have() {
    // A mount that nobody else sees, and that ends with the shell.
    if !succeeds(&["unshare", "-m", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]) {
        println!("skipped: no right to mount");
        return;
    }
    let folder = Folder::new(BOX);
    fs::create_dir(folder.path("d")).unwrap();
    let script = format!(
        "mount -t tmpfs -o size=512k tmpfs d || exit 99
        \"$M\" {QUICK} -o d/a.exr --checkpoint d/c.part || exit 98
        sum=$(cat d/a.exr d/c.part | cksum)
        \"$M\" {QUICK} --size 300x200 -o d/a.exr; echo exit $?
        \"$M\" {QUICK} --size 300x200 -o a.png --checkpoint d/c.part; echo exit $?
        mount -o remount,ro d || exit 97
        \"$M\" {QUICK} -o d/a.exr; echo exit $?
        \"$M\" {QUICK} -o d/new.exr; echo exit $?
        \"$M\" maps scene.xml -o d/maps -q; echo exit $?
        test \"$sum\" = \"$(cat d/a.exr d/c.part | cksum)\" && echo same
        ls -A d"
    );
    let mut command = shell(&folder, "exec unshare -m sh -c \"$SCRIPT\"");
    let ended = soon(command.env("SCRIPT", script)).code(0);
    let expected = "exit 4\n".repeat(5) + "same\na.exr\nc.part\n";
    assert_eq!(ended.stdout(), expected, "{}", ended.stderr());
    ended.says(&[
        "d/a.exr: cannot be written: No space left on device",
        "d/c.part: cannot be written: No space left on device",
        "d/a.exr: cannot be written: read-only filesystem",
        "d/maps: cannot be written",
    ]);
    assert!(folder.path("a.png").exists());
}

#[test]
fn a_folder_that_vanishes_costs_its_image_only() {
    let folder = Folder::new(BOX);
    fs::create_dir(folder.path("gone")).unwrap();
    let words = "render scene.xml -m path --time 60s -v --progress json \
                 --checkpoint gone/c.part --checkpoint-every 10ms -o gone/a.exr -o kept.exr";
    let (child, mut stderr) = start(folder.command(words));
    while !folder.path("gone/c.part").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    while folder.path("gone").exists() {
        // Fails if the program writes to it at this moment.
        let _ = fs::remove_dir_all(folder.path("gone"));
    }
    let mut line = String::new();
    while !line.contains("c.part") {
        line.clear();
        assert_ne!(stderr.read_line(&mut line).unwrap(), 0);
    }
    send("-INT", &child);
    let mut text = String::new();
    stderr.read_to_string(&mut text).unwrap();
    ended(child).code(4);
    assert!(
        text.contains("gone/a.exr: cannot be written: the folder does not exist"),
        "{text}"
    );
    read_layered_image(&folder.path("kept.exr")).unwrap();
    assert_eq!(folder.files(), ["kept.exr", "scene.xml"]);
}

#[test]
fn links_are_kept_and_loops_refused() {
    let folder = Folder::new(BOX);
    fs::create_dir(folder.path("d")).unwrap();
    symlink("d/new.exr", folder.path("a.exr")).unwrap();
    symlink("nowhere/new.exr", folder.path("b.exr")).unwrap();
    symlink("d.exr", folder.path("c.exr")).unwrap();
    symlink("c.exr", folder.path("d.exr")).unwrap();
    for _ in 0..2 {
        soon(&mut folder.command(&format!("{QUICK} -o a.exr"))).code(0);
        assert!(
            fs::symlink_metadata(folder.path("a.exr"))
                .unwrap()
                .is_symlink()
        );
        assert!(
            fs::symlink_metadata(folder.path("d/new.exr"))
                .unwrap()
                .is_file()
        );
    }
    let lost = soon(&mut folder.command(&format!("{QUICK} -o b.exr")));
    lost.code(4)
        .says(&["b.exr: cannot be written: the folder does not exist"]);
    let endless = soon(&mut folder.command(&format!("{QUICK} -o c.exr")));
    endless
        .code(4)
        .says(&["c.exr: cannot be written: Too many levels of symbolic links"]);
    assert_eq!(
        folder.files(),
        ["a.exr", "b.exr", "c.exr", "d", "d.exr", "scene.xml"]
    );
}

#[test]
fn pipes_receive_images_and_are_never_replaced() {
    let folder = Folder::new(BOX);
    make_pipe(&folder, "a.exr");
    make_pipe(&folder, "c.part");
    let script = format!("cat a.exr > got.exr & \"$M\" {QUICK} -o a.exr && wait");
    soon(&mut shell(&folder, &script)).code(0);
    read_layered_image(&folder.path("got.exr")).unwrap();
    let expected = "c.part: cannot be written: found a device or a pipe, expected a regular file";
    for options in ["-o b.exr --checkpoint c.part", "--shard 1/1 -o c.part"] {
        let ended = soon(&mut folder.command(&format!("{QUICK} {options}")));
        ended.code(4).says(&[expected]);
    }
    for name in ["a.exr", "c.part"] {
        let kind = fs::symlink_metadata(folder.path(name)).unwrap().file_type();
        assert!(kind.is_fifo());
    }
}

#[test]
fn the_third_signal_does_not_wait_for_a_file() {
    let folder = Folder::new(BOX);
    // Nobody reads this pipe.
    make_pipe(&folder, "a.exr");
    let words = "render scene.xml -m path --passes 1 -v -o a.exr";
    let (mut child, _stderr) = start(folder.command(words));
    let begun = std::time::Instant::now();
    while child.try_wait().unwrap().is_none() && begun.elapsed() < SOON {
        std::thread::sleep(std::time::Duration::from_millis(300));
        send("-INT", &child);
    }
    ended(child).code(130);
}
