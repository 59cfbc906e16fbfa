//! `--denoise`. Tests that need Open Image Denoise print a note and pass where it is not installed.

use crate::support::{BOX, Ended, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};

const SHORT: &str = "--denoise oidn --passes 2 -o a.exr";

/// The result of a render that denoises; `None` with a note where the library is not installed.
#[allow(clippy::print_stdout, reason = "a note beside the test")]
fn denoised(folder: &Folder, words: &str) -> Option<Ended> {
    let output = folder.command(words).output().unwrap();
    if output.status.code() == Some(5) {
        println!("skipped: {}", String::from_utf8_lossy(&output.stderr));
        return None;
    }
    Some(Ended::from(output).code(0))
}

fn picture(folder: &Folder) -> LayeredImage {
    read_layered_image(&folder.path("a.exr")).unwrap()
}

#[test]
fn a_library_that_cannot_be_loaded_ends_the_program_before_it_renders() {
    let folder = Folder::new(BOX);
    std::fs::write(folder.path("no-library.so"), "no library").unwrap();
    for file in ["./missing.so", "./no-library.so"] {
        let words = format!("render scene.xml {SHORT} --time 1h --oidn-lib {file}");
        let ended = folder.run(&words).code(5);
        let ended = ended.says(&[file, "pip install pyoidn", "OIDN_DIR", "--oidn-lib"]);
        assert_eq!(ended.stdout(), "");
    }
    assert_eq!(folder.files(), ["no-library.so", "scene.xml"]);
}

#[test]
fn the_message_names_all_places() {
    let folder = Folder::new(BOX);
    let mut command = folder.command(&format!("render scene.xml {SHORT}"));
    command
        .env("OIDN_DIR", folder.path(""))
        .env_remove("VIRTUAL_ENV")
        .env_remove("LD_LIBRARY_PATH")
        .env("PATH", folder.path(""));
    let ended = Ended::from(command.output().unwrap());
    // The library may be installed for the whole system.
    if folder.files() == ["scene.xml"] {
        ended.code(5).says(&["OIDN_DIR=", "pyoidn", "system"]);
    }
}

#[test]
fn aov_is_not_denoised() {
    let folder = Folder::new(BOX);
    folder
        .run(&format!("render scene.xml -m aov {SHORT}"))
        .code(2)
        .says(&["aov", "--method"]);
}

#[test]
fn the_file_holds_the_denoised_and_the_noisy_image() {
    let folder = Folder::new(BOX);
    let words = format!("render scene.xml -m path {SHORT} -o a.png --json");
    let Some(ended) = denoised(&folder, &words) else {
        return;
    };
    let report = ended.json();
    assert_eq!(report["settings"]["denoise"], "oidn");
    let version = report["settings"]["oidn_version"].as_str().unwrap();
    assert!(version.starts_with("2."), "{version}");
    for stage in ["features", "denoise"] {
        assert!(report["stages"][stage].as_f64().unwrap() > 0.0, "{stage}");
    }
    let picture = picture(&folder);
    let channel = |name: &str| picture.channel(name).unwrap_or_else(|| panic!("{name}"));
    assert_ne!(channel("R"), channel("noisy.R"));
    assert!(channel("R").iter().all(|v| v.is_finite()));
    for (i, noisy) in channel("noisy.G").iter().enumerate() {
        let layers = ["emission", "direct", "virtual_lights", "caustics"];
        let sum: f32 = layers
            .map(|layer| channel(&format!("{layer}.G"))[i])
            .iter()
            .sum();
        assert!((noisy - sum).abs() <= 1e-4 * sum, "{noisy} {sum}");
    }
    assert!(picture.channel("variance.R").is_some());
    let value = |name: &str| picture.metadata_value(name).unwrap();
    assert_eq!(
        (value("settings.denoise"), value("settings.oidn_version")),
        ("oidn", version)
    );
    assert!(value("command").contains("--denoise oidn"));
    assert!(value("seconds.denoise").parse::<f64>().unwrap() > 0.0);
}

#[test]
fn a_denoised_image_has_no_z_scores() {
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --passes 4 -o r.exr --seed 5";
    folder.run(words).code(0);
    if denoised(&folder, &format!("render scene.xml -m path {SHORT}")).is_none() {
        return;
    }
    let compare = |words: &str| folder.run(words).code(0).json();
    let beauty = compare("compare a.exr r.exr --json");
    assert!(beauty["images"][0]["relmse"].as_f64().is_some(), "{beauty}");
    assert!(beauty["images"][0].get("blocks").is_none(), "{beauty}");
    assert!(beauty["images"][0].get("noise_floor").is_none(), "{beauty}");
}

