//! Virtual lights in files: `--lights-out`, `--lights-in`.

use crate::support::{BOX, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};

const QUICK: &str = "--lights 16 --photons 2000 -q";

/// Everything but metadata, which holds times.
fn pixels(folder: &Folder, name: &str) -> LayeredImage {
    LayeredImage {
        metadata: Vec::new(),
        ..read_layered_image(&folder.path(name)).unwrap()
    }
}

/// A folder with lights for 10 passes, and the picture that was made with them.
fn kept(options: &str) -> Folder {
    let folder = Folder::new(BOX);
    let words = format!("render scene.xml --passes 10 --lights-out a.lights -o a.exr {options}");
    folder.run(&format!("{words} {QUICK}")).code(0);
    folder
}

#[test]
fn kept_lights_give_the_bits_of_the_render_that_made_them() {
    for options in [
        "",
        "-m vpl",
        "-m rich-vsl --emission vmf",
        "--table-storage blocks",
        "--light-groups",
    ] {
        let folder = kept(options);
        // The options that made the lights may be repeated.
        let words = format!("render scene.xml --lights-in a.lights {options} -o b.exr --json -q");
        let report = folder.run(&words).code(0).json();
        assert!(
            pixels(&folder, "a.exr") == pixels(&folder, "b.exr"),
            "{options}"
        );
        assert_eq!(report["counts"]["passes"], 10);
        assert!(report["counts"]["lights"].as_u64().unwrap() >= 16 * 16);
        assert!(report["counts"].get("photons").is_none_or(|n| n == 0));
        let command = |name: &str| {
            let picture = read_layered_image(&folder.path(name)).unwrap();
            picture.metadata_value("command").unwrap().to_owned()
        };
        assert!(command("a.exr").contains("--lights-out a.lights"));
        let again = command("b.exr").replace("--output b.exr", "--output c.exr -q");
        folder
            .run(again.strip_prefix("manylight ").unwrap())
            .code(0);
        assert!(
            pixels(&folder, "b.exr") == pixels(&folder, "c.exr"),
            "{again}"
        );
    }
}

#[test]
fn kept_lights_serve_frames_shares_and_checkpoints() {
    let folder = kept("--block 8");
    let camera = |x: f32| format!("[[-1, 0, 0, {x}], [0, 1, 0, 1], [0, 0, -1, 4], [0, 0, 0, 1]]");
    let walk = format!("[{}, {}]", camera(-0.5), camera(0.5));
    std::fs::write(folder.path("walk.json"), walk).unwrap();
    let words = "render scene.xml --lights-in a.lights";
    folder
        .run(&format!("{words} --cameras walk.json -o walk.exr -q"))
        .code(0);
    assert!(pixels(&folder, "walk.0001.exr") != pixels(&folder, "walk.0002.exr"));
    for share in 1..=2 {
        let options = format!("--shard {share}/2 --block 8 -o {share}.part -q");
        folder.run(&format!("{words} {options}")).code(0);
    }
    folder.run("merge 1.part 2.part -o merged.exr -q").code(0);
    assert!(pixels(&folder, "a.exr") == pixels(&folder, "merged.exr"));

    let checkpoint = "--checkpoint state.part --block 8 -q";
    folder
        .run(&format!("{words} {checkpoint} --passes 5 -o half.exr"))
        .code(0);
    let resumed = format!("{words} {checkpoint} --resume state.part -o whole.exr");
    folder.run(&resumed).code(0);
    assert!(pixels(&folder, "a.exr") == pixels(&folder, "whole.exr"));
    // Other lights: the checkpoint is one of another render.
    let others = format!("render scene.xml --passes 10 --seed 5 --lights-out a.lights {QUICK}");
    folder.run(&format!("{others} -o other.exr")).code(0);
    folder.run(&resumed).code(2).says(&["lights_sha256"]);
}

#[test]
fn lights_that_do_not_fit_are_refused() {
    let folder = kept("");
    std::fs::write(
        folder.path("other.xml"),
        BOX.replace("0.5, 0.4", "0.5, 0.3"),
    )
    .unwrap();
    let bytes = std::fs::read(folder.path("a.lights")).unwrap();
    std::fs::write(folder.path("cut.lights"), &bytes[..bytes.len() - 8]).unwrap();
    let mut damaged = bytes;
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    std::fs::write(folder.path("damaged.lights"), damaged).unwrap();
    let before = folder.files();
    for (words, code, says) in [
        (
            "other.xml --lights-in a.lights",
            2,
            &["another scene", "scene_sha256"][..],
        ),
        (
            "scene.xml --lights-in a.lights --max-depth 3",
            2,
            &["max_depth is 4", "3"],
        ),
        (
            "scene.xml --lights-in a.lights --light-groups",
            2,
            &["no light groups", "the render the light groups"],
        ),
        (
            "scene.xml --lights-in a.lights -n 8",
            2,
            &["--lights 8: the lights of", "made with --lights 16"],
        ),
        (
            "scene.xml --lights-in a.lights --emission vmf",
            2,
            &["--emission vmf", "made with --emission table"],
        ),
        (
            "scene.xml --lights-in a.lights -m vpl",
            2,
            &["the method rich-vpl"],
        ),
        (
            "scene.xml --lights-in a.lights --passes 11",
            2,
            &["lights for 10 passes"],
        ),
        (
            "scene.xml --lights-in cut.lights",
            4,
            &["cut.lights", "damaged"],
        ),
        (
            "scene.xml --lights-in damaged.lights",
            4,
            &["damaged.lights", "checksum"],
        ),
        ("scene.xml --lights-in none.lights", 4, &["none.lights"]),
        (
            "scene.xml --lights-in scene.xml",
            4,
            &["a file of virtual lights"],
        ),
        (
            "scene.xml --lights-out b.lights -m path",
            2,
            &["method path"],
        ),
        ("scene.xml --lights-out b.lights -m lightcuts", 2, &["cuts"]),
        ("scene.xml --lights-out b.lights --time 1s", 2, &["--time"]),
        (
            "scene.xml --lights-out b.lights --lights-in a.lights",
            2,
            &["--lights-in"],
        ),
        ("scene.xml --lights-out scene.xml", 2, &["scene.xml"]),
    ] {
        let ended = folder.run(&format!("render {words} -o b.exr -q"));
        ended.code(code).says(says);
    }
    assert_eq!(folder.files(), before);
}
