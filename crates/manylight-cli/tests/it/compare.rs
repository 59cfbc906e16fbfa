//! `compare` on images with errors computed by hand.

use crate::support::{BOX, Folder};
use manylight_io::image::{ImageLayer, LayeredImage, write_image};

/// 8 x 8 pixels of one value; optionally with variance, and with an emitter in the upper half.
pub(crate) fn write(
    folder: &Folder,
    name: &str,
    value: f32,
    variance: Option<f32>,
    emission: bool,
) {
    let mut layers = vec![layer("", |_| value)];
    layers.extend(variance.map(|v| layer("variance", |_| v)));
    if emission {
        layers.push(layer("emission", |i| if i < 32 { 1.0 } else { 0.0 }));
    }
    let picture = LayeredImage {
        width: 8,
        height: 8,
        layers,
        ..LayeredImage::default()
    };
    write_image(&folder.path(name), &picture, 0.0).unwrap();
}

fn layer(name: &str, value: impl Fn(usize) -> f32) -> ImageLayer {
    let prefix = if name.is_empty() {
        String::new()
    } else {
        format!("{name}.")
    };
    let channel = |c: &str| (format!("{prefix}{c}"), (0..64).map(&value).collect());
    ImageLayer {
        name: name.into(),
        channels: ["R", "G", "B"].map(channel).into(),
    }
}

fn assert_close(value: &serde_json::Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!(
        (value - expected).abs() <= 1e-6 * expected.abs(),
        "{value} is not {expected}"
    );
}

#[test]
fn known_figures() {
    let folder = Folder::new(BOX);
    write(&folder, "r.exr", 2.0, Some(0.5), false);
    write(&folder, "a.exr", 2.5, Some(1.5), true);
    write(&folder, "b.pfm", 1.0, None, false);
    let report = folder
        .run("compare a.exr b.pfm r.exr --json")
        .code(0)
        .json();
    let a = &report["images"][0];
    assert_close(&a["mse"], 0.25);
    assert_close(&a["relmse"], 0.25 / (4.0 + 0.04));
    assert_close(&a["mape"], 0.25);
    assert_close(&a["smape"], 0.5 / 4.5);
    assert_close(&a["psnr"], 10.0 * 16_f64.log10());
    assert_close(&a["ratio_of_means"][1], 1.25);
    assert_close(&a["noise_floor"]["mse"], 2.0);
    // One block: z = 0.5 / sqrt((1.5 + 0.5) / 64) = 2.83.
    assert_close(&a["blocks"]["mean"], 0.5 * 32_f64.sqrt());
    assert_eq!(a["blocks"]["share_beyond_3"], 0.0);
    assert_eq!(a["without_emitters"]["pixels"], 32);
    let b = &report["images"][1];
    assert_close(&b["ratio_of_means"][0], 0.5);
    assert!(b.get("blocks").is_none() && b.get("without_emitters").is_none());
}

#[test]
fn layers_are_compared_by_name() {
    let folder = Folder::new(BOX);
    write(&folder, "r.exr", 2.0, Some(0.5), false);
    write(&folder, "a.exr", 2.5, Some(1.0), false);
    let report = folder
        .run("compare a.exr r.exr --layer variance --json")
        .code(0)
        .json();
    assert_eq!(report["layer"], "variance");
    let a = &report["images"][0];
    assert_close(&a["ratio_of_means"][0], 2.0);
    // The same in every pixel.
    for quantile in ["median", "p99", "p99_9"] {
        assert_close(&a["pixel_error"][quantile], 1.0 / 1.01_f64.sqrt());
    }
    let message = folder
        .run("compare a.exr r.exr --layer caustics")
        .code(2)
        .stderr();
    assert!(message.contains("no layer `caustics`"), "{message}");
}

#[test]
fn layers_of_blender_are_found_by_the_ends_of_their_names() {
    let folder = Folder::new(BOX);
    write(&folder, "plain.exr", 2.0, Some(0.5), false);
    let named = |name: &str, layers: &[(&str, f32)]| {
        let layers = layers.iter().map(|(name, value)| layer(name, |_| *value));
        let picture = LayeredImage {
            width: 8,
            height: 8,
            layers: layers.collect(),
            ..LayeredImage::default()
        };
        write_image(&folder.path(name), &picture, 0.0).unwrap();
    };
    let one = [
        ("ViewLayer.Combined", 3.0),
        ("ViewLayer.DiffCol", 4.0),
        ("ViewLayer.variance", 0.5),
    ];
    named("blender.exr", &one);
    let ratio = |line: &str| folder.run(line).code(0).json()["images"][0].clone();
    for layer in ["", " --layer Combined", " --layer ViewLayer.Combined"] {
        let image = ratio(&format!("compare blender.exr plain.exr --json{layer}"));
        assert_close(&image["ratio_of_means"][0], 1.5);
        // Both have variances.
        assert_close(&image["noise_floor"]["mse"], 1.0);
    }
    named(
        "more.exr",
        &[("A.DiffCol", 2.0), ("A.Combined", 1.0), ("B.Combined", 1.0)],
    );
    let image = ratio("compare blender.exr more.exr --json --layer DiffCol");
    assert_close(&image["ratio_of_means"][0], 2.0);
    for line in [
        "compare more.exr plain.exr",
        "compare more.exr plain.exr --layer Combined",
    ] {
        let ended = folder.run(line);
        ended
            .code(2)
            .says(&["more.exr", "A.Combined, B.Combined", "--layer"]);
    }
}

#[test]
fn the_table_names_every_image() {
    let folder = Folder::new(BOX);
    write(&folder, "r.exr", 2.0, None, false);
    write(&folder, "a.exr", 2.0, None, false);
    let text = folder.run("compare a.exr a.exr r.exr").code(0).stdout();
    for word in [
        "a.exr",
        "r.exr",
        "relMSE",
        "SMAPE",
        "PSNR (dB)",
        "ratio of means",
        "inf",
    ] {
        assert!(text.contains(word), "{word} is missing in:\n{text}");
    }
}

#[test]
fn a_page_shows_every_image() {
    let folder = Folder::new(BOX);
    write(&folder, "r.exr", 2.0, None, false);
    write(&folder, "a.exr", 1.0, None, false);
    write(&folder, "b.exr", 2.5, None, false);
    folder
        .run("compare a.exr b.exr r.exr --html page.html")
        .code(0);
    let page = std::fs::read_to_string(folder.path("page.html")).unwrap();
    for words in ["\"a.exr\"", "\"b.exr\"", "\"r.exr\"", "HDR-FLIP"] {
        assert!(page.contains(words), "{words}");
    }
    let ended = folder.run("compare a.exr r.exr --html none/page.html");
    ended.code(4).says(&["none/page.html"]);
}

#[test]
fn images_of_different_sizes_are_refused() {
    let folder = Folder::new(BOX);
    write(&folder, "a.exr", 1.0, None, false);
    folder
        .run("render scene.xml -m aov --passes 1 -o r.exr")
        .code(0);
    folder
        .run("compare a.exr r.exr")
        .code(2)
        .says(&["8x8", "16x12"]);
}

#[test]
fn what_is_no_image_is_refused() {
    let folder = Folder::new(BOX);
    write(&folder, "a.exr", 1.0, None, false);
    std::fs::write(folder.path("b.exr"), "not an image").unwrap();
    folder.run("compare a.exr b.exr").code(4).says(&["b.exr"]);
}
