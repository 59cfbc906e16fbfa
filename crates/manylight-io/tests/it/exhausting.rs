//! Small files that would take unbounded time, memory or stack.

use crate::Files;
use manylight::emitters::Emitter;
use manylight::scene::Scene;
use manylight_io::{Diagnostic, LoadOptions, Severity, check_scene, load_scene};
use std::path::PathBuf;

/// The messages of the errors of a file.
fn errors(path: PathBuf) -> Vec<String> {
    check_scene(&path, &LoadOptions::default())
        .into_iter()
        .filter(|problem| problem.severity == Severity::Error)
        .map(|problem| problem.message)
        .collect()
}

/// The problems of a PBRT scene.
fn pbrt_problems(text: &str) -> Vec<Diagnostic> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.pbrt");
    std::fs::write(&path, text).unwrap();
    check_scene(&path, &LoadOptions::default())
}

/// The message with which a scene does not build.
fn build_error(path: PathBuf) -> String {
    let desc = load_scene(&path, &LoadOptions::default()).unwrap().desc;
    Scene::build(desc, 0).unwrap_err().message
}

/// A scene with `count` times the element that includes a file.
fn including(file: &str, count: usize) -> String {
    let include = format!("<include filename=\"{file}\"/>").repeat(count);
    format!("<scene version=\"3.0.0\">{include}</scene>")
}

#[test]
fn a_file_that_includes_itself_is_refused_at_once() {
    let found = errors(Files::new(&including("scene.xml", 3), &[]).scene());
    let circular = found
        .iter()
        .filter(|message| message.contains("includes itself"));
    assert_eq!(circular.count(), 3, "{found:?}");
}

#[test]
fn files_that_include_others_several_times_are_refused() {
    let names: Vec<String> = (0..11).map(|i| format!("{i}.xml")).collect();
    let contents = names[1..].iter().map(|next| including(next, 8));
    let contents: Vec<String> = contents.chain([including("", 0)]).collect();
    let pairs = names.iter().zip(&contents);
    let others: Vec<(&str, &str)> = pairs.map(|(n, c)| (n.as_str(), c.as_str())).collect();
    let found = errors(Files::new(&including("0.xml", 8), &others).scene());
    let expected = "included files and parameters make more than 4194304 bytes from";
    assert!(
        found.iter().any(|message| message.starts_with(expected)),
        "{found:?}"
    );
}

#[test]
fn parameters_that_double_their_text_are_refused() {
    let name = |i: u8| format!("{}{}", (b'a' + i / 26) as char, (b'a' + i % 26) as char);
    let doubled = |i: u8| {
        let [name, before] = [name(i), name(i - 1)];
        format!("<default name=\"{name}\" value=\"${before}${before}\"/>")
    };
    let defaults: String = (1..60).map(doubled).collect();
    let scene = format!(
        "<scene version=\"3.0.0\"><default name=\"aa\" value=\"0123456789\"/>{defaults}</scene>"
    );
    let found = errors(Files::new(&scene, &[]).scene());
    let expected = "included files and parameters make more than 4194304 bytes from";
    assert!(
        found.iter().any(|message| message.starts_with(expected)),
        "{found:?}"
    );
}

#[test]
fn shapes_of_files_that_are_included_again_and_again_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, part] = ["scene.pbrt", "part.pbrt"].map(|name| folder.path().join(name));
    std::fs::write(&part, "Shape \"paraboloid\"\n").unwrap();
    let include = |count: usize| {
        let camera = "Camera \"perspective\"\nWorldBegin\n";
        let include = "Include \"part.pbrt\"\n".repeat(count);
        std::fs::write(&scene, format!("{camera}{include}")).unwrap();
        errors(scene.clone())
    };
    assert_eq!(include(100), [""; 0]);
    let found = include(200);
    let expected = "the shapes make more than 67108864 bytes of triangles from 4051 bytes of text";
    assert_eq!(found, [expected]);
}

#[test]
fn brackets_are_not_nested() {
    let found = pbrt_problems(&format!("Material {}", "[".repeat(100_000)));
    assert_eq!(found[0].message, "found `[`, expected a type in quotes");
}

#[test]
fn of_many_problems_the_first_thousand_are_listed() {
    let found = pbrt_problems(&"Foo Bar\n".repeat(20_000));
    assert_eq!(found.len(), 1001);
    assert_eq!(
        found[1000].message,
        "the scene has at least 40000 errors; the first 1000 are listed"
    );
}

#[test]
fn after_a_thousand_errors_no_files_are_included() {
    let of_xml = errors(Files::new(&including("absent.xml", 3000), &[]).scene());

    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.pbrt");
    std::fs::write(folder.path().join("part.pbrt"), "Foo Bar\n".repeat(100)).unwrap();
    std::fs::write(&scene, "Include \"part.pbrt\"\n".repeat(30)).unwrap();

    for found in [of_xml, errors(scene)] {
        assert!(found.len() >= 1000);
        // At most some errors that do not come from included files.
        let beyond = found.get(1000).map_or("", String::as_str);
        let few = beyond.is_empty() || beyond.starts_with("the scene has at least 100");
        assert!(few, "{beyond}");
    }
}

#[test]
fn wrappers_of_materials_are_bounded() {
    let mut content = String::from("<bsdf type=\"diffuse\" id=\"m0\"/>");
    for i in 0..200 {
        let mask = format!(
            "<bsdf type=\"mask\" id=\"m{}\"><ref id=\"m{i}\"/></bsdf>",
            i + 1
        );
        content.push_str(&mask);
    }
    content.push_str("<shape type=\"sphere\"><ref id=\"m200\"/></shape>");
    let error = build_error(Files::new(&crate::document("3.0.0", &content), &[]).scene());
    assert!(error.ends_with("is nested more than 100 deep"), "{error}");
}

#[test]
fn excerpts_of_long_lines_are_cut() {
    let line = format!(
        "<scene version=\"3.0.0\">{}<foo/></scene>",
        " ".repeat(1_000_000)
    );
    let files = Files::new(&line, &[]);
    let problems = check_scene(&files.scene(), &LoadOptions::default());
    for problem in problems {
        let mut text = String::new();
        let handler = miette::NarratableReportHandler::new();
        handler.render_report(&mut text, &problem).unwrap();
        assert!(text.len() < 3000, "{} bytes", text.len());
    }
}

#[test]
fn pixels_that_are_not_finite_are_replaced_with_a_warning() {
    let scene = r#"<scene version="3.0.0"><sensor type="perspective"/>
<emitter type="envmap"><string name="filename" value="sky.pfm"/></emitter></scene>"#;
    let files = Files::new(scene, &[]);
    let values = [0.5, f32::NAN, f32::INFINITY, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let mut image = b"Pf\n3 3\n-1.0\n".to_vec();
    image.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(files.scene().with_file_name("sky.pfm"), image).unwrap();
    let loaded = files.load();
    let warnings: Vec<&str> = loaded.warnings.iter().map(|w| w.message()).collect();
    let expected = "1 values are not numbers and count as 0, 1 are infinite and count as the largest finite value; the first is in column 1 of row 2";
    assert!(
        warnings.len() == 1 && warnings[0].ends_with(expected),
        "{warnings:?}"
    );
    let Emitter::Environment(environment) = &loaded.desc.emitters[0] else {
        panic!("{:?}", loaded.desc.emitters);
    };
    // The file starts with the lower row.
    let row = |i: usize| [0, 1, 2].map(|column| environment.image.rgb(column, i).r);
    assert_eq!([row(1), row(2)], [[2.0, 1.0, 1.0], [0.5, 0.0, 2.0]]);
}
