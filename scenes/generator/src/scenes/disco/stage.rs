//! Metal ribs on the back wall, the booth, speakers, and seats on the left.

use super::{BACK, DiscoMaterials, HALF_WIDTH};
use crate::build::{
    arc, bevelled_box, bevelled_cylinder, catmull_rom, lathe, moulding, superellipsoid, torus, tube,
};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};

pub(super) fn add(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    ribs(scene, materials, detail);
    booth(scene, materials, detail);
    speakers(scene, materials, detail);
    seats(scene, materials, detail);
}

/// Half-round metal ribs on the back wall between a plinth and a cap.
fn ribs(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let rib = lathe(
        &[(0.0, 0.0), (0.2, 0.0), (0.2, 2.9), (0.0, 2.9)].map(DVec2::from),
        detail.segments(28),
    );
    for i in 0..22 {
        let x = -4.41 + 0.42 * f64::from(i);
        assembly.add(materials.satin, &rib.placed(Pose::at(x, 0.28, BACK + 0.05)));
    }
    let w = HALF_WIDTH;
    assembly.add(
        materials.black,
        &bevelled_box([-w, 0.0, BACK], [w, 0.29, BACK + 0.32], 0.01),
    );
    assembly.add(
        materials.black,
        &bevelled_box([-w, 3.17, BACK], [w, 3.3, BACK + 0.32], 0.01),
    );
    for x in [-w, w - 0.75] {
        assembly.add(
            materials.panel,
            &bevelled_box([x, 0.28, BACK], [x + 0.75, 3.18, BACK + 0.2], 0.008),
        );
    }
    scene.place_assembly("rib", assembly);
}

/// z of the center of the arc of the booth's front.
const BOOTH_CENTER: f64 = -1.6;
/// Radius of the arc of the booth's front.
const BOOTH_RADIUS: f64 = 2.0;
/// Left end of the arc of the booth's front, in degrees.
const BOOTH_LEFT: f64 = 122.0;
/// Angle of the arc of the booth's front, in degrees.
const BOOTH_ANGLE: f64 = 64.0;

/// A curved counter with copper slats, two turntables and a mixer.
fn booth(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let center = DVec2::new(0.0, BOOTH_CENTER);
    let front: Vec<DVec3> = arc(
        center,
        BOOTH_RADIUS,
        BOOTH_LEFT,
        BOOTH_LEFT - BOOTH_ANGLE,
        detail.segments(24),
    )
    .iter()
    .map(|p| DVec3::new(p.x, 0.0, p.y))
    .collect();
    let body = [(0.0, 0.0), (0.03, 0.0), (0.03, 1.02), (0.0, 1.02)].map(DVec2::from);
    let top = [(-0.62, 1.02), (0.06, 1.02), (0.06, 1.06), (-0.62, 1.06)].map(DVec2::from);
    assembly.add(materials.black, &moulding(&body, &front, 35.0));
    assembly.add(materials.walnut, &moulding(&top, &front, 35.0));
    slats(&mut assembly, materials, detail);
    for x in [-0.52, 0.52] {
        turntable(&mut assembly, materials, detail, x);
    }
    assembly.add(
        materials.black,
        &bevelled_box([-0.2, 1.058, -0.1], [0.2, 1.14, 0.24], 0.008),
    );
    scene.place_assembly("booth", assembly.placed(Pose::at(0.15, 0.0, -3.95)));
}

/// Copper slats on the front of the booth.
fn slats(assembly: &mut Assembly, materials: &DiscoMaterials, detail: Detail) {
    let count = detail.count(26).min(104);
    for i in 0..count {
        let angle = (BOOTH_LEFT - BOOTH_ANGLE * (i as f64 + 0.5) / count as f64).to_radians();
        let width = 0.5 * BOOTH_RADIUS * BOOTH_ANGLE.to_radians() / count as f64;
        let slat = bevelled_box(
            [-width / 2.0, 0.06, -0.01],
            [width / 2.0, 0.99, 0.02],
            0.006,
        );
        let pose = Pose::at(
            BOOTH_RADIUS * angle.cos(),
            0.0,
            BOOTH_CENTER + BOOTH_RADIUS * angle.sin(),
        )
        .turned(90.0 - angle.to_degrees());
        assembly.add(materials.copper, &slat.placed(pose));
    }
}

