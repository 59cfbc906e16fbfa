//! Names of shapes and materials, and the files of a scene.

use super::{Files, document, load};
use manylight::scene::LightGroupNames;
use manylight_io::scene_digest;

#[test]
fn shapes_and_materials_have_the_names_of_the_file() {
    let scene = load(
        r#"<bsdf type="twosided" id="paint"><bsdf type="diffuse"/></bsdf>
           <shape type="sphere" id="ball"><ref id="paint"/></shape>
           <shape type="rectangle"><bsdf type="mask"><bsdf type="diffuse" id="leaf"/></bsdf></shape>
           <shape type="rectangle"/>
           <shape type="shapegroup" id="tree"><shape type="cube" id="trunk"/></shape>
           <shape type="instance" id="oak"><ref id="tree"/></shape>
           <shape type="instance"><ref id="tree"/></shape>"#,
    );
    let names: Vec<&str> = scene.primitives.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["ball", "rectangle", "rectangle_2"]);
    assert_eq!(scene.groups[0][0].name, "trunk");
    let instances: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(instances, ["oak", ""]);
    let material = |primitive: usize| {
        let index = scene.primitives[primitive].material.index();
        scene.material_names.get(index).map_or("", String::as_str)
    };
    assert_eq!(material(0), "paint");
    assert!(scene.material_names.iter().any(|name| name == "leaf"));
}

#[test]
fn a_scene_lists_its_files() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let content = r#"<shape type="obj"><string name="filename" value="part.obj"/></shape>"#;
    let files = Files::new(&document("3.0.0", content), &[("part.obj", mesh)]);
    let loaded = files.load();
    let read: Vec<_> = loaded
        .files
        .iter()
        .filter_map(|path| path.file_name())
        .collect();
    assert_eq!(read.len(), 2);
    assert!(read.iter().any(|name| *name == "part.obj"));
    assert_eq!(loaded.desc.primitives[0].name, "part");
    let first = scene_digest(&files.scene(), &loaded.files).unwrap();
    let changed = files.folder.path().join("part.obj");
    std::fs::write(changed, format!("{mesh}\n")).unwrap();
    assert_ne!(scene_digest(&files.scene(), &loaded.files).unwrap(), first);
}

#[test]
fn emitters_have_the_id_of_the_emitter_or_of_the_shape() {
    let scene = load(
        r#"<shape type="sphere" id="bulb"><emitter type="area" id="key"/></shape>
           <shape type="sphere" id="lamp"><emitter type="area"/></shape>
           <shape type="sphere"><emitter type="area"/></shape>
           <shape type="sphere" id="ball"/>
           <emitter type="point" id="candle"/>
           <emitter type="constant"/>"#,
    );
    let names = LightGroupNames::of(&scene).0.into_iter();
    let names: Vec<String> = names.map(|(_, name)| name).collect();
    // The fourth is the emitter of the document.
    assert_eq!(names, ["key", "lamp", "sphere", "rest", "candle", "rest"]);
}
