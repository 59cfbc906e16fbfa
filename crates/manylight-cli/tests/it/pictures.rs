//! Layers, windows, metadata and views of the pictures that `render` writes.

use crate::support::{BOX, Folder};
use manylight_io::image::{ImageWindow, LayeredImage, Transfer, read_image, read_layered_image};

fn names(picture: &LayeredImage) -> Vec<&str> {
    picture
        .layers
        .iter()
        .map(|layer| layer.name.as_str())
        .collect()
}

fn exr(folder: &Folder, options: &str) -> LayeredImage {
    let words = format!("render scene.xml --passes 4 -o a.exr {options}");
    folder.run(&words).code(0);
    read_layered_image(&folder.path("a.exr")).unwrap()
}

#[test]
fn mattes_name_what_covers_the_pixels() {
    let folder = Folder::new(&BOX.replacen(
        "<shape type=\"rectangle\">",
        "<shape type=\"rectangle\" id=\"floor\">",
        1,
    ));
    let picture = exr(&folder, "-m aov");
    for layer in [
        "position",
        "CryptoObject00",
        "CryptoObject02",
        "CryptoMaterial00",
    ] {
        assert!(names(&picture).contains(&layer), "{layer}");
    }
    let manifest = |matte: &str| {
        let key = picture
            .metadata
            .iter()
            .find(|(_, value)| value == matte)
            .unwrap();
        let key = key.0.replace("/name", "/manifest");
        picture.metadata_value(&key).unwrap().to_owned()
    };
    for name in ["\"floor\"", "\"rectangle\""] {
        assert!(manifest("CryptoObject").contains(name), "{name}");
    }
    assert!(manifest("CryptoMaterial").contains("\"metal\""));
    let channel = |name: &str| picture.channel(name).unwrap();
    let alpha = channel("A");
    assert!(alpha[0] < alpha[11 * 16 + 8], "the box is open above");
    for (i, alpha) in alpha.iter().enumerate() {
        let levels = (0..3).flat_map(|n| ["g", "a"].map(|c| format!("CryptoObject0{n}.{c}")));
        let sum: f32 = levels.map(|name| channel(&name)[i]).sum();
        assert!(
            (sum - alpha).abs() < 1e-6,
            "pixel {i}: alpha {alpha}, coverage {sum}"
        );
        assert_eq!(
            channel("CryptoObject00.r")[i] == 0.0,
            *alpha == 0.0,
            "pixel {i}"
        );
    }
}

#[test]
fn layers_are_recorded_on_request() {
    let folder = Folder::new(BOX);
    let plain = exr(&folder, "-m path");
    assert!(plain.channel("A").is_some());
    assert!(
        !names(&plain)
            .iter()
            .any(|name| name.starts_with("Crypto") || *name == "position")
    );
    let more = exr(&folder, "-m path --aov position,material");
    assert!(names(&more).contains(&"position") && names(&more).contains(&"CryptoMaterial00"));
    assert!(!names(&more).contains(&"CryptoObject00"));
    for layer in &plain.layers {
        for (channel, values) in &layer.channels {
            assert_eq!(more.channel(channel), Some(values.as_slice()), "{channel}");
        }
    }
    let refused = folder.run("render scene.xml -m light-trace --aov object -o b.exr");
    refused.code(2);
    folder.run("render scene.xml --aov depth -o b.exr").code(2);
}

#[test]
fn blender_finds_its_names() {
    let folder = Folder::new(BOX);
    folder
        .run("render scene.xml -m aov --passes 1 --aov-names blender -o a.exr -o a.pfm")
        .code(0);
    let picture = read_layered_image(&folder.path("a.exr")).unwrap();
    for channel in [
        "ViewLayer.Combined.A",
        "ViewLayer.Depth.Z",
        "ViewLayer.Normal.X",
        "ViewLayer.Position.Y",
        "ViewLayer.Denoising Albedo.R",
        "ViewLayer.CryptoObject00.r",
    ] {
        assert!(picture.channel(channel).is_some(), "{channel}");
    }
    // Of the name `ViewLayer.CryptoObject`, as in files of Blender.
    let key = "cryptomatte/542cafa/name";
    assert_eq!(picture.metadata_value(key), Some("ViewLayer.CryptoObject"));
    assert!(
        picture
            .layers
            .iter()
            .all(|layer| layer.name.starts_with("ViewLayer."))
    );
}

#[test]
fn a_crop_keeps_its_place_and_its_values() {
    let folder = Folder::new(BOX);
    let crop = exr(&folder, "-m aov --crop 0.5,1,0.25,0.75");
    let window = ImageWindow {
        full_size: [16, 12],
        offset: [8, 3],
    };
    assert_eq!((crop.width, crop.height, crop.window), (8, 6, Some(window)));
    assert_eq!(exr(&folder, "-m aov").window, None);
}

#[test]
fn metadata_says_where_a_picture_comes_from() {
    let folder = Folder::new(BOX);
    let digest = |folder: &Folder| {
        let picture = exr(folder, "-m aov");
        assert_eq!(
            picture.metadata_value("colorInteropID"),
            Some("lin_rec709_scene")
        );
        assert_eq!(picture.metadata_value("samples"), Some("4"));
        assert_eq!(
            picture.metadata_value("capDate").unwrap().len(),
            "2026:01:31 12:00:00".len()
        );
        picture.metadata_value("scene.sha256").unwrap().to_owned()
    };
    let first = digest(&folder);
    assert_eq!(first.len(), 64);
    assert_eq!(first, digest(&Folder::new(BOX)), "another folder");
    assert_ne!(
        first,
        digest(&Folder::new(&format!("{BOX}\n"))),
        "another scene"
    );
}

#[test]
fn views_change_pictures_of_8_bits_alone() {
    let folder = Folder::new(BOX);
    let render = |view: &str| {
        let words = format!(
            "render scene.xml -m direct --passes 2 -o {view}.png -o {view}.pfm --view {view}"
        );
        folder.run(&words).code(0);
        let read = |extension| {
            read_image(&folder.path(&format!("{view}.{extension}")), Transfer::Raw).unwrap()
        };
        (read("png"), read("pfm"))
    };
    let (standard, linear) = render("standard");
    for view in ["neutral", "agx"] {
        let (png, pfm) = render(view);
        assert_eq!(pfm, linear);
        assert_ne!(png, standard, "{view}");
    }
    folder
        .run("render scene.xml --view filmic -o a.png")
        .code(2);
}