/// A turntable on the booth, centered at `x`.
fn turntable(assembly: &mut Assembly, materials: &DiscoMaterials, detail: Detail, x: f64) {
    assembly.add(
        materials.satin,
        &bevelled_box([x - 0.22, 1.058, -0.12], [x + 0.22, 1.13, 0.22], 0.01),
    );
    let platter = bevelled_cylinder(0.15, 0.022, 0.004, detail.segments(40));
    assembly.add(
        materials.steel,
        &platter.placed(Pose::at(x - 0.03, 1.129, 0.05)),
    );
    assembly.add(
        materials.black,
        &bevelled_cylinder(0.142, 0.004, 0.001, detail.segments(40)).placed(Pose::at(
            x - 0.03,
            1.151,
            0.05,
        )),
    );
    assembly.add(
        materials.leather,
        &bevelled_cylinder(0.048, 0.0012, 0.0003, detail.segments(24)).placed(Pose::at(
            x - 0.03,
            1.1549,
            0.05,
        )),
    );
    let arm = [
        (0.17, 1.17, -0.07),
        (0.172, 1.172, 0.05),
        (0.13, 1.165, 0.13),
        (0.09, 1.158, 0.12),
    ]
    .map(|(dx, y, z)| DVec3::new(x + dx, y, z));
    assembly.add(materials.steel, &tube(&catmull_rom(&arm, 4), 8, |_| 0.005));
    assembly.add(
        materials.steel,
        &bevelled_cylinder(0.02, 0.05, 0.003, 16).placed(Pose::at(x + 0.17, 1.129, -0.07)),
    );
}

/// A stack of two speakers on each side of the booth.
fn speakers(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut stack = Assembly::default();
    let round = detail.segments(36);
    stack.add(
        materials.black,
        &bevelled_box([-0.4, 0.0, -0.35], [0.4, 0.95, 0.3], 0.012),
    );
    stack.add(
        materials.black,
        &bevelled_box([-0.36, 0.955, -0.3], [0.36, 2.1, 0.29], 0.012),
    );
    let driver = |r: f64| {
        let profile = [
            (0.0, 0.0),
            (1.1, 0.0),
            (1.1, 0.0),
            (1.1, 0.07),
            (1.0, 0.075),
            (0.97, 0.03),
            (0.86, 0.05),
            (0.8, 0.015),
            (0.8, 0.015),
            (0.32, -0.28),
            (0.32, -0.28),
            (0.26, -0.2),
            (0.0, -0.15),
        ];
        // Flattened and moved forwards, so that the cone does not reach into the box.
        props::turned(
            &profile.map(|(x, y)| (x * r, (y + 0.32) * r * 0.35)),
            2,
            round,
        )
    };
    for (r, y, z) in [(0.3, 0.48, 0.3), (0.2, 1.27, 0.29), (0.2, 1.72, 0.29)] {
        stack.add(
            materials.cone,
            &driver(r).placed(Pose::at(0.0, y, z - 0.002).tilted(90.0)),
        );
        let ring = torus(r * 1.1, 0.012, round, 8);
        stack.add(
            materials.satin,
            &ring.placed(Pose::at(0.0, y, z + 0.004).tilted(90.0)),
        );
    }
    let horn = superellipsoid([0.16, 0.05, 0.02], 0.4, 0.4, detail.segments(20));
    stack.add(materials.satin, &horn.placed(Pose::at(0.0, 2.0, 0.285)));
    let poses = [(-2.75, 24.0), (3.0, -24.0)].map(|(x, turn)| Pose::at(x, 0.0, -4.0).turned(turn));
    scene.place_copies("speaker", stack, &poses);
}

/// A velvet bench at the left wall with round tables in front of it.
fn seats(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let (wall, along) = (-HALF_WIDTH + 0.47, 0.2);
    let mut seat = Assembly::default();
    let cushion = superellipsoid([0.48, 0.13, 0.36], 0.3, 0.25, detail.segments(32));
    let back = superellipsoid([0.48, 0.28, 0.11], 0.3, 0.3, detail.segments(32));
    seat.add(materials.velvet, &cushion.placed(Pose::at(0.0, 0.36, 0.02)));
    seat.add(
        materials.velvet,
        &back.placed(Pose::at(0.0, 0.72, -0.3).tilted(-7.0)),
    );
    seat.add(
        materials.black,
        &bevelled_box([-0.482, 0.0, -0.4], [0.482, 0.26, 0.3], 0.01),
    );
    let poses: Vec<Pose> = (0..6)
        .map(|i| Pose::at(wall, 0.0, along + 2.4 - 0.965 * f64::from(i)).turned(90.0))
        .collect();
    scene.place_copies("seat", seat, &poses);

    let mut table = Assembly::default();
    let foot = [
        (0.0, 0.0),
        (0.2, 0.0),
        (0.2, 0.0),
        (0.205, 0.012),
        (0.03, 0.035),
        (0.022, 0.06),
        (0.022, 0.06),
        (0.022, 0.5),
        (0.022, 0.5),
        (0.1, 0.525),
        (0.1, 0.525),
        (0.0, 0.525),
    ];
    table.add(
        materials.steel,
        &props::turned(&foot, 2, detail.segments(28)),
    );
    let top = bevelled_cylinder(0.3, 0.028, 0.006, detail.segments(36));
    table.add(materials.black, &top.placed(Pose::at(0.0, 0.524, 0.0)));
    let poses = [-1.9, 0.0, 1.9].map(|z| Pose::at(wall + 0.8, 0.0, along + z));
    scene.place_copies("low_table", table, &poses);
}
