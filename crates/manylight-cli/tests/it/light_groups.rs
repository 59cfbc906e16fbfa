//! Light groups: layers of files, rules, and pictures that are weighed anew.

use crate::support::{BOX, Folder};
use manylight_io::image::{LayeredImage, read_layered_image};

/// The box under its lamp, with the id `key`, and a point light, with the id `fill`, of these
/// intensities.
fn lamps(key: f32, fill: f32) -> String {
    let lamp = r#"<emitter type="area"><rgb name="radiance" value="8, 8, 6"/></emitter>"#;
    let named = format!(
        r#"<emitter type="area" id="key"><rgb name="radiance" value="{}, {}, {}"/></emitter>"#,
        8.0 * key,
        8.0 * key,
        6.0 * key
    );
    let point = format!(
        r#"<emitter type="point" id="fill"><point name="position" x="1" y="1" z="1"/>
            <rgb name="intensity" value="{fill}, {fill}, {}"/></emitter></scene>"#,
        3.0 * fill
    );
    BOX.replace(lamp, &named).replace("</scene>", &point)
}

fn picture(folder: &Folder, name: &str) -> LayeredImage {
    read_layered_image(&folder.path(name)).unwrap()
}

fn group_layers(picture: &LayeredImage) -> Vec<&str> {
    let names = picture.layers.iter().map(|layer| layer.name.as_str());
    names.filter(|name| name.contains("Combined_")).collect()
}

#[test]
fn layers_have_the_names_of_emitters_or_of_rules() {
    let folder = Folder::new(&lamps(1.0, 1.0));
    let layers = |options: &str| -> Vec<String> {
        let words = format!("render scene.xml -m direct --spp 2 -q -o a.exr {options}");
        folder.run(&words).code(0);
        let picture = picture(&folder, "a.exr");
        group_layers(&picture)
            .into_iter()
            .map(str::to_owned)
            .collect()
    };
    assert!(layers("").is_empty());
    let named = [
        "Combined_fill",
        "Combined_key",
        "variance_Combined_fill",
        "variance_Combined_key",
    ];
    assert_eq!(layers("--light-groups"), named);
    let rule = [
        "Combined_lamps",
        "Combined_rest",
        "variance_Combined_lamps",
        "variance_Combined_rest",
    ];
    assert_eq!(layers("--light-group lamps=k*"), rule);
    for option in ["--light-groups", "--aov position"] {
        let words = format!("render scene.xml -m direct --spp 1 {option} -o b.png");
        let lost = folder.run(&words).code(0);
        lost.says(&["warning: ", &option[..5], "add -o b.exr"]);
        let kept = folder.run(&format!("{words} -o b.exr")).code(0);
        assert!(!kept.stderr().contains("warning"), "{}", kept.stderr());
    }
    let blender = layers("--light-groups --aov-names blender");
    assert_eq!(blender[0], "ViewLayer.Combined_fill");
}

#[test]
fn wrong_groups_are_usage_errors() {
    let folder = Folder::new(&lamps(1.0, 1.0));
    let render = |options: &str| {
        folder.run(&format!(
            "render scene.xml -m direct --spp 1 -q -o a.exr {options}"
        ))
    };
    render("--light-group rim=rim*")
        .code(2)
        .says(&["rim=rim*", "key, fill"]);
    render("--light-group a=key --light-group a=fill")
        .code(2)
        .says(&["`a`", "twice"]);
    render("--light-group key").code(2).says(&["NAME=PATTERN"]);
    render("-m aov --light-groups").code(2);
    assert_eq!(folder.files(), ["scene.xml"]);
    let many: String = (0..65)
        .map(|k| format!(r#"<emitter type="point" id="light_{k}"/>"#))
        .collect();
    std::fs::write(
        folder.path("scene.xml"),
        BOX.replace("</scene>", &format!("{many}</scene>")),
    )
    .unwrap();
    render("--light-groups")
        .code(2)
        .says(&["66 light groups", "1 to 64"]);
    render("--light-group points=light_*").code(0);
    folder
        .run("relight a.exr --group rim=2 -o b.png")
        .code(2)
        .says(&["`rim`", "points, rest"]);
    folder
        .run("relight a.exr --group rest=2,x,1 -o b.png")
        .code(2);
    folder.run("relight a.exr --group rest=2 -o b.tif").code(2);
    folder
        .run("relight absent.exr --group rest=2 -o b.png")
        .code(4);
    render("").code(0);
    folder
        .run("relight a.exr --group rest=2 -o b.png")
        .code(2)
        .says(&["no light groups"]);
    assert!(!folder.path("b.png").exists());
}

/// Weighed groups are what a render with other emitters gives: by the variances of both, which are
/// those of independent pixels.
#[test]
fn a_relit_picture_is_that_of_other_emitters() {
    let folder = Folder::new(&lamps(1.0, 1.0));
    let render = |out: &str, seed: u32| {
        let words =
            format!("render scene.xml -m path --spp 256 --seed {seed} -q -o {out} --light-groups");
        folder.run(&words).code(0);
    };
    render("a.exr", 1);
    folder
        .run("relight a.exr -g key=0.25 -g fill=4 -o relit.exr -o relit.png -q")
        .code(0);
    assert!(folder.path("relit.png").exists());
    folder
        .run("relight a.exr -g key=0.25 -o a.exr -q")
        .code(2)
        .says(&["a.exr is the picture with the light groups"]);
    std::fs::write(folder.path("scene.xml"), lamps(0.25, 4.0)).unwrap();
    render("b.exr", 2);
    let [relit, rendered] = ["relit.exr", "b.exr"].map(|name| picture(&folder, name));
    let (mut squares, mut count) = (0.0, 0);
    for channel in ["R", "G", "B"] {
        let values = |picture: &LayeredImage, name: &str| picture.channel(name).unwrap().to_vec();
        let variance = format!("variance.{channel}");
        let (a, b) = (values(&relit, channel), values(&rendered, channel));
        let (var_a, var_b) = (values(&relit, &variance), values(&rendered, &variance));
        for i in 0..a.len() {
            let sigma2 = var_a[i] + var_b[i];
            if sigma2 > 0.0 {
                squares += f64::from((a[i] - b[i]).powi(2) / sigma2);
                count += 1;
            }
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    assert!(
        count > 400 && (0.8..1.25).contains(&rms),
        "rms z = {rms} of {count}"
    );
}
