//! Shares and checkpoints: the same bits as one run, and refusals of files that do not belong to
//! it.

use crate::support::{BOX, Ended, Folder};
use manylight_io::image::read_layered_image;
use std::fs;
use std::process::Stdio;
use std::time::Duration;

const METHODS: [&str; 5] = [
    "auto -n 16 --photons 2000",
    "rich-vpl -n 16 --photons 2000",
    "path",
    "photon-map --photons 2000",
    "rich-lightcuts -n 64 --photons 2000",
];
/// Two blocks and a part of a third.
const PASSES: &str = "--passes 19 --block 8 --aov all --light-groups -q";

/// All channels of an image, by name.
fn channels(folder: &Folder, name: &str) -> Vec<(String, Vec<u32>)> {
    let picture = read_layered_image(&folder.path(name)).unwrap();
    let layers = picture.layers.into_iter().flat_map(|layer| layer.channels);
    layers
        .map(|(name, values)| (name, values.into_iter().map(f32::to_bits).collect()))
        .collect()
}

fn render(folder: &Folder, method: &str, options: &str) -> Ended {
    folder.run(&format!("render scene.xml -m {method} {PASSES} {options}"))
}

#[test]
fn merged_shares_have_the_bits_of_one_run() {
    for method in METHODS {
        let folder = Folder::new(BOX);
        render(&folder, method, "-o whole.exr").code(0);
        let whole = channels(&folder, "whole.exr");
        for (count, order) in [(1, vec![1]), (2, vec![2, 1]), (3, vec![2, 3, 1])] {
            for share in 1..=count {
                // Any number of threads.
                render(
                    &folder,
                    method,
                    &format!("--shard {share}/{count} -o {share}.part -t {share}"),
                )
                .code(0);
            }
            let parts: Vec<String> = order.iter().map(|share| format!("{share}.part")).collect();
            folder
                .run(&format!("merge {} -o merged.exr -q", parts.join(" ")))
                .code(0);
            assert!(
                channels(&folder, "merged.exr") == whole,
                "{method}, {count} shares"
            );
        }
        let [merged, whole] =
            ["merged.exr", "whole.exr"].map(|name| read_layered_image(&folder.path(name)).unwrap());
        assert_eq!((merged.camera, merged.window), (whole.camera, whole.window));
        let value = |picture: &manylight_io::image::LayeredImage, key: &str| {
            picture
                .metadata
                .iter()
                .find(|(name, _)| name == key)
                .map(|(_, value)| value.clone())
        };
        for key in [
            "passes",
            "scene.sha256",
            "settings.seed",
            "variance_of_mean",
            "error.at_most",
        ] {
            assert!(
                value(&whole, key).is_some() && value(&merged, key) == value(&whole, key),
                "{key}"
            );
        }
        let command = value(&merged, "command").unwrap();
        let words = command.strip_prefix("manylight ").unwrap();
        folder.run(&format!("{words} -o again.exr -q")).code(0);
        assert!(
            channels(&folder, "again.exr") == channels(&folder, "whole.exr"),
            "{command}"
        );
    }
}

#[test]
fn a_render_that_is_killed_at_any_time_and_resumed_has_the_same_bits() {
    for (k, method) in METHODS.iter().enumerate() {
        let folder = Folder::new(BOX);
        render(&folder, method, "-o whole.exr").code(0);
        let resumed = format!(
            "render scene.xml -m {method} {PASSES} --checkpoint a.part --checkpoint-every 1ms --resume a.part -o a.exr"
        );
        for kill in 0..4 {
            let mut child = folder
                .command(&resumed)
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_millis(15 + 40 * kill + 7 * k as u64));
            child.kill().unwrap();
            child.wait().unwrap();
        }
        folder.run(&resumed).code(0);
        assert!(
            channels(&folder, "a.exr") == channels(&folder, "whole.exr"),
            "{method}"
        );
        // What a killed process leaves is a temporary file beside the checkpoint.
        let files = folder.files();
        assert!(
            files
                .iter()
                .all(|name| name.starts_with(".manylight-") || !name.contains("tmp")),
            "{files:?}"
        );
    }
}