#[test]
fn every_method_and_every_size_is_denoised() {
    let folder = Folder::new(BOX);
    for options in [
        "-m light-trace --passes 2",
        "-m direct --crop 0.25,0.5,0,0.5 --passes 2",
        "-m photon-map --photons 500 --passes 2",
        "-n 8 --photons 500 --passes 2",
        "-m vpl -n 8 --photons 500 --passes 1",
        "-m path --size 1x1 --passes 2",
        "-m path --size 3x1 --filter gaussian --passes 2",
    ] {
        let words = format!("render scene.xml --denoise oidn -o a.exr {options} -q");
        let Some(_) = denoised(&folder, &words) else {
            return;
        };
        let picture = picture(&folder);
        let red = picture.channel("R").unwrap();
        assert!(
            red.iter().all(|v| v.is_finite() && *v >= 0.0),
            "{options}: {red:?}"
        );
        assert!(picture.channel("noisy.R").is_some(), "{options}");
    }
}

#[test]
fn without_the_option_nothing_changes() {
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --passes 1 -o a.exr --json";
    let report = folder.run(words).code(0).json();
    assert!(report["settings"]["denoise"].is_null());
    assert!(picture(&folder).channel("noisy.R").is_none());
}

#[test]
fn the_error_of_a_denoised_picture_is_its_own() {
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --size 64x64 --filter box --passes 32 -o a.exr --json -q";
    let Some(ended) = denoised(&folder, &format!("{words} --denoise oidn")) else {
        return;
    };
    let clean = ended.json()["error"]["pixels"].as_f64().unwrap();
    let bars = picture(&folder).channel("error.G").unwrap().to_vec();
    let noisy = folder.run(words).code(0).json()["error"]["pixels"]
        .as_f64()
        .unwrap();
    assert!(clean < 0.8 * noisy, "{clean} {noisy}");
    let sum = |bars: &[f32]| bars.iter().sum::<f32>();
    assert!(sum(&bars) < sum(picture(&folder).channel("error.G").unwrap()));
    // The limit is that of the denoised picture.
    let words = format!("{words} --target-error {}", 1.2 * clean).replace("--passes 32", "");
    let passes = |options: &str| {
        let report = folder.run(&format!("{words} {options}")).code(0).json();
        report["counts"]["passes"].as_u64().unwrap()
    };
    let (clean, noisy) = (passes("--denoise oidn"), passes(""));
    assert!(clean < noisy, "{clean} {noisy}");
}

#[test]
fn light_groups_are_denoised_and_sum_to_the_picture() {
    let point = r#"<emitter type="point" id="fill"><point name="position" x="1" y="1" z="1"/>
        <rgb name="intensity" value="3, 3, 5"/></emitter></scene>"#;
    let folder = Folder::new(&BOX.replace("</scene>", point));
    let words = format!("render scene.xml -m path --light-groups {SHORT} -q");
    if denoised(&folder, &words).is_none() {
        return;
    }
    let sums = |picture: &LayeredImage, start: &str| -> Vec<f32> {
        let channel = |group: &str| picture.channel(&format!("{start}Combined_{group}.G"));
        let [fill, lamp] = ["fill", "rectangle_3"].map(|group| channel(group).unwrap());
        fill.iter().zip(lamp).map(|(a, b)| a + b).collect()
    };
    let are_equal = |found: &[f32], expected: &[f32]| {
        let both = found.iter().zip(expected);
        assert!(both.clone().all(|(a, b)| (a - b).abs() <= 1e-4 * b));
    };
    let before = picture(&folder);
    are_equal(&sums(&before, "denoised_"), before.channel("G").unwrap());
    are_equal(&sums(&before, ""), before.channel("noisy.G").unwrap());
    folder
        .run("relight a.exr --group fill=3 -q -o b.exr")
        .code(0);
    let relit = read_layered_image(&folder.path("b.exr")).unwrap();
    are_equal(&sums(&relit, "denoised_"), relit.channel("G").unwrap());
    let fill = |picture: &LayeredImage| picture.channel("denoised_Combined_fill.G").unwrap()[9];
    assert!((fill(&relit) - 3.0 * fill(&before)).abs() <= 1e-4 * fill(&relit));
}

#[test]
fn merged_parts_are_denoised() {
    let folder = Folder::new(BOX);
    let passes = "-m path --passes 64 --block 32 -q";
    for share in [1, 2] {
        let words = format!("render scene.xml {passes} --shard {share}/2 -o {share}.part");
        folder.run(&words).code(0);
    }
    let words = "merge 1.part 2.part --denoise oidn -o a.exr";
    let Some(ended) = denoised(&folder, words) else {
        return;
    };
    ended.says(&["merged 64 passes", "error of a pixel: "]);
    let merged = picture(&folder);
    // 64 passes have the features that a render needs, so that it has the same bits.
    let words = format!("render scene.xml {passes} --denoise oidn -o whole.exr");
    folder.run(&words).code(0);
    let whole = read_layered_image(&folder.path("whole.exr")).unwrap();
    for name in ["R", "noisy.R", "error.R"] {
        assert_eq!(merged.channel(name), whole.channel(name), "{name}");
    }
}
