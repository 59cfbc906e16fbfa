//! Other processors, clocks, languages and folders.

use super::{shell, soon, succeeds};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use std::fs;

const QUICK: &str = "render scene.xml -m path --passes 2 -q";

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let folder = Folder::new(BOX);
    for method in ["path", "rich-vpl -n 64 --photons 2000"] {
        let images = [1, 64].map(|threads| {
            let words = format!("render scene.xml -m {method} --passes 2 -q -t {threads} -o a.pfm");
            soon(&mut folder.command(&words)).code(0);
            fs::read(folder.path("a.pfm")).unwrap()
        });
        assert!(images[0] == images[1], "{method}");
    }
}

#[test]
fn the_environment_changes_nothing() {
    let folder = Folder::new(BOX);
    soon(&mut folder.command(&format!("{QUICK} -o plain.pfm"))).code(0);
    let plain = fs::read(folder.path("plain.pfm")).unwrap();
    for settings in [
        "env -i",
        "env -i LC_ALL=de_DE.UTF-8 LANG=de_DE.UTF-8",
        "env -i LC_ALL=C",
        "env -i LC_ALL=tr_TR.UTF-8 TERM=dumb COLUMNS=1",
        "env HOME=/nonexistent TMPDIR=/nonexistent USER= PATH=",
    ] {
        let script = format!("rm -f a.pfm; {settings} \"$M\" {QUICK} -o a.pfm");
        soon(&mut shell(&folder, &script)).code(0);
        assert!(
            fs::read(folder.path("a.pfm")).unwrap() == plain,
            "{settings}"
        );
    }
}

#[test]
fn paths_belong_to_the_current_folder_also_if_it_is_gone() {
    let folder = Folder::new(BOX);
    fs::create_dir_all(folder.path("work/in")).unwrap();
    let words = "-m direct --passes 1 -q";
    let script = format!(
        "cd work/in && \"$M\" render ../../scene.xml {words} && \"$M\" render ../../scene.xml {words} -o ../b.exr"
    );
    soon(&mut shell(&folder, &script)).code(0);
    assert!(folder.path("work/b.exr").exists());
    assert_eq!(fs::read_dir(folder.path("work/in")).unwrap().count(), 2);

    let top = folder.path("");
    let top = top.to_str().unwrap();
    fs::create_dir(folder.path("gone")).unwrap();
    let leave = "cd gone && rmdir ../gone &&";
    let absolute = format!("{leave} \"$M\" render {top}/scene.xml {words} -o {top}/c.exr");
    soon(&mut shell(&folder, &absolute)).code(0);
    fs::create_dir(folder.path("gone")).unwrap();
    let relative = format!("{leave} \"$M\" render {top}/scene.xml {words} -o c.exr");
    soon(&mut shell(&folder, &relative))
        .code(4)
        .says(&["c.exr: cannot be written"]);
    let mut files = folder.files();
    files.retain(|name| name != "work");
    assert_eq!(files, ["c.exr", "scene.xml"]);
}

#[test]
fn a_wrong_clock_changes_dates_only() {
    if !succeeds(&["faketime", "2020-01-01", "true"]) {
        println!("skipped: no faketime");
        return;
    }
    let folder = Folder::new(BOX);
    let days = "%Y-%m-%d %T";
    for (format, clock, date) in [
        (days, "1960-01-01 00:00:00", "1970:01:01 00:00:00"),
        (days, "2020-02-03 04:05:06", "2020:02:03 04:05:"),
        ("%s", "288000000000", "9999:12:31 23:59:59"),
    ] {
        let script = format!(
            "TZ=UTC FAKETIME_FMT='{format}' faketime -f '@{clock}' \"$M\" {QUICK} -o a.exr"
        );
        soon(&mut shell(&folder, &script)).code(0);
        let picture = read_layered_image(&folder.path("a.exr")).unwrap();
        let found = picture.metadata_value("capDate").unwrap();
        assert!(found.starts_with(date), "{clock}: {found}");
    }
    // A clock that runs away: the time limit follows the clock that never jumps.
    let script = "DONT_FAKE_MONOTONIC=1 faketime -f '+0 x1000' \"$M\" render scene.xml -m path --time 1s -q -o a.exr";
    let start = std::time::Instant::now();
    soon(&mut shell(&folder, script)).code(0);
    assert!(start.elapsed().as_secs_f64() > 0.7);
}

#[test]
fn old_processors_render_the_same_picture() {
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --passes 4 -q";
    soon(&mut folder.command(&format!("{words} -o best.pfm"))).code(0);
    soon(
        folder
            .command(&format!("{words} -o portable.pfm"))
            .env("MANYLIGHT_SIMD", "portable"),
    )
    .code(0);
    let mut names = vec!["portable.pfm"];
    if succeeds(&["qemu-x86_64", "--version"]) {
        // The first x86-64 processors: SSE2 and nothing newer.
        let script = format!("qemu-x86_64 -cpu qemu64 \"$M\" {words} -o old.pfm");
        soon(&mut shell(&folder, &script)).code(0);
        names.push("old.pfm");
    } else {
        println!("not checked: no qemu-x86_64");
    }
    let [best, portable] = ["best.pfm", "portable.pfm"].map(|name| values(&folder, name));
    let far = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-3 * (a + b);
    let differ = best.iter().zip(&portable).filter(|&pair| far(pair)).count();
    assert!(
        differ * 50 < best.len(),
        "{differ} of {} values differ",
        best.len()
    );
    for name in names {
        assert!(values(&folder, name) == portable, "{name}");
    }
}

fn values(folder: &Folder, name: &str) -> Vec<f32> {
    let picture = read_layered_image(&folder.path(name)).unwrap();
    picture
        .layers
        .into_iter()
        .flat_map(|layer| layer.channels)
        .flat_map(|channel| channel.1)
        .collect()
}
