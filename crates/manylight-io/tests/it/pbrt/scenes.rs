//! PBRT scenes of other projects, in the folder that `MANYLIGHT_SCENES` names. Without it, the test
//! is skipped.

use super::load;
use crate::shared_scenes::{counts, scenes};
use manylight::scene::LightGroupNames;

/// File, and the numbers of primitives, triangles and emitters.
const COUNTS: [(&str, usize, usize, usize); 11] = [
    ("pbrt-cornell-box/cornell-box.pbrt", 8, 32, 1),
    ("pbrt-cornell-box/cornell-box-silver.pbrt", 8, 32, 1),
    ("pbrt-cornell-box/cornell-box-specular.pbrt", 8, 22, 1),
    (
        "pbrt-cornell-box/cornell-box-specular-volume.pbrt",
        8,
        22,
        1,
    ),
    ("pbrt-cornell-box/cornell-box-volume.pbrt", 8, 32, 1),
    ("pbrt-killeroos/killeroo-simple.pbrt", 5, 66_532, 1),
    ("pbrt-killeroos/killeroo-moving.pbrt", 5, 66_532, 1),
    ("pbrt-living-room/living-room.pbrt", 65, 143_163, 1),
    ("pbrt-staircase2/staircase2.pbrt", 32, 30_927, 13),
    ("pbrt-veach-mis/veach-mis.pbrt", 10, 12, 5),
    ("pbrt-veach-mis/veach-mis-colorized.pbrt", 10, 12, 5),
];

#[test]
fn well_known_pbrt_scenes_load_completely() {
    let Some(folder) = scenes() else { return };
    let mut wrong = Vec::new();
    for (name, primitives, triangles, emitters) in COUNTS {
        let found = counts(&folder.join(name));
        if found != (primitives, triangles, emitters) {
            wrong.push(format!("{name}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn shapes_and_materials_have_names() {
    let scene = load(
        r#"MakeNamedMaterial "clay" "string type" "diffuse"
           NamedMaterial "clay"
           Shape "sphere"
           Shape "sphere"
           ObjectBegin "tree" Shape "disk" ObjectEnd
           ObjectInstance "tree"
           ObjectInstance "tree""#,
    );
    let names: Vec<&str> = scene.primitives.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["sphere", "sphere_2"]);
    let instances: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(instances, ["tree", "tree_2"]);
    let material = scene.primitives[0].material.index();
    assert_eq!(scene.material_names[material], "clay");
}

#[test]
fn lights_name_their_group() {
    let scene = load(
        r#"LightSource "point" "string lightgroup" "key"
           AttributeBegin
               Attribute "light" "string lightgroup" "fill"
               LightSource "spot"
               AreaLightSource "diffuse"
               Shape "sphere"
           AttributeEnd
           LightSource "distant""#,
    );
    let names = LightGroupNames::of(&scene).0.into_iter();
    let names: Vec<String> = names.map(|(_, name)| name).collect();
    // The surface, the environment of the document, then the lights.
    assert_eq!(names, ["fill", "rest", "key", "fill", "rest"]);
}
