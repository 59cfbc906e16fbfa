//! A scene for unit tests.

use crate::build::boxed;
use crate::material::{Metal, matte, metal};
use crate::pose::Pose;
use crate::scene::{About, Camera, Scene, ShapeKind, SpotLight};
use glam::DVec3;

/// A copper box, a lamp and a spot.
pub(crate) fn small_scene() -> Scene {
    let about = About {
        title: "Test",
        text: vec!["Shows a box.".to_owned()],
    };
    let camera = Camera {
        origin: DVec3::Z,
        target: DVec3::ZERO,
        fov_x: 40.0,
        size: [64, 48],
        max_depth: 5,
    };
    let mut scene = Scene::new(about, camera);
    let copper = scene.add_material("copper", metal(Metal::Copper, 0.1));
    let black = scene.add_material("black", matte([0.0; 3]));
    let cube = scene.add_mesh("cube", boxed([0.0; 3], [1.0; 3]));
    let pose = Pose::at(1.0, 0.0, 0.0).turned(90.0).scaled(2.0);
    scene.place("box", ShapeKind::Mesh(cube), pose, copper);
    scene.place_emitter(
        "lamp",
        ShapeKind::Rectangle,
        Pose::identity(),
        black,
        [3.0, 2.0, 1.0],
    );
    scene.spots.push(SpotLight {
        origin: DVec3::Y,
        target: DVec3::ZERO,
        intensity: [1.0, 2.0, 3.0],
        cutoff: 30.0,
        beam: 20.0,
    });
    scene
}
