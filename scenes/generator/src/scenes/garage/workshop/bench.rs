//! The bench and the tool board above it.

use super::super::{BACK, GarageMaterials};
use super::wrench;
use crate::build::{bevelled_box, bevelled_cylinder, extrude, torus, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::Detail;
use glam::{DVec2, DVec3};

/// z of the front of the tool board.
const BOARD_FRONT: f64 = BACK + 0.035;

/// A bench in the left back corner with a vise, a tool box, cans and a tool board.
pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let (left, right, front) = (-5.35, -3.35, BACK + 0.68);
    assembly.add(
        materials.wood,
        &bevelled_box([left, 0.84, BACK + 0.02], [right, 0.9, front], 0.006),
    );
    for x in [left + 0.06, right - 0.06] {
        for z in [BACK + 0.1, front - 0.08] {
            assembly.add(
                materials.iron,
                &bevelled_box(
                    [x - 0.03, 0.0, z - 0.03],
                    [x + 0.03, 0.842, z + 0.03],
                    0.004,
                ),
            );
        }
    }
    assembly.add(
        materials.iron,
        &bevelled_box(
            [left + 0.03, 0.22, BACK + 0.06],
            [right - 0.03, 0.25, front - 0.06],
            0.004,
        ),
    );
    boxes(&mut assembly, materials, front);
    vise(
        &mut assembly,
        materials,
        detail,
        Pose::at(-3.75, 0.9, front - 0.13),
    );
    tool_box(&mut assembly, materials);
    cans(&mut assembly, materials, detail);
    tool_board(&mut assembly, materials, detail);
    scene.place_assembly("bench", assembly);
}

/// Boxes on the lower shelf of the bench.
fn boxes(assembly: &mut Assembly, materials: &GarageMaterials, front: f64) {
    for (i, x) in [-5.1, -4.75, -4.3].into_iter().enumerate() {
        let paint = [materials.blue, materials.card, materials.card][i];
        assembly.add(
            paint,
            &bevelled_box(
                [x - 0.15, 0.251, BACK + 0.15],
                [x + 0.15, 0.45 + 0.05 * i as f64, front - 0.15],
                0.006,
            ),
        );
    }
}

/// A tool box with a handle.
fn tool_box(assembly: &mut Assembly, materials: &GarageMaterials) {
    assembly.add(
        materials.blue,
        &bevelled_box([-5.2, 0.9, BACK + 0.2], [-4.85, 1.06, BACK + 0.4], 0.012),
    );
    let grip = [(-5.12, 1.05), (-5.12, 1.1), (-4.93, 1.1), (-4.93, 1.05)]
        .map(|(x, y)| DVec3::new(x, y, BACK + 0.3));
    assembly.add(materials.iron, &tube(&grip, 8, |_| 0.008));
}

/// Three cans on the bench.
fn cans(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for (i, x) in [-4.6, -4.48, -4.37].into_iter().enumerate() {
        let can = bevelled_cylinder(0.05, 0.13 + 0.03 * i as f64, 0.004, detail.segments(24));
        assembly.add(
            [materials.cream, materials.galvanized, materials.red][i],
            &can.placed(Pose::at(x, 0.9, BACK + 0.2 + 0.05 * i as f64)),
        );
    }
}

/// A vise with its jaws towards +z.
fn vise(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail, pose: Pose) {
    let parts = [
        bevelled_cylinder(0.075, 0.03, 0.006, detail.segments(24)),
        bevelled_box([-0.045, 0.02, -0.1], [0.045, 0.1, 0.06], 0.012),
        bevelled_box([-0.07, 0.08, -0.035], [0.07, 0.16, -0.005], 0.008),
        bevelled_box([-0.07, 0.08, 0.045], [0.07, 0.16, 0.08], 0.008),
        bevelled_box([-0.035, 0.03, 0.05], [0.035, 0.09, 0.14], 0.01),
        bevelled_cylinder(0.014, 0.11, 0.003, 14).placed(Pose::at(0.0, 0.06, 0.11).tilted(90.0)),
        bevelled_cylinder(0.007, 0.2, 0.002, 10).placed(Pose::at(0.1, 0.06, 0.21).rolled(90.0)),
    ];
    assembly.add(materials.blue, &Mesh::joined(&parts[..5]).placed(pose));
    assembly.add(materials.iron, &Mesh::joined(&parts[5..]).placed(pose));
}

/// A painted board with tools.
fn tool_board(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    assembly.add(
        materials.cream,
        &bevelled_box([-5.3, 1.25, BACK], [-3.4, 2.15, BOARD_FRONT], 0.005),
    );
    wrenches(assembly, materials);
    hammers(assembly, materials, detail);
    saw(assembly, materials);
    screwdrivers(assembly, materials, detail);
    cable(assembly, materials, detail);
}

/// Eight wrenches.
fn wrenches(assembly: &mut Assembly, materials: &GarageMaterials) {
    let z = BOARD_FRONT;
    for i in 0..8 {
        let size = 0.16 + 0.022 * f64::from(i);
        let tool = extrude(&wrench(size), 0.008, 35.0);
        let x = -5.15 + 0.115 * f64::from(i);
        assembly.add(
            materials.iron,
            &tool.placed(Pose::at(x, 2.0 - size / 2.0, z + 0.008)),
        );
    }
}

/// A hammer and a mallet.
fn hammers(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let z = BOARD_FRONT;
    for (i, x) in [-4.1, -3.93].into_iter().enumerate() {
        let handle = bevelled_cylinder(0.014, 0.28, 0.004, detail.segments(12));
        assembly.add(materials.wood, &handle.placed(Pose::at(x, 1.68, z + 0.028)));
        let head = bevelled_box(
            [x - 0.055, 1.93, z + 0.002],
            [x + 0.05, 1.975, z + 0.052],
            0.008,
        );
        assembly.add([materials.iron, materials.rubber][i], &head);
    }
}

/// A hand saw.
fn saw(assembly: &mut Assembly, materials: &GarageMaterials) {
    let z = BOARD_FRONT;
    let blade = [(0.0, 0.0), (0.42, 0.05), (0.42, 0.08), (0.0, 0.13)].map(DVec2::from);
    assembly.add(
        materials.galvanized,
        &extrude(&blade, 0.004, 30.0).placed(Pose::at(-4.5, 1.42, z + 0.008)),
    );
    assembly.add(
        materials.red,
        &bevelled_box([-4.62, 1.41, z], [-4.49, 1.56, z + 0.022], 0.01),
    );
}

/// Five screwdrivers.
fn screwdrivers(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let z = BOARD_FRONT;
    for i in 0..5 {
        let x = -3.78 + 0.075 * f64::from(i);
        let shaft = bevelled_cylinder(0.004, 0.13, 0.001, 8);
        assembly.add(
            materials.galvanized,
            &shaft.placed(Pose::at(x, 1.52, z + 0.016)),
        );
        let grip = bevelled_cylinder(0.013, 0.1, 0.004, detail.segments(12));
        let paint = [materials.red, materials.orange, materials.blue][i as usize % 3];
        assembly.add(paint, &grip.placed(Pose::at(x, 1.645, z + 0.016)));
    }
}

/// A coiled cable.
fn cable(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let z = BOARD_FRONT;
    let coil = torus(0.11, 0.012, detail.segments(28), 6);
    for i in 0..3 {
        assembly.add(
            materials.orange,
            &coil.placed(Pose::at(-5.05, 1.5, z + 0.014 + 0.022 * f64::from(i)).tilted(90.0)),
        );
    }
}
