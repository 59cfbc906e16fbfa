//! Drums, traffic cones and a bucket on the floor.

use super::super::GarageMaterials;
use crate::build::{bevelled_box, lathe, tube};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    drums(&mut assembly, materials, detail);
    cones(&mut assembly, materials, detail);
    bucket(&mut assembly, materials, detail);
    scene.place_assembly("about", assembly);
}

/// Two steel drums.
fn drums(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let round = detail.segments(32);
    let drum = [
        (0.0, 0.0),
        (0.28, 0.0),
        (0.28, 0.0),
        (0.285, 0.01),
        (0.28, 0.02),
        (0.28, 0.28),
        (0.29, 0.295),
        (0.28, 0.31),
        (0.28, 0.57),
        (0.29, 0.585),
        (0.28, 0.6),
        (0.28, 0.86),
        (0.285, 0.87),
        (0.28, 0.88),
        (0.28, 0.88),
        (0.265, 0.88),
        (0.265, 0.88),
        (0.265, 0.865),
        (0.265, 0.865),
        (0.0, 0.865),
    ];
    let drum = props::turned(&drum, 2, round);
    assembly.add(materials.blue, &drum.placed(Pose::at(4.75, 0.0, -3.4)));
    assembly.add(
        materials.orange,
        &drum.placed(Pose::at(4.7, 0.0, -2.75).turned(30.0)),
    );
}

/// Two traffic cones with a pale band.
fn cones(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let cone = [
        (0.0, 0.03),
        (0.14, 0.03),
        (0.14, 0.03),
        (0.13, 0.04),
        (0.035, 0.5),
        (0.03, 0.51),
        (0.0, 0.51),
    ];
    for (x, z) in [(2.75, -1.75), (-2.75, 2.0)] {
        assembly.add(
            materials.orange,
            &props::turned(&cone, 2, detail.segments(24)).placed(Pose::at(x, 0.0, z)),
        );
        assembly.add(
            materials.orange,
            &bevelled_box(
                [x - 0.18, 0.0, z - 0.18],
                [x + 0.18, 0.031, z + 0.18],
                0.012,
            ),
        );
        let band = [
            (0.096, 0.2),
            (0.098, 0.2),
            (0.075, 0.31),
            (0.073, 0.31),
            (0.096, 0.2),
        ]
        .map(DVec2::from);
        let band = lathe(&band, detail.segments(24));
        assembly.add(materials.cream, &band.placed(Pose::at(x, 0.0, z)));
    }
}

/// A bucket with a wire handle.
fn bucket(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let bucket = [
        (0.0, 0.0),
        (0.1, 0.0),
        (0.1, 0.0),
        (0.14, 0.27),
        (0.146, 0.27),
        (0.146, 0.275),
        (0.137, 0.275),
        (0.137, 0.275),
        (0.098, 0.01),
        (0.098, 0.01),
        (0.0, 0.008),
    ];
    let at = Pose::at(0.95, 0.0, -2.45);
    assembly.add(
        materials.galvanized,
        &props::turned(&bucket, 2, detail.segments(28)).placed(at),
    );
    let bail: Vec<DVec3> = (0..=12)
        .map(|i| {
            let angle = PI * f64::from(i) / 12.0;
            DVec3::new(
                0.142 * angle.cos(),
                0.27 - 0.06 * angle.sin(),
                0.13 * angle.sin(),
            )
        })
        .collect();
    assembly.add(materials.iron, &tube(&bail, 6, |_| 0.004).placed(at));
}
