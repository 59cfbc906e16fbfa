//! Hundreds of area lights: fluorescent tubes in troughs, strings of bulbs, and a sign.

use super::{BACK, GarageMaterials, HEIGHT, LEFT, RIGHT};
use crate::build::{bevelled_box, cylinder, extrude, tube};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::Detail;
use glam::{DVec2, DVec3};

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    troughs(scene, materials, detail);
    strings(scene, materials, detail);
    sign(scene, materials, detail);
}

/// Length of a trough and of its two rows of tubes.
const TROUGH: f64 = 1.3;

/// Steel troughs between the beams, open at the top. Finer scenes have more and shorter tubes of
/// the same total length.
fn troughs(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let bent = [
        (-0.12, 0.09),
        (-0.07, 0.0),
        (0.07, 0.0),
        (0.12, 0.09),
        (0.117, 0.09),
        (0.068, 0.004),
        (-0.068, 0.004),
        (-0.117, 0.09),
    ];
    let trough = extrude(&bent.map(DVec2::from), TROUGH + 0.06, 25.0);
    let tubes = detail.count(2);
    let length = TROUGH / tubes as f64;
    let lamp = scene.add_mesh("tube", cylinder(0.013, length - 0.012, 8));
    let mut lamps = Vec::new();
    for x in [-4.4, -2.2, -0.3, 1.5, 2.9] {
        for row in 0..5 {
            let z = -3.3 + 1.75 * f64::from(row);
            let y = HEIGHT - 0.36;
            assembly.add(materials.galvanized, &trough.placed(Pose::at(x, y, z)));
            for end in [-0.5, 0.5] {
                let rod = [
                    DVec3::new(x, y + 0.002, z + end),
                    DVec3::new(x, HEIGHT, z + end),
                ];
                assembly.add(materials.iron, &tube(&rod, 6, |_| 0.004));
            }
            for side in [-0.04, 0.04] {
                for i in 0..tubes {
                    let start = z - TROUGH / 2.0 + length * i as f64 + 0.006;
                    lamps.push(Pose::at(x + side, y + 0.035, start).tilted(90.0));
                }
            }
        }
    }
    for (i, pose) in lamps.into_iter().enumerate() {
        scene.place_emitter(
            &format!("tube_{i}"),
            ShapeKind::Mesh(lamp),
            pose,
            materials.lamp,
            [112.0, 122.0, 117.0],
        );
    }
    scene.place_assembly("trough", assembly);
}

/// `radius` at level 1, reduced at higher levels so that the total area of the bulbs stays the
/// same.
fn shrunk(radius: f64, detail: Detail) -> f64 {
    radius / (detail.count(1) as f64).sqrt()
}

/// Strings of bulbs on sagging cables.
fn strings(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let socket = cylinder(0.014, 0.04, 8);
    let count = detail.count(16);
    let bulb_radius = shrunk(0.022, detail);
    let mut bulb = 0;
    for (from, to) in [
        (DVec3::new(LEFT, 2.5, -0.9), DVec3::new(-3.0, 2.6, -2.5)),
        (DVec3::new(-3.0, 2.6, -2.5), DVec3::new(0.6, 2.6, -3.1)),
        (DVec3::new(0.6, 2.6, -3.1), DVec3::new(4.2, 2.6, -2.5)),
        (DVec3::new(4.2, 2.6, -2.5), DVec3::new(RIGHT, 2.5, -0.4)),
    ] {
        let at = |t: f64| from.lerp(to, t) - DVec3::Y * (1.1 * t * (1.0 - t));
        let cable: Vec<DVec3> = (0..=20).map(|i| at(f64::from(i) / 20.0)).collect();
        assembly.add(materials.dark, &tube(&cable, 6, |_| 0.006));
        for i in 0..count {
            let hang = at((i as f64 + 0.5) / count as f64);
            assembly.add(
                materials.dark,
                &socket.placed(Pose::at(hang.x, hang.y - 0.04, hang.z)),
            );
            let pose =
                Pose::at(hang.x, hang.y - 0.04 - 0.7 * bulb_radius, hang.z).scaled(bulb_radius);
            scene.place_emitter(
                &format!("bulb_{bulb}"),
                ShapeKind::Sphere,
                pose,
                materials.lamp,
                [20.0, 12.0, 5.5],
            );
            bulb += 1;
        }
    }
    scene.place_assembly("string", assembly);
}

/// An arrow on the back wall with bulbs along its edge.
fn sign(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let outline = [
        (-0.85, -0.17),
        (0.25, -0.17),
        (0.25, -0.38),
        (0.85, 0.0),
        (0.25, 0.38),
        (0.25, 0.17),
        (-0.85, 0.17),
    ]
    .map(DVec2::from);
    let center = DVec3::new(-0.75, 1.95, BACK + 0.09);
    let mut assembly = Assembly::default();
    assembly.add(
        materials.red,
        &extrude(&outline, 0.1, 30.0).placed(Pose::at(center.x, center.y, center.z)),
    );
    let smaller = outline.map(|p| DVec2::new(p.x * 0.9 + 0.005, p.y * 0.78));
    assembly.add(
        materials.cream,
        &extrude(&smaller, 0.02, 30.0).placed(Pose::at(center.x, center.y, center.z + 0.05)),
    );
    for x in [-0.6, 0.0] {
        assembly.add(
            materials.iron,
            &bevelled_box(
                [center.x + x, center.y - 0.04, BACK],
                [center.x + x + 0.05, center.y + 0.04, center.z - 0.03],
                0.004,
            ),
        );
    }
    let socket = cylinder(0.016, 0.018, 8);
    let spacing = 0.11 / detail.count(1) as f64;
    let bulb_radius = shrunk(0.017, detail);
    let mut bulb = 0;
    for i in 0..outline.len() {
        let (from, to) = (outline[i], outline[(i + 1) % outline.len()]);
        let count = ((to - from).length() / spacing).round().max(1.0) as usize;
        for k in 0..count {
            let p = from.lerp(to, k as f64 / count as f64);
            let on_edge = DVec2::new(p.x * 0.95, p.y * 0.89);
            let at = center + on_edge.extend(0.05);
            assembly.add(
                materials.brass,
                &socket.placed(Pose::at(at.x, at.y, at.z).tilted(90.0)),
            );
            let pose = Pose::at(at.x, at.y, at.z + 0.018 + 0.6 * bulb_radius).scaled(bulb_radius);
            scene.place_emitter(
                &format!("sign_bulb_{bulb}"),
                ShapeKind::Sphere,
                pose,
                materials.lamp,
                [18.0, 9.5, 3.8],
            );
            bulb += 1;
        }
    }
    scene.place_assembly("sign", assembly);
}