#[test]
fn a_finished_render_can_be_given_more_passes() {
    let folder = Folder::new(BOX);
    folder
        .run("render scene.xml -m path --passes 24 --block 8 -o whole.exr -q")
        .code(0);
    folder
        .run("render scene.xml -m path --passes 10 --block 8 --checkpoint a.part -o a.exr -q")
        .code(0);
    let report = folder
        .run("render scene.xml -m path --passes 24 --block 8 --resume a.part -o b.exr --json -q")
        .code(0)
        .json();
    assert!(channels(&folder, "b.exr") == channels(&folder, "whole.exr"));
    assert_eq!(report["counts"]["passes"], 24);
    assert_eq!(report["counts"]["camera_paths"], 24 * 192);
    folder
        .run("render scene.xml -m path --passes 9 --block 8 --resume a.part -o c.exr")
        .code(2)
        .says(&["a.part has 10 passes"]);
}

/// A farm may have more shares than a process may have open files.
#[cfg(unix)]
#[test]
fn more_parts_than_open_files_are_merged() {
    let folder = Folder::new(BOX);
    let options = "-m direct --size 4x3 --passes 320 --block 8 -q";
    for share in 1..=40 {
        folder
            .run(&format!(
                "render scene.xml {options} --shard {share}/40 -o {share}.part"
            ))
            .code(0);
    }
    folder
        .run(&format!("render scene.xml {options} -o whole.exr"))
        .code(0);
    let merge = "ulimit -n 32 && exec \"$0\" merge *.part -o merged.exr";
    let ended = std::process::Command::new("sh")
        .args(["-c", merge, env!("CARGO_BIN_EXE_manylight")])
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    assert!(
        ended.status.success(),
        "{}",
        String::from_utf8_lossy(&ended.stderr)
    );
    assert!(channels(&folder, "merged.exr") == channels(&folder, "whole.exr"));
}

/// Two shares of a render, and a checkpoint of the same.
fn parts() -> Folder {
    let folder = Folder::new(BOX);
    for share in 1..=2 {
        render(
            &folder,
            "path",
            &format!("--shard {share}/2 -o {share}.part"),
        )
        .code(0);
    }
    render(&folder, "path", "--checkpoint state.part -o a.exr").code(0);
    folder
}

#[test]
fn damaged_parts_are_refused_by_name() {
    let folder = parts();
    let whole = fs::read(folder.path("2.part")).unwrap();
    let refused = |bytes: &[u8]| {
        fs::write(folder.path("2.part"), bytes).unwrap();
        folder
            .run("merge 1.part 2.part -o merged.exr")
            .code(4)
            .says(&["2.part"]);
        fs::write(folder.path("state.part"), bytes).unwrap();
        render(&folder, "path", "--resume state.part -o b.exr").says(&["state.part"]);
    };
    for cut in [0, 3, 8, 100, whole.len() / 2, whole.len() - 1] {
        refused(&whole[..cut]);
    }
    for place in [
        0,
        6,
        9,
        60,
        whole.len() / 3,
        whole.len() / 2,
        whole.len() - 1,
    ] {
        let mut damaged = whole.clone();
        damaged[place] ^= 0x10;
        refused(&damaged);
    }
    refused(b"<scene/>");
    refused(&[whole.as_slice(), &[0]].concat());
    assert!(!folder.files().contains(&"merged.exr".to_owned()));
}

#[test]
fn parts_of_another_render_are_refused_with_the_difference() {
    let folder = parts();
    let others = [
        ("--seed 5", "seed is 5"),
        ("--max-depth 3", "max_depth is 3"),
        ("--size 8x6", "size is"),
        ("--filter tent", "filter is tent"),
        ("--hide-emitters", "hide_emitters is true"),
        ("--sensor 0 --crop 0,0.5,0,1", "crop_size is"),
    ];
    for (options, difference) in others {
        render(
            &folder,
            "path",
            &format!("{options} --shard 2/2 -o other.part"),
        )
        .code(0);
        folder
            .run("merge 1.part other.part -o m.exr")
            .code(2)
            .says(&["other.part", difference, "1.part"]);
        let resumed = render(
            &folder,
            "path",
            &format!("{options} --resume state.part -o b.exr"),
        );
        resumed.code(2).says(&["state.part", "this command"]);
    }
    render(&folder, "direct", "--shard 2/2 -o other.part").code(0);
    folder
        .run("merge 1.part other.part -o m.exr")
        .code(2)
        .says(&["other.part", "method is direct"]);
    fs::write(
        folder.path("scene.xml"),
        BOX.replace("0.5, 0.4, 0.3", "0.5, 0.4, 0.2"),
    )
    .unwrap();
    render(&folder, "path", "--shard 2/2 -o other.part").code(0);
    folder
        .run("merge 1.part other.part -o m.exr")
        .code(2)
        .says(&["other.part", "scene_sha256"]);
    render(&folder, "path", "--resume state.part -o b.exr")
        .code(2)
        .says(&["state.part", "scene_sha256"]);
}

