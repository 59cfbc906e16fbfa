//! Well-known scenes of other projects, in the folder that `MANYLIGHT_SCENES` names. Without it,
//! the tests are skipped.

use manylight::geometry::Shape;
use manylight_io::{LoadOptions, check_scene, load_scene};
use std::path::{Path, PathBuf};

/// The folder of scenes; a note is printed if there is none.
pub(crate) fn scenes() -> Option<PathBuf> {
    let folder = std::env::var_os("MANYLIGHT_SCENES").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: MANYLIGHT_SCENES is not set to a folder of scenes");
    }
    folder
}

/// File, and the numbers of primitives, triangles and emitters that Mitsuba 3.9.1 loads.
const COUNTS: [(&str, usize, usize, usize); 11] = [
    ("cbox-many-lights/cbox_many_lights.xml", 20, 62, 13),
    ("classroom/scene.xml", 79, 103_832, 1),
    ("classroom/scene_env.xml", 79, 103_832, 1),
    ("cornell-box/scene.xml", 8, 36, 1),
    ("kitchen/scene_env.xml", 286, 1_021_815, 1),
    ("living-room/scene.xml", 65, 143_163, 1),
    ("many-lights-bunny/bunny.xml", 609, 115_002, 400),
    ("sponza-dabrovic/scene.xml", 38, 66_445, 1),
    ("staircase2/scene.xml", 32, 30_927, 13),
    ("veach-ajar/scene.xml", 22, 382_690, 1),
    ("veach-mis/scene.xml", 9, 52, 3),
];

/// Numbers of primitives, triangles and emitters.
pub(crate) fn counts(path: &Path) -> (usize, usize, usize) {
    let desc = load_scene(path, &LoadOptions::default()).unwrap().desc;
    let count =
        |primitive: &manylight::scene::PrimitiveDesc| match &desc.shapes[primitive.shape.index()] {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            _ => 0,
        };
    (
        desc.primitives.len(),
        desc.primitives.iter().map(count).sum(),
        desc.emitters.len(),
    )
}

#[test]
fn well_known_scenes_load_completely() {
    let Some(folder) = scenes() else { return };
    for (name, primitives, triangle_count, emitters) in COUNTS {
        assert_eq!(
            counts(&folder.join(name)),
            (primitives, triangle_count, emitters),
            "{name}"
        );
    }
}

#[test]
fn all_missing_meshes_are_reported() {
    let Some(folder) = scenes() else { return };
    let path = folder.join("kitchen/kitchen.xml");
    let missing: Vec<_> = check_scene(&path, &LoadOptions::default())
        .into_iter()
        .filter(|d| d.code == "scene::missing_file")
        .collect();
    assert_eq!(missing.len(), 6);
    let first = load_scene(&path, &LoadOptions::default()).unwrap_err();
    assert_eq!(
        first
            .diagnostic()
            .location
            .as_ref()
            .map(|at| (at.line(), at.column())),
        Some((1235, 34))
    );
}
