//! The method `auto`: what it chooses is written, and the same for all parts of a render.

use crate::support::{BOX, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};
use serde_json::Value;

const QUICK: &str = "--lights 16 --photons 2000";

/// Everything but metadata, which holds times.
fn pixels(folder: &Folder, name: &str) -> LayeredImage {
    LayeredImage {
        metadata: Vec::new(),
        ..read_layered_image(&folder.path(name)).unwrap()
    }
}

/// A scene in which path tracing has no noise, and one in which its light comes by a mirror from a
/// small lamp.
fn scenes() -> [String; 2] {
    let depth = r#"name="max_depth" value="4""#;
    let direct = BOX.replace(depth, r#"name="max_depth" value="1""#);
    let mirror = BOX
        .replace(
            r#"<float name="alpha" value="0.2"/>"#,
            r#"<float name="alpha" value="0.01"/>"#,
        )
        .replace(
            r#"<scale value="0.5"/><rotate x="1" angle="90"/><translate y="2"/>"#,
            r#"<scale value="0.01"/><translate y="1" z="-1.5"/>"#,
        );
    [direct, mirror]
}

#[test]
fn the_choice_and_its_figures_are_written() {
    for scene in scenes() {
        let folder = Folder::new(&scene);
        let words = format!("render scene.xml {QUICK} --passes 2 -o a.exr --json");
        let ended = folder.run(&words).code(0).says(&["auto: ", "as rendered"]);
        let report = ended.json();
        assert_eq!(report["method"], "auto");
        let settings = &report["settings"];
        let choice = settings["choice"].as_str().unwrap().to_owned();
        assert!(
            ["path", "rich-vpl", "both"].contains(&choice.as_str()),
            "{choice}"
        );
        for key in ["path", "rich-vpl", "both", "missed_by_path"] {
            assert!(settings["choice_errors"][key].is_number(), "{key}");
        }
        assert_eq!(settings["choice_errors"]["denoised"], false);
        assert!(report["stages"]["choice"].as_f64().unwrap() > 0.0);
        let weights = settings["path_weights"].as_object();
        assert_eq!(weights.is_some(), choice == "both");
        let picture = read_layered_image(&folder.path("a.exr")).unwrap();
        assert_eq!(
            picture.metadata_value("settings.choice"),
            Some(choice.as_str())
        );
        let errors = picture.metadata_value("settings.choice_errors").unwrap();
        let errors: Value = serde_json::from_str(errors).unwrap();
        assert_eq!(errors, settings["choice_errors"]);
    }
}

#[test]
fn the_command_of_an_image_repeats_its_bits() {
    for scene in scenes() {
        let folder = Folder::new(&scene);
        let words = format!("render scene.xml {QUICK} --passes 9 --block 8 -o a.exr -q");
        folder.run(&words).code(0);
        let picture = read_layered_image(&folder.path("a.exr")).unwrap();
        let command = picture.metadata_value("command").unwrap();
        let again = command.strip_prefix("manylight ").unwrap();
        let again = again.replace("--output a.exr", "--output b.exr -q");
        folder.run(&again).code(0);
        assert!(
            pixels(&folder, "a.exr") == pixels(&folder, "b.exr"),
            "{command}"
        );
    }
}

#[test]
fn options_that_are_not_of_the_same_mean_are_refused() {
    let folder = Folder::new(BOX);
    for options in [
        "--strategy lightcuts",
        "--kernel sphere",
        "--flux density",
        "--compensation none",
        "--resampling new",
    ] {
        let words = format!("render scene.xml {options} -o a.exr");
        let option = options.split(' ').next().unwrap();
        folder
            .run(&words)
            .code(2)
            .says(&[option, "`auto`", "--method rich-vpl"]);
        folder
            .run(&format!(
                "{words} -m rich-vpl -n 16 --photons 2000 --passes 1 -q"
            ))
            .code(0);
    }
    assert_eq!(folder.files(), ["a.exr", "scene.xml"]);
}