#[test]
fn gaps_repetitions_and_parts_of_another_kind_are_refused() {
    let folder = parts();
    folder
        .run("merge 1.part -o m.exr")
        .code(2)
        .says(&["2 of 3 blocks", "1, 2"]);
    folder
        .run("merge 1.part 2.part 1.part -o m.exr")
        .code(2)
        .says(&["1.part", "both have block 0"]);
    folder
        .run("merge state.part -o m.exr")
        .code(4)
        .says(&["state.part", "no share"]);
    folder
        .run("merge 1.part state.part 2.part -o m.exr")
        .code(4)
        .says(&["state.part", "no share"]);
    folder
        .run("merge 1.part absent.part -o m.exr")
        .code(4)
        .says(&["absent.part"]);
    folder
        .run("merge 1.part a.exr -o m.exr")
        .code(4)
        .says(&["a.exr"]);
    render(&folder, "path", "--resume 1.part -o b.exr")
        .code(4)
        .says(&["1.part", "found a share", "expected a checkpoint"]);
    render(&folder, "path", "--resume absent.part -o b.exr")
        .code(4)
        .says(&["absent.part"]);
    for share in [1, 9] {
        render(&folder, "path", &format!("--shard {share}/9 -o 4.part"))
            .code(2)
            .says(&["found 3 blocks of up to 8 passes in 19 passes"]);
        assert!(!folder.path("4.part").exists());
    }
    // The quantities are those of the command, also where path tracing takes more samples instead.
    for share in [1, 2] {
        let options = format!("--size 8x6 --passes 1 --shard {share}/2 -o 4.part");
        folder
            .run(&format!("render scene.xml {options}"))
            .code(2)
            .says(&["found 1 block of up to 16 passes in 1 pass, expected at least 2 blocks"]);
    }
    // The format is stated in a string of the header.
    let mut newer = fs::read(folder.path("2.part")).unwrap();
    let key = br#"\"format\":2"#;
    let place = newer
        .windows(key.len())
        .position(|window| window == key)
        .unwrap();
    newer[place + key.len() - 1] = b'3';
    fs::write(folder.path("newer.part"), newer).unwrap();
    folder
        .run("merge 1.part newer.part -o m.exr")
        .code(4)
        .says(&["newer.part", "format 3", "format 2"]);
    assert!(!folder.files().contains(&"m.exr".to_owned()));
}

/// Machines of a farm may have different instructions: the common ones give equal bits.
#[test]
fn parts_of_one_selected_instruction_set_are_merged() {
    let folder = Folder::new(BOX);
    let render = |set: &str, options: &str| {
        let words = format!("render scene.xml -m path {PASSES} {options}");
        let mut command = folder.command(&words);
        Ended::from(command.env("MANYLIGHT_SIMD", set).output().unwrap())
    };
    render("portable", "-o whole.exr").code(0);
    for share in [1, 2] {
        render("portable", &format!("--shard {share}/2 -o {share}.part")).code(0);
    }
    folder.run("merge 2.part 1.part -o merged.exr -q").code(0);
    assert!(channels(&folder, "merged.exr") == channels(&folder, "whole.exr"));
    render("mmx", "-o other.exr")
        .code(2)
        .says(&["MANYLIGHT_SIMD", "'mmx'", "portable"]);
    let best = manylight::instruction_set();
    if !best.ends_with("portable") {
        folder
            .run(&format!(
                "render scene.xml -m path {PASSES} --shard 2/2 -o best.part"
            ))
            .code(0);
        folder
            .run("merge 1.part best.part -o mixed.exr")
            .code(2)
            .says(&["best.part", "instruction_set", &best, "portable"]);
    }
}
