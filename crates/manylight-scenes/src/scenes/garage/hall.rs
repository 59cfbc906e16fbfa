//! Concrete, pipes, the roller shutter and marks on the floor.

use super::{BACK, FRONT, GarageMaterials, HEIGHT, LEFT, RIGHT};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, torus, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene, ShapeKind};
use crate::scenes::Detail;
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    shell(scene, materials);
    columns(scene, materials);
    marks(scene, materials);
    pipes(scene, materials, detail);
    shutter(scene, materials, detail);
}

/// How much of a wall one repetition of the concrete covers.
const CONCRETE: f64 = 3.4;

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
    // Beams across the hall, deeper ones over the columns.
    for x in [-3.0, 0.6, 4.2] {
        let beam = bevelled_box(
            [x - 0.16, HEIGHT - 0.32, BACK - 0.02],
            [x + 0.16, HEIGHT + 0.05, FRONT + 0.02],
            0.012,
        );
        assembly.add(materials.concrete, &beam.box_mapped(CONCRETE));
    }
    // Glossy paint to the height of a hand, with a line above it.
    for (low, high) in [
        ([LEFT, 0.0, BACK], [RIGHT, 1.0, BACK + 0.004]),
        ([LEFT, 0.0, BACK], [LEFT + 0.004, 1.0, FRONT]),
        ([RIGHT - 0.004, 0.0, BACK], [RIGHT, 1.0, FRONT]),
    ] {
        assembly.add(materials.dado, &boxed(low, high));
        let lift = |p: [f64; 3], y: f64| [p[0], y, p[2]];
        assembly.add(materials.cream, &boxed(lift(low, 1.0), lift(high, 1.06)));
    }
    scene.place_assembly("hall", assembly);
}

/// Square columns with painted feet.
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

/// Lines that bound the place where the car stands.
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

/// A pipe along a path, in the given material.
fn pipe(
    assembly: &mut Assembly,
    material: MaterialId,
    detail: Detail,
    radius: f64,
    path: &[[f64; 3]],
) {
    let path: Vec<DVec3> = path.iter().copied().map(DVec3::from).collect();
    assembly.add(
        material,
        &tube(
            &rounded_corners(&path, radius * 2.5),
            detail.segments(12),
            |_| radius,
        ),
    );
}

/// The path with each corner replaced by an arc of a few points.
fn rounded_corners(path: &[DVec3], reach: f64) -> Vec<DVec3> {
    let last = path.len() - 1;
    let mut smooth = vec![path[0]];
    for i in 1..last {
        let corner = path[i];
        let from = corner + (path[i - 1] - corner).normalize() * reach;
        let to = corner + (path[i + 1] - corner).normalize() * reach;
        smooth.extend((0..=4).map(|k| {
            let t = f64::from(k) / 4.0;
            from.lerp(corner, t).lerp(corner.lerp(to, t), t)
        }));
    }
    smooth.push(path[last]);
    smooth
}

fn pipes(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let under = HEIGHT - 0.42;
    pipe(
        &mut assembly,
        materials.red,
        detail,
        0.045,
        &[[LEFT, under, -1.6], [RIGHT, under, -1.6]],
    );
    pipe(
        &mut assembly,
        materials.copper,
        detail,
        0.022,
        &[
            [LEFT, under, -1.42],
            [1.4, under, -1.42],
            [1.4, under, BACK + 0.1],
            [1.4, 0.3, BACK + 0.1],
        ],
    );
    pipe(
        &mut assembly,
        materials.copper,
        detail,
        0.022,
        &[
            [LEFT, under, -1.35],
            [1.5, under, -1.35],
            [1.5, under, BACK + 0.1],
            [1.5, 0.3, BACK + 0.1],
        ],
    );
    pipe(
        &mut assembly,
        materials.galvanized,
        detail,
        0.03,
        &[
            [-2.2, 0.0, BACK + 0.06],
            [-2.2, 2.1, BACK + 0.06],
            [LEFT + 0.06, 2.1, BACK + 0.06],
            [LEFT + 0.06, 2.1, FRONT],
        ],
    );
    let duct = tube(
        &[
            DVec3::new(-1.3, HEIGHT - 0.55, BACK),
            DVec3::new(-1.3, HEIGHT - 0.55, FRONT),
        ],
        detail.segments(28),
        |_| 0.2,
    );
    assembly.add(materials.galvanized, &duct);
    let ring = torus(0.205, 0.012, detail.segments(28), 6);
    for i in 0..8 {
        let z = BACK + 0.6 + 1.2 * f64::from(i);
        assembly.add(
            materials.galvanized,
            &ring.placed(Pose::at(-1.3, HEIGHT - 0.55, z).tilted(90.0)),
        );
        // Each ring hangs from the ceiling on a rod.
        let rod = [
            DVec3::new(-1.3, HEIGHT - 0.34, z),
            DVec3::new(-1.3, HEIGHT, z),
        ];
        assembly.add(materials.iron, &tube(&rod, 6, |_| 0.006));
    }
    for i in 0..5 {
        let x = -4.6 + 2.2 * f64::from(i);
        assembly.add(
            materials.iron,
            &bevelled_box(
                [x - 0.02, under + 0.03, -1.66],
                [x + 0.02, HEIGHT, -1.54],
                0.004,
            ),
        );
    }
    let wheel = torus(0.075, 0.011, detail.segments(24), 8);
    assembly.add(
        materials.red,
        &wheel.placed(Pose::at(1.45, 1.35, BACK + 0.19).tilted(90.0)),
    );
    assembly.add(
        materials.brass,
        &bevelled_box([1.37, 1.3, BACK + 0.06], [1.53, 1.4, BACK + 0.14], 0.01),
    );
    let hub = bevelled_cylinder(0.012, 0.07, 0.002, 12);
    assembly.add(
        materials.brass,
        &hub.placed(Pose::at(1.45, 1.35, BACK + 0.13).tilted(90.0)),
    );
    for turn in [0.0, 90.0] {
        let spoke = bevelled_box([-0.07, -0.006, -0.004], [0.07, 0.006, 0.004], 0.002);
        assembly.add(
            materials.red,
            &spoke.placed(Pose::at(1.45, 1.35, BACK + 0.19).rolled(turn)),
        );
    }
    scene.place_assembly("pipe", assembly);
}

/// A shutter of ribbed metal in the back wall.
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
    let curtain: Mesh = crate::build::grid(&slat, crate::build::Edges::Open, 60.0);
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
