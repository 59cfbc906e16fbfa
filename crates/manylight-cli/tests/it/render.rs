//! The files and the report of `render`.

use crate::support::{BOX, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};
use serde_json::Value;

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

#[test]
fn the_report_has_the_keys_of_the_contract() {
    let folder = Folder::new(BOX);
    let ended = folder.run(
        "render scene.xml -m rich-vpl --passes 2 -n 16 --photons 2000 -o a.exr -o a.png --json",
    );
    let report = ended.code(0).json();
    assert_eq!(
        keys(&report),
        [
            "schema",
            "version",
            "scene",
            "scene_sha256",
            "method",
            "settings",
            "stages",
            "counts",
            "error",
            "rates",
            "memory",
            "clamped_share",
            "dropped_samples",
            "warnings",
            "outputs"
        ]
    );
    for key in ["load", "build", "photons", "shade", "write"] {
        assert!(report["stages"][key].as_f64().unwrap() >= 0.0, "{key}");
    }
    let counts = &report["counts"];
    assert_eq!(
        (&counts["pixels"], &counts["passes"]),
        (&Value::from(192), &Value::from(2))
    );
    assert_eq!(counts["photons"], 4000);
    // Two sets of four times 16 lights, and additional lights for unassigned photons.
    assert!(
        (128..160).contains(&counts["lights"].as_u64().unwrap()),
        "{counts}"
    );
    assert!(counts["connections"].as_u64().unwrap() > 0);
    assert!(counts["shadow_rays"].as_u64().unwrap() > 0);
    for key in [
        "paths_per_second",
        "photons_per_second",
        "connections_per_second",
    ] {
        assert!(report["rates"][key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(report["memory"]["bytes_per_light"].as_f64().unwrap() > 0.0);
    let settings = &report["settings"];
    assert_eq!(settings["lights"], 16);
    assert_eq!(settings["placement"], "importance");
    assert_eq!(settings["max_depth"], 4);
    assert_eq!(report["outputs"], serde_json::json!(["a.exr", "a.png"]));
    assert_eq!(report["method"], "rich-vpl");
}

#[test]
fn the_default_outputs_are_named_after_the_folder_of_the_scene() {
    let folder = Folder::new(BOX);
    std::fs::create_dir(folder.path("room")).unwrap();
    std::fs::rename(folder.path("scene.xml"), folder.path("room/scene.xml")).unwrap();
    let ended = folder
        .run("render room/scene.xml -m path --passes 1")
        .code(0);
    assert_eq!(ended.stdout(), "");
    ended.says(&["room.exr", "room.png", "next: manylight"]);
    assert_eq!(folder.files(), ["room", "room.exr", "room.png"]);
}

#[test]
fn an_image_carries_its_layers_and_its_settings() {
    let folder = Folder::new(BOX);
    folder
        .run("render scene.xml -m path --passes 4 --seed 7 -o a.exr -q")
        .code(0);
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    for layer in [
        "",
        "variance.",
        "direct.",
        "virtual_lights.",
        "caustics.",
        "emission.",
        "albedo.",
    ] {
        for channel in ["R", "G", "B"] {
            let values = picture.channel(&format!("{layer}{channel}"));
            assert!(
                values.unwrap().iter().all(|v| v.is_finite()),
                "{layer}{channel}"
            );
        }
    }
    for channel in ["normal.X", "normal.Y", "normal.Z", "depth.Z"] {
        assert!(picture.channel(channel).is_some(), "{channel}");
    }
    let value = |name| {
        picture
            .metadata_value(name)
            .unwrap_or_else(|| panic!("{name}"))
    };
    assert_eq!((value("scene"), value("method")), ("scene.xml", "path"));
    assert_eq!((value("passes"), value("settings.seed")), ("4", "7"));
    assert!(
        value("command")
            .starts_with("manylight render scene.xml --method path --passes 4 --seed 7")
    );
}

#[test]
fn quiet_says_nothing() {
    let folder = Folder::new(BOX);
    let ended = folder
        .run("render scene.xml -m direct --passes 1 -o a.pfm -q")
        .code(0);
    assert_eq!(
        (ended.stdout(), ended.stderr()),
        (String::new(), String::new())
    );
}

#[test]
fn size_crop_and_filter_are_those_asked_for() {
    let folder = Folder::new(BOX);
    folder
        .run("render scene.xml -m aov --passes 1 --size 32x24 --crop 0.5,1,0,0.25 -o a.exr")
        .code(0);
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (16, 6));
    assert_eq!(picture.metadata_value("settings.size"), Some("[32,24]"));
}

/// Everything but metadata, which holds times.
fn pixels(folder: &Folder, name: &str) -> LayeredImage {
    LayeredImage {
        metadata: Vec::new(),
        ..read_layered_image(&folder.path(name)).unwrap()
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let folder = Folder::new(BOX);
    for method in [
        "path",
        "light-trace",
        "rich-vpl -n 32 --photons 3000",
        "auto -n 32 --photons 3000",
    ] {
        for threads in [1, 2, 5] {
            let words =
                format!("render scene.xml -m {method} --passes 2 -t {threads} -o {threads}.exr");
            folder.run(&words).code(0);
        }
        let one = pixels(&folder, "1.exr");
        assert!(
            one.channel("R").unwrap().iter().any(|&v| v > 0.0),
            "{method}"
        );
        assert!(
            one == pixels(&folder, "2.exr") && one == pixels(&folder, "5.exr"),
            "{method}"
        );
    }
}

#[test]
fn a_picture_is_the_same_with_and_without_a_file_of_layers() {
    let folder = Folder::new(BOX);
    for method in [
        "path",
        "rich-vpl -n 32 --photons 3000",
        "photon-map --photons 3000",
    ] {
        for outputs in ["-o alone.pfm", "-o beside.pfm -o layers.exr"] {
            let words = format!("render scene.xml -m {method} --passes 2 {outputs}");
            folder.run(&words).code(0);
        }
        let bytes = |name| std::fs::read(folder.path(name)).unwrap();
        assert!(bytes("alone.pfm") == bytes("beside.pfm"), "{method}");
        let layers = read_layered_image(&folder.path("layers.exr")).unwrap();
        assert!(layers.channel("direct.R").is_some(), "{method}");
    }
}

#[test]
fn the_command_in_the_metadata_makes_the_same_image() {
    let folder = Folder::new(BOX);
    let options = "-m vpl -n 20 --photons 1000 --clamp 3 --max-depth -1 --crop 0,0.5,0,1 --seed 3";
    folder
        .run(&format!("render scene.xml {options} --passes 2 -o a.exr"))
        .code(0);
    let first = read_layered_image(&folder.path("a.exr")).unwrap();
    let command = first
        .metadata_value("command")
        .unwrap()
        .replace("a.exr", "b.exr");
    folder
        .run(command.strip_prefix("manylight ").unwrap())
        .code(0);
    assert!(
        pixels(&folder, "a.exr") == pixels(&folder, "b.exr"),
        "{command}"
    );
}

#[test]
fn progress_as_json_lines() {
    let folder = Folder::new(BOX);
    let ended = folder
        .run("render scene.xml -m path --passes 3 --progress json -q -o a.exr")
        .code(0);
    let events: Vec<Value> = ended
        .stderr()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let last = events.last().unwrap();
    assert_eq!(
        (&last["event"], &last["passes_done"]),
        (&Value::from("progress"), &Value::from(3))
    );
    assert_eq!(last["fraction"], 1.0);
}

#[test]
fn all_camera_paths_of_virtual_lights_are_counted() {
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m rich-vpl -n 16 --photons 2000 --passes 2 -o a.png --json -q";
    let report = folder.run(words).code(0).json();
    // Four paths of a pixel gather; each has three beside it that look for emitters alone.
    assert_eq!(report["counts"]["camera_paths"], 2 * 192 * 16);
}
