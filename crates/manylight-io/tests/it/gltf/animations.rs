//! Cameras that move.

use super::*;
use manylight::math::{Affine3A, Vec3};
use std::f32::consts::FRAC_1_SQRT_2;

/// A camera on a cart. The cart moves by 2 along x in a second, and the camera turns to the left by a
/// quarter turn; `interpolation` of the turn, with values between its tangents.
fn cart(interpolation: &str) -> Value {
    let mut document = changed(&[
        ("/scenes/0/nodes", json!([0, 1, 2])),
        ("/nodes/2", json!({ "children": [3] })),
        ("/nodes/3", json!({ "camera": 0, "translation": [0, 1, 0] })),
        (
            "/cameras",
            json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]),
        ),
    ]);
    let (straight, left) = (
        [0.0, 0.0, 0.0, 1.0],
        [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2],
    );
    let turns: Vec<f32> = match interpolation {
        "CUBICSPLINE" => [[0.0; 4], straight, [0.0; 4], [0.0; 4], left, [0.0; 4]].concat(),
        _ => [straight, left].concat(),
    };
    let times = add_accessor(&mut document, &bytes_of(&[0.0, 1.0]), 5126, 2, "SCALAR");
    let places = bytes_of(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let places = add_accessor(&mut document, &places, 5126, 2, "VEC3");
    let count = turns.len() / 4;
    let turns = add_accessor(&mut document, &bytes_of(&turns), 5126, count, "VEC4");
    set(
        &mut document,
        "/animations",
        json!([{
            "samplers": [
                { "input": times, "output": places },
                { "input": times, "output": turns, "interpolation": interpolation }
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 2, "path": "translation" } },
                { "sampler": 1, "target": { "node": 3, "path": "rotation" } }
            ]
        }]),
    );
    document
}

/// Places and directions of the camera, frame by frame.
fn frames(document: &Value, fps: f32) -> Vec<(Vec3, Vec3)> {
    let sensor = load_by(
        document,
        &LoadOptions {
            fps,
            ..LoadOptions::default()
        },
    )
    .sensors
    .remove(0);
    let frame = |m: &Affine3A| (m.translation.into(), m.transform_vector3(Vec3::Z));
    sensor.motion.iter().map(frame).collect()
}

#[test]
fn a_camera_moves_with_its_parents() {
    let [x, half] = [FRAC_1_SQRT_2, 0.5_f32];
    for (interpolation, middle) in [
        ("LINEAR", Vec3::new(-x, 0.0, -x)),
        ("STEP", Vec3::NEG_Z),
        // The mean of both quaternions, normalized.
        ("CUBICSPLINE", Vec3::new(-x, 0.0, -x)),
    ] {
        let found = frames(&cart(interpolation), 2.0);
        let expected = [
            (Vec3::Y, Vec3::NEG_Z),
            (Vec3::new(2.0 * half, 1.0, 0.0), middle),
            (Vec3::new(2.0, 1.0, 0.0), Vec3::NEG_X),
        ];
        assert_eq!(found.len(), 3, "{interpolation}");
        for (found, expected) in found.iter().zip(expected) {
            let off = found.0.distance(expected.0) + found.1.distance(expected.1);
            assert!(off < 1e-5, "{interpolation}: {found:?} for {expected:?}");
        }
    }
    assert_eq!(frames(&cart("LINEAR"), 24.0).len(), 25);
    assert!(frames(&triangle(), 24.0).is_empty());
}

#[test]
fn invalid_animations_are_located() {
    for (path, value, message) in [
        (
            "/animations/0/samplers/1/interpolation",
            json!("LOOP"),
            "expected LINEAR, STEP or CUBICSPLINE",
        ),
        (
            "/animations/0/samplers/1/interpolation",
            json!("CUBICSPLINE"),
            "expected 6 for 2 times",
        ),
        ("/animations/0/samplers/0/input", json!(5), "SCALAR"),
        ("/animations/0/channels/0/sampler", json!(7), "sampler"),
        ("/animations/0/channels/1/target/node", json!(9), "node"),
        (
            "/animations/0/channels/1/target/path",
            json!("rotate"),
            "target/path: found `rotate`, expected `translation`, `rotation`, `scale` or `weights`",
        ),
        (
            "/animations/0/channels/1/target",
            json!({ "node": 3 }),
            "the property `path` is missing",
        ),
    ] {
        let mut document = cart("LINEAR");
        set(&mut document, path, value);
        let found = Folder::new(&document).problems();
        assert!(
            found.iter().any(|problem| problem.contains(message)),
            "{path}: {found:?}"
        );
    }
    let mut document = cart("LINEAR");
    let times = add_accessor(&mut document, &bytes_of(&[1.0, 0.5]), 5126, 2, "SCALAR");
    set(
        &mut document,
        "/animations/0/samplers/0/input",
        json!(times),
    );
    let found = Folder::new(&document).problems();
    assert!(found[0].contains("ascending"), "{found:?}");
    let mut document = cart("LINEAR");
    let times = add_accessor(&mut document, &bytes_of(&[0.0, 1e9]), 5126, 2, "SCALAR");
    set(
        &mut document,
        "/animations/0/samplers/0/input",
        json!(times),
    );
    let found = Folder::new(&document).problems();
    assert!(found[0].contains("expected at most 1e7"), "{found:?}");
}

#[test]
fn weights_of_cameras_are_ignored_and_a_second_track_is_reported() {
    let mut document = cart("LINEAR");
    set(
        &mut document,
        "/animations/0/channels/1/target/path",
        json!("weights"),
    );
    assert_eq!(
        frames(&document, 1.0)[1],
        (Vec3::new(2.0, 1.0, 0.0), Vec3::NEG_Z)
    );
    let mut document = cart("LINEAR");
    let first = document["animations"][0].clone();
    set(&mut document, "/animations/1", first);
    let found = Folder::new(&document).problems();
    let expected = "warning /animations/1/channels/0/target: several channels set the translation";
    assert!(
        matches!(found.as_slice(), [only] if only.starts_with(expected)),
        "{found:?}"
    );
}
