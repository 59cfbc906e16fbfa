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

#[test]
fn frames_do_not_replace_files_of_the_scene() {
    let folder = walk();
    let (scene, part) = (folder.path("scene.xml"), folder.path("room.0002.png"));
    std::fs::rename(&scene, &part).unwrap();
    let include = r#"<scene version="3.0.0"><include filename="room.0002.png"/></scene>"#;
    std::fs::write(scene, include).unwrap();
    folder
        .run("render scene.xml --cameras walk.json -o room.png -q")
        .code(2)
        .says(&["room.0002.png is a file of the scene"]);
    assert_eq!(std::fs::read_to_string(part).unwrap(), BOX);
}

/// Frames of a camera that moves in small steps.
fn steps() -> Folder {
    let folder = Folder::new(BOX);
    let places = [-0.04, -0.02, 0.0, 0.02, 0.04];
    std::fs::write(folder.path("walk.json"), camera_path(&places)).unwrap();
    folder
}

#[test]
fn steady_frames_differ_less_from_each_other() {
    let folder = steps();
    let words = "render scene.xml --cameras walk.json -m path --spp 4 --aov position";
    let ended = folder.run(&format!("{words} -o walk-##.exr")).code(0);
    ended.says(&["frame 3: error of a pixel: ", "wrote walk-03.exr"]);
    let report = folder
        .run("steady walk-##.exr -o steady-##.exr -o steady.png --json")
        .code(0)
        .says(&["wrote steady-03.exr", "wrote steady.0005.png"])
        .json();
    assert_eq!(report["frames"], serde_json::json!([1, 2, 3, 4, 5]));
    assert_eq!(report["outputs"].as_array().unwrap().len(), 10);
    let picture = |name: &str| read_layered_image(&folder.path(name)).unwrap();
    let change = |name: &str| -> f32 {
        let frames = [2, 3, 4].map(|k| picture(&format!("{name}-{k:02}.exr")));
        // Below the lamp.
        let floor = |frame| LayeredImage::channel(frame, "G").unwrap()[6 * 16..].to_vec();
        let planes = frames.each_ref().map(floor);
        let squares = |pair: &[Vec<f32>]| -> f32 {
            let both = pair[0].iter().zip(&pair[1]);
            both.map(|(a, b)| (a - b).powi(2)).sum()
        };
        planes.windows(2).map(squares).sum()
    };
    let (before, after) = (change("walk"), change("steady"));
    assert!(after < 0.4 * before, "{after} {before}");
    let sum = |name: &str| picture(name).channel("G").unwrap().iter().sum::<f32>();
    let mean = (1..=5)
        .map(|k| sum(&format!("walk-{k:02}.exr")))
        .sum::<f32>()
        / 5.0;
    let ratio = sum("steady-03.exr") / mean;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    let (walk, steady) = (picture("walk-03.exr"), picture("steady-03.exr"));
    assert_eq!(steady.channel("position.X"), walk.channel("position.X"));
    assert_eq!(steady.channel("variance.R"), None);
    assert_eq!(steady.metadata_value("steady.frames"), Some("1..5"));
    assert_eq!(steady.camera, walk.camera);
}

#[test]
fn frames_that_cannot_be_averaged_are_refused() {
    let folder = steps();
    let words = "render scene.xml --cameras walk.json -m direct --spp 1 -q";
    let render = |options: &str| folder.run(&format!("{words} {options}")).code(0);
    render("-o plain-#.exr");
    render("--aov position --frames 1..2 -o gap-#.exr");
    render("--aov position --frames 4 -o gap-#.exr");
    render("--aov position --frames 1 -o size-#.exr");
    render("--aov position --frames 2 --size 8x6 -o size-#.exr");
    let before = folder.files();
    for (words, code, says) in [
        ("none-#.exr -o a.png", 2, &["none-1.exr"][..]),
        ("nowhere/a-#.exr -o a.png", 4, &["nowhere"]),
        (
            "plain-#.exr -o a.png",
            2,
            &["plain-1.exr", "positions", "--aov position"],
        ),
        ("gap-#.exr -o a.png", 2, &["gap-3.exr is missing"]),
        ("size-#.exr -o a.png", 2, &["size-2.exr", "8x6", "16x12"]),
        (
            "plain-#.exr -o plain-#.exr",
            2,
            &["plain-1.exr", "--output"],
        ),
        (
            "plain-#.exr -o ./plain-#.exr",
            2,
            &["plain-1.exr is a frame"],
        ),
        ("plain-#.exr -o a.txt", 2, &["a.txt"]),
    ] {
        folder.run(&format!("steady {words}")).code(code).says(says);
    }
    assert_eq!(folder.files(), before);
}
