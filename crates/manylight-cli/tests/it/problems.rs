//! Wrong input: one message, the right exit code, no file.

use crate::support::{BOX, Folder};

#[test]
fn usage_errors() {
    let folder = Folder::new(BOX);
    for (words, message) in [
        ("render", "SCENE"),
        ("render scene.xml -m rich-vlp", "'rich-vpl'"),
        ("render scene.xml -m light-cuts", "possible values"),
        ("render scene.xml --pases 3", "'--passes'"),
        ("render scene.xml --strategy some", "invalid value"),
        ("render scene.xml --max-cut 3", "--strategy lightcuts"),
        ("render scene.xml --size 0x4", "WIDTHxHEIGHT"),
        ("render scene.xml --time soon", "60s"),
        (
            "render scene.xml --flux density --placement relaxed",
            "--flux partition",
        ),
        ("render scene.xml -m path -n 5", "--lights"),
        ("render scene.xml --sensor 3", "1 camera"),
        ("render scene.xml --light-units W", "not a glTF scene"),
        ("render scene.xml --environment-scale 2", "--environment"),
        ("render scene.xml -o image.tif", "'.tif'"),
        ("render scene.xml -t 0", "--threads"),
        ("render scene.xml -t 1000000", "from 1 to 1024"),
        ("render scene.xml --memory-limit lots", "8G"),
        (
            "render scene.xml -n 1000000 --memory-limit 1G",
            "--memory-limit is 1.0 GB",
        ),
        ("render scene.xml --size 60000x60000", "are available"),
        ("compare scene.xml", "IMAGE"),
        ("list bsdf", "'bsdfs'"),
        ("rendr scene.xml", "'render'"),
    ] {
        let ended = folder.run(words).code(2).says(&[message]);
        assert_eq!(ended.stdout(), "", "{words}");
    }
    assert_eq!(folder.files(), ["scene.xml"]);
}

#[test]
fn a_missing_scene_is_a_matter_of_the_file_system() {
    let folder = Folder::new(BOX);
    for words in ["render ./scen.xml", "info ./scen.xml", "check ./scen.xml"] {
        folder.run(words).code(4).says(&["scen.xml", "`scene.xml`"]);
    }
    for words in ["render .", "info .", "check ."] {
        folder
            .run(words)
            .code(4)
            .says(&["a folder", "`./scene.xml`"]);
    }
    folder.run("compare a.exr b.exr").code(4).says(&["b.exr"]);
    assert_eq!(folder.files(), ["scene.xml"]);
}

#[test]
fn a_broken_scene_is_shown_at_its_place() {
    let broken = Folder::new(&BOX.replace("</scene>", ""));
    broken.run("render scene.xml").code(3).says(&["scene.xml"]);
    let scene = BOX.replace("\"reflectance\"", "\"reflectence\"");
    let column = scene.lines().nth(11).unwrap().find("reflectence").unwrap() + 1;
    let place = format!("scene.xml:12:{column}]");
    let misspelled = Folder::new(&scene);
    for words in ["render scene.xml", "info scene.xml", "check scene.xml"] {
        misspelled
            .run(words)
            .code(3)
            .says(&[&place, "reflectence", "`reflectance`"]);
    }
    assert_eq!(misspelled.files(), ["scene.xml"]);
}

#[test]
fn check_reports_every_error_at_once() {
    let twice = BOX
        .replace("\"reflectance\"", "\"reflectence\"")
        .replace("\"alpha\"", "\"alfa\"");
    Folder::new(&twice)
        .run("check scene.xml")
        .code(3)
        .says(&["reflectence", "alfa", "2 errors"]);
    Folder::new(BOX)
        .run("check scene.xml")
        .code(0)
        .says(&["0 errors, 0 warnings"]);
}

#[test]
fn outputs_are_checked_before_anything_is_rendered() {
    let folder = Folder::new(BOX);
    folder
        .run("render scene.xml -o good.exr -o none/bad.exr")
        .code(4)
        .says(&["none/bad.exr"]);
    assert_eq!(folder.files(), ["scene.xml"]);
}

