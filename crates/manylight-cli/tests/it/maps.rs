//! The files of `maps`.

use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;

const FILES: [&str; 6] = [
    "importance.png",
    "maps.exr",
    "placement.png",
    "product.png",
    "radiance.png",
    "relaxed.png",
];

fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn all_files_are_written_and_named() {
    let folder = Folder::new(BOX);
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/glossy-room/scene.xml"
    );
    let ended = folder.run(&format!(
        "maps {scene} -o deep/figures --size 32x18 -n 100 --photons 20000 --seed 3"
    ));
    let ended = ended.code(0).says(&FILES).says(&["1/m²", "lights"]);
    assert_eq!(ended.stdout(), "");
    let made = folder.path("deep/figures");
    assert_eq!(names(&made), FILES);
    let picture = read_layered_image(&made.join("maps.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (32, 18));
    for name in ["importance.Y", "radiance.Y", "radiance.R", "product.Y"] {
        let values = picture.channel(name).unwrap();
        let lit = values.iter().filter(|&&v| v > 0.0).count();
        assert!(lit > 500 && values.iter().all(|v| v.is_finite()), "{name}");
    }
    assert_eq!(picture.metadata_value("settings.lights"), Some("100"));
    let scale = picture.metadata_value("scale.product").unwrap();
    assert!(scale.contains("W/m⁴"), "{scale}");
    let [dots, relaxed] =
        ["placement.png", "relaxed.png"].map(|name| read_layered_image(&made.join(name)).unwrap());
    let is_dot = |i: &usize| dots.channel("R").unwrap()[*i] > 0.5;
    assert!((0..32 * 18).any(|i| is_dot(&i)));
    assert!(dots != relaxed);
    // Again, with nothing to say and over what is there.
    let quiet = folder.run("maps scene.xml -o deep/figures -n 10 --photons 1000 -q");
    assert_eq!(quiet.code(0).stderr(), "");
    assert_eq!(names(&made), FILES);
}

#[test]
fn what_cannot_be_shown_is_said_and_nothing_is_written() {
    let folder = Folder::new(BOX);
    for (words, code, message) in [
        ("maps scene.xml -o d -m path", 2, "rich-vpl"),
        ("maps scene.xml -o d -m photon-map", 2, "no virtual lights"),
        ("maps scene.xml", 2, "--output"),
        ("maps scene.xml -o d --sensor 3", 2, "1 camera"),
        ("maps scen.xml -o d", 4, "scen.xml"),
        ("maps scene.xml -o scene.xml", 4, "scene.xml"),
        ("maps scene.xml -o d --size 60000x60000", 2, "are available"),
    ] {
        folder.run(words).code(code).says(&[message]);
    }
    assert_eq!(folder.files(), ["scene.xml"]);
    let broken = Folder::new(&BOX.replace("</scene>", ""));
    broken.run("maps scene.xml -o d").code(3);
    assert_eq!(broken.files(), ["scene.xml"]);
}
