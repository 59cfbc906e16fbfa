//! Walkthroughs: a picture for each camera of a file.

use crate::support::{BOX, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};

const QUICK: &str = "--lights 16 --photons 2000 --passes 2";

/// Cameras in front of the box, that look into it from these places along x.
fn camera_path(places: &[f32]) -> String {
    let matrix = |x: &f32| format!("[[-1, 0, 0, {x}], [0, 1, 0, 1], [0, 0, -1, 4], [0, 0, 0, 1]]");
    let matrices: Vec<_> = places.iter().map(matrix).collect();
    format!("[\n{}\n]", matrices.join(",\n"))
}

fn walk() -> Folder {
    let folder = Folder::new(BOX);
    std::fs::write(folder.path("walk.json"), camera_path(&[-0.5, 0.0, 0.5])).unwrap();
    folder
}

/// Everything but metadata, which holds times.
fn pixels(folder: &Folder, name: &str) -> LayeredImage {
    LayeredImage {
        metadata: Vec::new(),
        ..read_layered_image(&folder.path(name)).unwrap()
    }
}

#[test]
fn each_frame_has_its_files_and_the_bits_of_its_render_alone() {
    let folder = walk();
    let words = format!("render scene.xml --cameras walk.json {QUICK} -o a.exr -o a-##.png --json");
    let report = folder.run(&words).code(0).json();
    assert_eq!(report["method"], "rich-vpl");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 6);
    let files = [
        "a-01.png",
        "a-02.png",
        "a-03.png",
        "a.0001.exr",
        "a.0002.exr",
        "a.0003.exr",
    ];
    assert_eq!(
        folder.files(),
        [&files[..], &["scene.xml", "walk.json"]].concat()
    );
    assert!(pixels(&folder, "a.0001.exr") != pixels(&folder, "a.0003.exr"));

    let picture = read_layered_image(&folder.path("a.0002.exr")).unwrap();
    let command = picture.metadata_value("command").unwrap();
    assert!(command.contains("--frames 2..2"), "{command}");
    let again = command.strip_prefix("manylight ").unwrap();
    let again = again.replace("--output a.exr", "--output b.exr -q");
    let again = again.replace(" --output 'a-##.png'", "");
    folder.run(&again).code(0);
    assert!(
        pixels(&folder, "a.0002.exr") == pixels(&folder, "b.0002.exr"),
        "{again}"
    );
}

#[test]
fn a_camera_that_moves_in_the_scene_has_frames() {
    let place = r#"<transform name="to_world"><lookat origin="0, 1, 4" target="0, 0.8, 0" up="0, 1, 0"/></transform>"#;
    let key = |time: &str, x: &str| {
        format!(
            r#"<transform time="{time}"><lookat origin="{x}, 1, 4" target="{x}, 0.8, 0" up="0, 1, 0"/></transform>"#
        )
    };
    let (first, last) = (key("0", "0"), key("0.5", "1"));
    let animation = format!(r#"<animation name="to_world">{first}{last}</animation>"#);
    let folder = Folder::new(&BOX.replace(place, &animation));
    let words = format!("render scene.xml {QUICK} --fps 4 -q");
    folder
        .run(&format!("{words} --frames 1.. -o a.exr"))
        .code(0);
    assert_eq!(
        folder.files(),
        ["a.0001.exr", "a.0002.exr", "a.0003.exr", "scene.xml"]
    );
    assert!(pixels(&folder, "a.0001.exr") != pixels(&folder, "a.0003.exr"));
    folder
        .run(&format!("{words} --frames 4"))
        .code(2)
        .says(&["--frames 4", "3 cameras"]);
}

#[test]
fn frames_that_exist_are_left_on_request() {
    let folder = walk();
    let words = format!("render scene.xml --cameras walk.json {QUICK} -m vpl -o a.exr");
    folder
        .run(&format!("{words} --frames 2"))
        .code(0)
        .says(&["wrote a.0002.exr"]);
    let written = || {
        std::fs::metadata(folder.path("a.0002.exr"))
            .unwrap()
            .modified()
            .unwrap()
    };
    let first = written();
    let ended = folder.run(&format!("{words} --skip-existing")).code(0);
    ended.says(&["wrote a.0001.exr", "wrote a.0003.exr"]);
    assert_eq!(written(), first);
}

#[test]
fn wrong_cameras_and_frames_are_refused() {
    let folder = walk();
    std::fs::write(folder.path("short.json"), "[\n [1, 2, 3]\n]").unwrap();
    let flat = camera_path(&[0.0]).replace("[0, 1, 0, 1]", "[0, 0, 0, 1]");
    std::fs::write(folder.path("flat.json"), flat).unwrap();
    for (words, code, says) in [
        (
            "--cameras short.json",
            3,
            &["short.json:2", "found 3 numbers"][..],
        ),
        ("--cameras flat.json", 3, &["flat.json", "frame 1"]),
        ("--cameras none.json", 4, &["none.json"]),
        (
            "--cameras walk.json --frames 2..4",
            2,
            &["--frames 2..4", "3 cameras"],
        ),
        ("--cameras walk.json --frames 3..2", 2, &["A..B"]),
        ("--cameras walk.json --frames 0", 2, &["A..B"]),
        ("--frames 1..2", 2, &["stands still", "--cameras"]),
        ("--skip-existing", 2, &["--frames"]),
        ("--cameras walk.json --time 3s", 2, &["--time"]),
        ("--cameras walk.json --shard 1/2 -o a.part", 2, &["--shard"]),
        ("--cameras walk.json -o scene.xml", 2, &["scene.xml"]),
    ] {
        let ended = folder.run(&format!("render scene.xml {words} -q"));
        ended.code(code).says(says);
    }
    assert_eq!(
        folder.files(),
        ["flat.json", "scene.xml", "short.json", "walk.json"]
    );
}
