//! Grille, lamps, bumpers, mirrors and other fittings of the car.

use super::GarageMaterials;
use super::body::on_side;
use crate::build::{ball, bevelled_box, catmull_rom, superellipsoid, tube};
use crate::pose::Pose;
use crate::scene::Assembly;
use crate::scenes::{Detail, props};
use glam::DVec3;
use std::f64::consts::TAU;

pub(super) fn add(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    grille(assembly, materials, detail);
    headlamps(assembly, materials, detail);
    front_bumper(assembly, materials, detail);
    tail(assembly, materials, detail);
    rear_bumper(assembly, materials, detail);
    flanks(assembly, materials, detail);
    badge(assembly, materials, detail);
}

/// A grille with a chrome rim and bars.
fn grille(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let round = detail.segments(28);
    let mouth = superellipsoid([0.05, 0.075, 0.34], 0.8, 0.6, round);
    assembly.add(materials.dark, &mouth.placed(Pose::at(2.185, 0.43, 0.0)));
    let rim: Vec<DVec3> = (0..=round)
        .map(|i| {
            let (sin, cos) = (TAU * (i % round) as f64 / round as f64).sin_cos();
            let power = |v: f64| v.abs().powf(0.7) * v.signum();
            DVec3::new(2.215, 0.43 + 0.075 * power(sin), 0.34 * power(cos))
        })
        .collect();
    assembly.add(materials.chrome, &tube(&rim, 8, |_| 0.011));
    for i in -6..=6 {
        let z = 0.048 * f64::from(i);
        let half = 0.07 * (1.0 - (z / 0.35).powi(4)).max(0.0).sqrt();
        assembly.add(
            materials.chrome,
            &bevelled_box(
                [2.2, 0.43 - half, z - 0.003],
                [2.245, 0.43 + half, z + 0.003],
                0.001,
            ),
        );
    }
}

/// Headlamps and turn signals.
fn headlamps(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let round = detail.segments(28);
    for side in [-1.0, 1.0] {
        let bowl = props::turned(
            &[
                (0.0, -0.1),
                (0.09, -0.09),
                (0.098, 0.0),
                (0.104, 0.012),
                (0.098, 0.02),
                (0.092, 0.012),
                (0.0, 0.012),
            ],
            2,
            round,
        );
        let pose = Pose::at(1.93, 0.605, side * 0.6)
            .rolled(-76.0)
            .turned(-7.0 * side);
        assembly.add(materials.chrome, &bowl.placed(pose));
        let lens =
            superellipsoid([0.092, 0.03, 0.092], 1.0, 1.0, round).placed(Pose::at(0.0, 0.012, 0.0));
        assembly.add(materials.lens, &lens.placed(pose));
        let signal = superellipsoid([0.03, 0.028, 0.055], 1.0, 1.0, detail.segments(16));
        assembly.add(
            materials.orange,
            &signal.placed(Pose::at(2.105, 0.45, side * 0.5)),
        );
    }
}

/// The front bumper.
fn front_bumper(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let bumper: Vec<DVec3> = [
        (1.75, 0.86),
        (1.98, 0.77),
        (2.13, 0.62),
        (2.215, 0.35),
        (2.235, 0.0),
        (2.215, -0.35),
        (2.13, -0.62),
        (1.98, -0.77),
        (1.75, -0.86),
    ]
    .map(|(x, z)| DVec3::new(x, 0.335, z))
    .to_vec();
    assembly.add(
        materials.chrome,
        &tube(&catmull_rom(&bumper, 5), detail.segments(12), |_| 0.026),
    );
}

/// Tail lights and exhaust pipes.
fn tail(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for side in [-1.0, 1.0] {
        for i in 0..2 {
            let z = side * (0.36 + 0.15 * f64::from(i));
            let lamp = superellipsoid([0.03, 0.055, 0.06], 1.0, 1.0, detail.segments(20));
            assembly.add(
                materials.tail_light,
                &lamp.placed(Pose::at(-2.165, 0.64, z)),
            );
        }
        let pipe = [
            DVec3::new(-1.9, 0.24, side * 0.42),
            DVec3::new(-2.2, 0.24, side * 0.42),
        ];
        assembly.add(
            materials.chrome,
            &tube(&pipe, detail.segments(14), |_| 0.032),
        );
    }
}

/// The rear bumper.
fn rear_bumper(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let bumper: Vec<DVec3> = [
        (-1.75, 0.87),
        (-2.0, 0.8),
        (-2.15, 0.66),
        (-2.22, 0.35),
        (-2.235, 0.0),
        (-2.22, -0.35),
        (-2.15, -0.66),
        (-2.0, -0.8),
        (-1.75, -0.87),
    ]
    .map(|(x, z)| DVec3::new(x, 0.42, z))
    .to_vec();
    assembly.add(
        materials.chrome,
        &tube(&catmull_rom(&bumper, 5), detail.segments(12), |_| 0.026),
    );
}

/// Door handles, mirrors and a chrome strip along each sill.
fn flanks(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for side in [-1.0, 1.0] {
        let mirror_side = |p: DVec3| p * DVec3::new(1.0, 1.0, side);
        let grip: Vec<DVec3> = [(-0.34, 0.0), (-0.32, 0.028), (-0.2, 0.03), (-0.18, 0.0)]
            .map(|(x, out)| mirror_side(on_side(x, 0.7) + DVec3::Z * out))
            .to_vec();
        assembly.add(
            materials.chrome,
            &tube(&grip, detail.segments(10), |_| 0.008),
        );
        let sill: Vec<DVec3> = (0..=10)
            .map(|i| mirror_side(on_side(-0.86 + 1.72 * f64::from(i) / 10.0, 0.225)))
            .collect();
        assembly.add(
            materials.chrome,
            &tube(&sill, detail.segments(8), |_| 0.011),
        );
        let foot = mirror_side(on_side(0.55, 0.8) + DVec3::Z * -0.03);
        let head = foot + DVec3::new(-0.02, 0.1, 0.07 * side);
        assembly.add(
            materials.chrome,
            &tube(&[foot, head], detail.segments(10), |_| 0.009),
        );
        let shell = superellipsoid([0.05, 0.045, 0.065], 0.8, 0.9, detail.segments(20));
        assembly.add(
            materials.chrome,
            &shell.placed(Pose::at(head.x, head.y + 0.02, head.z)),
        );
    }
}

/// A badge on the bonnet.
fn badge(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    assembly.add(
        materials.chrome,
        &ball(0.03, detail.segments(12))
            .placed(Pose::at(2.02, 0.612, 0.0).stretched(1.0, 0.3, 1.0)),
    );
}
