//! Floor, walls, ceiling, columns, floor marks and the roller shutter.

use super::{BACK, FRONT, GarageMaterials, HEIGHT, LEFT, RIGHT, pipes};
use crate::build::{Edges, bevelled_box, boxed, grid};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::Detail;
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    shell(scene, materials);
    columns(scene, materials);
    marks(scene, materials);
    pipes::add(scene, materials, detail);
    shutter(scene, materials, detail);
}

/// Length in meters of one repetition of the concrete texture.
const CONCRETE: f64 = 3.4;

/// The floor, the walls and the ceiling.
fn shell(scene: &mut Scene, materials: &GarageMaterials) {
    let (x, z) = ((LEFT + RIGHT) / 2.0, (BACK + FRONT) / 2.0);
    let (half_x, half_z) = ((RIGHT - LEFT) / 2.0, (FRONT - BACK) / 2.0);
    scene.place(
        "floor",
        ShapeKind::Rectangle,
        Pose::at(x, 0.0, z)
            .tilted(-90.0)
            .stretched(half_x, half_z, 1.0),
        materials.floor,
    );
    let mut assembly = Assembly::default();
    for (low, high) in [
        ([LEFT - 0.2, -0.1, BACK - 0.2], [RIGHT + 0.2, HEIGHT, BACK]),
        (
            [LEFT - 0.2, -0.1, FRONT],
            [RIGHT + 0.2, HEIGHT, FRONT + 0.2],
        ),
        ([LEFT - 0.2, -0.1, BACK], [LEFT, HEIGHT, FRONT]),
        ([RIGHT, -0.1, BACK], [RIGHT + 0.2, HEIGHT, FRONT]),
        (
            [LEFT - 0.2, HEIGHT, BACK - 0.2],
            [RIGHT + 0.2, HEIGHT + 0.2, FRONT + 0.2],
        ),
    ] {
        assembly.add(materials.concrete, &boxed(low, high).box_mapped(CONCRETE));
    }
    beams(&mut assembly, materials);
    dado(&mut assembly, materials);
    scene.place_assembly("hall", assembly);
}

/// Beams across the hall.
fn beams(assembly: &mut Assembly, materials: &GarageMaterials) {
    for x in [-3.0, 0.6, 4.2] {
        let beam = bevelled_box(
            [x - 0.16, HEIGHT - 0.32, BACK - 0.02],
            [x + 0.16, HEIGHT + 0.05, FRONT + 0.02],
            0.012,
        );
        assembly.add(materials.concrete, &beam.box_mapped(CONCRETE));
    }
}

/// Glossy paint on the lower part of the walls, with a line above it.
fn dado(assembly: &mut Assembly, materials: &GarageMaterials) {
    for (low, high) in [
        ([LEFT, 0.0, BACK], [RIGHT, 1.0, BACK + 0.004]),
        ([LEFT, 0.0, BACK], [LEFT + 0.004, 1.0, FRONT]),
        ([RIGHT - 0.004, 0.0, BACK], [RIGHT, 1.0, FRONT]),
    ] {
        assembly.add(materials.dado, &boxed(low, high));
        let lift = |p: [f64; 3], y: f64| [p[0], y, p[2]];
        assembly.add(materials.cream, &boxed(lift(low, 1.0), lift(high, 1.06)));
    }
}

/// Square columns with striped feet.
fn columns(scene: &mut Scene, materials: &GarageMaterials) {
    let mut assembly = Assembly::default();
    for (x, z) in [
        (-3.0, -2.5),
        (0.6, -3.1),
        (4.2, -2.5),
        (-3.0, 2.9),
        (4.2, 2.9),
    ] {
        let shaft = bevelled_box(
            [x - 0.19, -0.02, z - 0.19],
            [x + 0.19, HEIGHT - 0.3, z + 0.19],
            0.02,
        );
        assembly.add(materials.concrete, &shaft.box_mapped(CONCRETE));
        for i in 0..6 {
            let y = 0.18 * f64::from(i);
            let paint = if i % 2 == 0 {
                materials.yellow
            } else {
                materials.dark
            };
            assembly.add(
                paint,
                &bevelled_box(
                    [x - 0.194, y, z - 0.194],
                    [x + 0.194, y + 0.18, z + 0.194],
                    0.02,
                ),
            );
        }
    }
    scene.place_assembly("column", assembly);
}

/// Painted lines around the car.
fn marks(scene: &mut Scene, materials: &GarageMaterials) {
    let mut assembly = Assembly::default();
    let mut line = |low: [f64; 2], high: [f64; 2]| {
        assembly.add(
            materials.yellow,
            &boxed([low[0], -0.01, low[1]], [high[0], 0.0012, high[1]]),
        );
    };
    for z in [-1.75, 1.75] {
        line([-2.9, z - 0.05], [2.6, z + 0.05]);
    }
    line([-2.9, -1.7], [-2.8, 1.7]);
    scene.place_assembly("mark", assembly);
}

/// A ribbed metal shutter in the back wall.
fn shutter(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let (left, right, top) = (1.9, 4.0, 2.35);
    let ribs = detail.count(22).min(88);
    let step = top / ribs as f64;
    let slat: Vec<Vec<DVec3>> = (0..=ribs * 4)
        .map(|i| {
            let y = top - step * i as f64 / 4.0;
            let z = BACK + 0.03 + [0.0, 0.016, 0.02, 0.016][i % 4];
            vec![DVec3::new(left, y, z), DVec3::new(right, y, z)]
        })
        .collect();
    let mut assembly = Assembly::default();
    let curtain: Mesh = grid(&slat, Edges::Open, 60.0);
    let outwards = curtain.normals[0].z > 0.0;
    assembly.add(
        materials.galvanized,
        &if outwards { curtain } else { curtain.flipped() },
    );
    for x in [left - 0.06, right - 0.02] {
        assembly.add(
            materials.iron,
            &bevelled_box([x, 0.0, BACK], [x + 0.08, top + 0.1, BACK + 0.08], 0.006),
        );
    }
    assembly.add(
        materials.iron,
        &bevelled_box(
            [left - 0.1, top, BACK],
            [right + 0.1, top + 0.3, BACK + 0.24],
            0.015,
        ),
    );
    assembly.add(
        materials.yellow,
        &bevelled_box(
            [left + 0.02, 0.0, BACK + 0.02],
            [right - 0.02, 0.09, BACK + 0.07],
            0.006,
        ),
    );
    scene.place_assembly("shutter", assembly);
}