#[test]
fn strict_makes_a_warning_an_error() {
    let dark = BOX
        .replace(r#"<emitter type="area">"#, "<!--")
        .replace("</emitter>", "-->");
    let folder = Folder::new(&dark);
    folder
        .run("render scene.xml -m path --passes 1 --strict -o a.exr")
        .code(6)
        .says(&["no emitter"]);
    folder
        .run("check scene.xml --strict")
        .code(6)
        .says(&["no emitter"]);
    assert_eq!(folder.files(), ["scene.xml"]);
    let report = folder
        .run("render scene.xml -m path --passes 1 -o a.exr --json")
        .code(0)
        .json();
    assert!(
        report["warnings"][0]
            .as_str()
            .unwrap()
            .contains("no emitter"),
        "{report}"
    );
}

#[test]
fn a_light_that_photons_miss_is_a_warning_with_its_name() {
    let sky = |scale: f32| {
        let panel = format!(
            r#"<shape type="rectangle" id="sky_panel">
<transform name="to_world"><scale value="{scale}"/><rotate x="1" angle="90"/><translate y="3"/></transform>
<emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>"#
        );
        Folder::new(&BOX.replace("</scene>", &panel))
    };
    for (scale, method, expected) in [
        (3000.0, "rich-vpl", 1),
        (3000.0, "photon-map", 1),
        (3000.0, "path", 0),
        (3.0, "rich-vpl", 0),
    ] {
        let words = format!("render scene.xml -m {method} --passes 1 -o a.exr --json");
        let report = sky(scale).run(&words).code(0).json();
        let warnings = report["warnings"].as_array().unwrap();
        assert_eq!(warnings.len(), expected, "{scale} {method}: {report}");
        for warning in warnings {
            let warning = warning.as_str().unwrap();
            for words in ["photons carry only", "sky_panel", "--method path"] {
                assert!(warning.contains(words), "{warning}");
            }
        }
    }
}

#[test]
fn lost_photons_are_a_warning() {
    let lamp = |scale: f32| {
        let rectangle = |content: &str, transform: &str| {
            format!(
                r#"<shape type="rectangle"><transform name="to_world">{transform}</transform>{content}</shape>"#
            )
        };
        let floor = rectangle("", r#"<rotate x="1" angle="-90"/>"#);
        let light = r#"<emitter type="area"><rgb name="radiance" value="1"/></emitter>"#;
        let above =
            format!(r#"<scale value="{scale}"/><rotate x="1" angle="90"/><translate y="10"/>"#);
        format!(
            r#"<scene version="3.0.0"><sensor type="perspective">
<transform name="to_world"><lookat origin="0, 2, 2" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
{floor}{}</scene>"#,
            rectangle(light, &above)
        )
    };
    for (scale, expected) in [(1e5, 1), (1.0, 0)] {
        let folder = Folder::new(&lamp(scale));
        for (method, expected) in [("rich-vpl", expected), ("photon-map", 0), ("path", 0)] {
            let words =
                format!("render scene.xml -m {method} --size 8x8 --passes 1 -o a.exr --json");
            let report = folder.run(&words).code(0).json();
            let warnings = report["warnings"].as_array().unwrap();
            assert_eq!(warnings.len(), expected, "{scale} {method}: {report}");
            let is_right =
                |w: &serde_json::Value| w.as_str().unwrap().contains("lacks indirect light");
            assert!(warnings.iter().all(is_right), "{report}");
        }
    }
}

#[test]
fn light_that_photons_miss_is_a_warning_that_names_the_emitter() {
    // A camera at a few centimeters of a floor of one kilometer: of the photons of a lamp at a
    // height of 100 m, hardly one arrives there.
    let lamp_at = |height: u32| {
        format!(
            r#"<scene version="3.0.0"><sensor type="perspective">
<transform name="to_world"><lookat origin="0, 0.3, 0.3" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale x="500" z="500"/></transform></shape>
<shape type="sphere"><point name="center" x="0" y="0.04" z="-0.06"/><float name="radius" value="0.04"/></shape>
<shape type="rectangle" id="far_lamp"><transform name="to_world"><rotate x="1" angle="90"/><translate y="{height}"/></transform>
<emitter type="area"><rgb name="radiance" value="1000"/></emitter></shape></scene>"#
        )
    };
    for (height, expected) in [(100, 1), (1, 0)] {
        let folder = Folder::new(&lamp_at(height));
        for (method, expected) in [
            ("rich-vpl", expected),
            ("photon-map", expected),
            ("path", 0),
        ] {
            let words =
                format!("render scene.xml -m {method} --size 8x8 --passes 1 -o a.exr --json");
            let report = folder.run(&words).code(0).json();
            let warnings = report["warnings"].as_array().unwrap();
            assert_eq!(warnings.len(), expected, "{height} {method}: {report}");
            for warning in warnings {
                let text = warning.as_str().unwrap();
                assert!(text.contains("emitter of far_lamp sends"), "{text}");
                assert!(text.contains("it is 100 % of all direct light"), "{text}");
            }
        }
    }
}
