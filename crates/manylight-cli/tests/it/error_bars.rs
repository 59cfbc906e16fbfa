//! Error bars, the stated error, and `--target-error`.

use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use serde_json::Value;

const PATH: &str = "render scene.xml -m path --size 40x40 --filter box";

#[test]
fn a_render_states_its_error() {
    let folder = Folder::new(BOX);
    let ended = folder
        .run(&format!("{PATH} --passes 16 -o a.exr --json"))
        .code(0);
    let report = ended.json();
    let ended = ended.says(&["error of a pixel: ", "at most", "of 8x8 pixels: "]);
    assert!(!ended.stderr().contains("rough"));
    let error = |key: &str| report["error"][key].as_f64().unwrap();
    assert!(0.0 < error("blocks") && error("blocks") < error("pixels"));
    assert!(error("pixels") < error("pixels_at_most"));
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    let stated: f64 = picture.metadata_value("error").unwrap().parse().unwrap();
    assert!((stated / error("pixels") - 1.0).abs() < 1e-6);
    let bars = |layer: &str| picture.channel(&format!("{layer}.G")).unwrap();
    assert!(
        bars("error")
            .iter()
            .all(|bar| *bar >= 0.0 && bar.is_finite())
    );
    let blocks = bars("block_error");
    assert_eq!((blocks[0], blocks[7]), (blocks[41], blocks[7 * 40]));
    folder
        .run(&format!("{PATH} --passes 4 -o b.exr"))
        .code(0)
        .says(&["rough, from 4 passes"]);
}

#[test]
fn an_unknown_error_is_not_stated() {
    let folder = Folder::new(BOX);
    let ended = folder.run(&format!("{PATH} --passes 1 -o a.exr --json"));
    let report = ended.code(0).json();
    assert_eq!(report["error"], Value::Null);
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    assert!(picture.channel("error.R").is_none() && picture.metadata_value("error").is_none());
}

/// Bars of the truth hold 95 % of a picture with many more passes.
#[test]
fn compare_says_what_is_within_the_bars() {
    let folder = Folder::new(BOX);
    folder
        .run(&format!("{PATH} --passes 16 -o a.exr -q"))
        .code(0);
    folder
        .run(&format!("{PATH} --passes 1024 --seed 5 -o r.exr -q"))
        .code(0);
    let report = folder.run("compare a.exr r.exr --json").code(0).json();
    let within = &report["images"][0]["within_bars"];
    println!("{within}");
    let share = |part: &str| within[part].as_f64().unwrap();
    assert!((0.92..0.98).contains(&share("pixels")), "{within}");
    assert!(share("blocks") > 0.85, "25 blocks: {within}");
    let table = folder.run("compare a.exr r.exr").code(0).stdout();
    assert!(table.contains("within error bars"), "{table}");
    let relmse = report["images"][0]["relmse"].as_f64().unwrap();
    let stated = read_layered_image(&folder.path("a.exr")).unwrap();
    let stated: f64 = stated.metadata_value("error").unwrap().parse().unwrap();
    assert!(
        (0.5..1.5).contains(&(stated / relmse.sqrt())),
        "{stated} {relmse}"
    );
}

#[test]
fn a_render_ends_when_its_error_is_below_the_target() {
    let folder = Folder::new(BOX);
    let run = |target: &str, options: &str| {
        let words = format!("{PATH} --target-error {target} -o a.exr --json -q {options}");
        let report = folder.run(&words).code(0).json();
        let at_most = report["error"]["pixels_at_most"].as_f64().unwrap();
        (at_most, report["counts"]["passes"].as_u64().unwrap())
    };
    let (at_most, coarse) = run("20%", "");
    assert!(at_most <= 0.2, "{at_most}");
    let (at_most, fine) = run("0.1", "");
    assert!(
        at_most <= 0.1 && fine > 2 * coarse,
        "{at_most} {coarse} {fine}"
    );
    let (_, few) = run("1%", "--passes 5");
    assert_eq!(few, 5, "the first limit ends the render");
    folder
        .run(&format!("{PATH} --target-error two -o a.exr"))
        .code(2)
        .says(&["--target-error", "0.02, or 2%"]);
}
