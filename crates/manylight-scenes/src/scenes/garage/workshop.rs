//! Benches, tools, shelves and what stands in them.

use super::{BACK, GarageMaterials, LEFT};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, extrude, torus, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    bench(scene, materials, detail);
    shelf(scene, materials, detail);
    tool_chest(scene, materials, detail);
    about(scene, materials, detail);
}

/// A bench with a vise under a board of tools, in the corner on the left of the back wall.
fn bench(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
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
    vise(
        &mut assembly,
        materials,
        detail,
        Pose::at(-3.75, 0.9, front - 0.13),
    );
    assembly.add(
        materials.blue,
        &bevelled_box([-5.2, 0.9, BACK + 0.2], [-4.85, 1.06, BACK + 0.4], 0.012),
    );
    let grip = [(-5.12, 1.05), (-5.12, 1.1), (-4.93, 1.1), (-4.93, 1.05)]
        .map(|(x, y)| DVec3::new(x, y, BACK + 0.3));
    assembly.add(materials.iron, &tube(&grip, 8, |_| 0.008));
    for (i, x) in [-4.6, -4.48, -4.37].into_iter().enumerate() {
        let can = bevelled_cylinder(0.05, 0.13 + 0.03 * i as f64, 0.004, detail.segments(24));
        assembly.add(
            [materials.cream, materials.galvanized, materials.red][i],
            &can.placed(Pose::at(x, 0.9, BACK + 0.2 + 0.05 * i as f64)),
        );
    }
    board(&mut assembly, materials, detail);
    scene.place_assembly("bench", assembly);
}

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

/// Wrenches, hammers and a saw on a painted board.
fn board(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let z = BACK + 0.035;
    assembly.add(
        materials.cream,
        &bevelled_box([-5.3, 1.25, BACK], [-3.4, 2.15, z], 0.005),
    );
    for i in 0..8 {
        let size = 0.16 + 0.022 * f64::from(i);
        let tool = extrude(&wrench(size), 0.008, 35.0);
        let x = -5.15 + 0.115 * f64::from(i);
        assembly.add(
            materials.iron,
            &tool.placed(Pose::at(x, 2.0 - size / 2.0, z + 0.008)),
        );
    }
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
    let blade = [(0.0, 0.0), (0.42, 0.05), (0.42, 0.08), (0.0, 0.13)].map(DVec2::from);
    assembly.add(
        materials.galvanized,
        &extrude(&blade, 0.004, 30.0).placed(Pose::at(-4.5, 1.42, z + 0.008)),
    );
    assembly.add(
        materials.red,
        &bevelled_box([-4.62, 1.41, z], [-4.49, 1.56, z + 0.022], 0.01),
    );
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
    let coil = torus(0.11, 0.012, detail.segments(28), 6);
    for i in 0..3 {
        assembly.add(
            materials.orange,
            &coil.placed(Pose::at(-5.05, 1.5, z + 0.014 + 0.022 * f64::from(i)).tilted(90.0)),
        );
    }
}

/// Outline of an open-ended wrench along y, `length` long.
fn wrench(length: f64) -> Vec<DVec2> {
    let w = 0.05 * length + 0.004;
    let h = length / 2.0;
    [
        (-w, -h + 1.6 * w),
        (-1.9 * w, -h + 0.5 * w),
        (-1.1 * w, -h - 0.6 * w),
        (-0.9 * w, -h + 0.9 * w),
        (0.9 * w, -h + 0.9 * w),
        (1.1 * w, -h - 0.6 * w),
        (1.9 * w, -h + 0.5 * w),
        (w, -h + 1.6 * w),
        (w, h - 1.6 * w),
        (1.9 * w, h - 0.5 * w),
        (1.1 * w, h + 0.6 * w),
        (0.9 * w, h - 0.9 * w),
        (-0.9 * w, h - 0.9 * w),
        (-1.1 * w, h + 0.6 * w),
        (-1.9 * w, h - 0.5 * w),
        (-w, h - 1.6 * w),
    ]
    .map(DVec2::from)
    .to_vec()
}

/// A steel shelf by the left wall with cans, boxes and bottles.
fn shelf(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let mut rng = Pcg32::new(44);
    let (x, depth, near, far) = (LEFT + 0.02, 0.42, -0.35, -2.35);
    for level in 0..5 {
        let y = 0.12 + 0.46 * f64::from(level);
        assembly.add(
            materials.galvanized,
            &bevelled_box([x, y - 0.03, far], [x + depth, y, near], 0.004),
        );
        if level < 4 {
            fill(
                &mut assembly,
                materials,
                detail,
                &mut rng,
                [x + depth / 2.0, y, far + 0.12],
                near - 0.12,
            );
        }
    }
    for (dx, z) in [(0.0, near), (depth, near), (0.0, far), (depth, far)] {
        assembly.add(
            materials.blue,
            &boxed(
                [x + dx - 0.015, 0.0, z - 0.015],
                [x + dx + 0.015, 2.05, z + 0.015],
            ),
        );
    }
    scene.place_assembly("shelf", assembly);
}

/// Stands things next to each other along z, from `start` to `end`.
fn fill(
    assembly: &mut Assembly,
    materials: &GarageMaterials,
    detail: Detail,
    rng: &mut Pcg32,
    start: [f64; 3],
    end: f64,
) {
    let [x, y, mut z] = start;
    let paints = [
        materials.red,
        materials.blue,
        materials.cream,
        materials.galvanized,
        materials.orange,
        materials.iron,
    ];
    loop {
        let paint: MaterialId = paints[rng.index(paints.len())];
        let kind = rng.index(3);
        let half = rng.range(0.05, [0.085, 0.16, 0.06][kind]);
        z += half;
        if z + half > end {
            return;
        }
        let at = Pose::at(x + rng.jitter(0.05), y, z).turned(rng.jitter(9.0));
        match kind {
            0 => {
                let height = half * rng.range(2.0, 2.7);
                assembly.add(
                    paint,
                    &bevelled_cylinder(half, height, 0.005, detail.segments(22)).placed(at),
                );
                let rim = torus(half - 0.002, 0.004, detail.segments(18), 4);
                assembly.add(
                    materials.galvanized,
                    &rim.placed(Pose {
                        position: at.position + DVec3::Y * (height - 0.004),
                        ..at
                    }),
                );
            }
            1 => {
                let height = rng.range(0.12, 0.3);
                assembly.add(
                    materials.card,
                    &bevelled_box(
                        [-0.15, 0.0, -half * 0.95],
                        [0.15, height, half * 0.95],
                        0.004,
                    )
                    .placed(at),
                );
            }
            _ => {
                let profile = [
                    (0.0, 0.0),
                    (1.0, 0.0),
                    (1.0, 0.0),
                    (1.0, 0.1),
                    (1.0, 2.6),
                    (0.75, 3.1),
                    (0.3, 3.4),
                    (0.3, 3.9),
                    (0.3, 3.9),
                    (0.0, 3.9),
                ];
                let scaled = profile.map(|(r, h)| (r * half, h * half));
                assembly.add(
                    paint,
                    &props::turned(&scaled, 2, detail.segments(20)).placed(at),
                );
            }
        }
        z += half + rng.range(0.01, 0.06);
    }
}

/// A red chest of drawers on casters, lid up, before the column at the back.
fn tool_chest(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.red,
        &bevelled_box([-0.36, 0.1, -0.22], [0.36, 0.98, 0.2], 0.008),
    );
    let mut y = 0.13;
    for height in [0.22, 0.15, 0.15, 0.1, 0.1, 0.08] {
        assembly.add(
            materials.red,
            &bevelled_box([-0.33, y, 0.19], [0.33, y + height - 0.012, 0.215], 0.005),
        );
        let bar = bevelled_box(
            [-0.3, y + height - 0.036, 0.212],
            [0.3, y + height - 0.018, 0.232],
            0.004,
        );
        assembly.add(materials.chrome, &bar);
        y += height;
    }
    for (x, z) in [(-0.3, -0.16), (0.3, -0.16), (-0.3, 0.14), (0.3, 0.14)] {
        let caster = bevelled_cylinder(0.05, 0.03, 0.006, detail.segments(18));
        assembly.add(
            materials.rubber,
            &caster.placed(Pose::at(x + 0.015, 0.05, z).rolled(90.0)),
        );
        assembly.add(
            materials.iron,
            &bevelled_box(
                [x - 0.02, 0.05, z - 0.02],
                [x + 0.02, 0.102, z + 0.02],
                0.003,
            ),
        );
    }
    assembly.add(
        materials.iron,
        &bevelled_box([-0.34, 0.981, -0.2], [0.34, 0.986, 0.18], 0.002),
    );
    let jug = bevelled_cylinder(0.06, 0.16, 0.008, detail.segments(22));
    assembly.add(
        materials.galvanized,
        &jug.placed(Pose::at(-0.2, 0.986, -0.03)),
    );
    for i in 0..3 {
        let tool = extrude(&wrench(0.2 + 0.02 * f64::from(i)), 0.008, 35.0);
        let pose = Pose::at(0.06 * f64::from(i) + 0.02, 0.992, 0.0)
            .tilted(90.0)
            .turned(12.0 * f64::from(i) - 8.0);
        assembly.add(materials.chrome, &tool.placed(pose));
    }
    scene.place_assembly(
        "chest",
        assembly.placed(Pose::at(-2.35, 0.0, -3.1).turned(24.0)),
    );
}

/// A drum, cones, a jack, a bucket.
fn about(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
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
        let band = crate::build::lathe(&band, detail.segments(24));
        assembly.add(materials.cream, &band.placed(Pose::at(x, 0.0, z)));
    }
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
            let angle = std::f64::consts::PI * f64::from(i) / 12.0;
            DVec3::new(
                0.142 * angle.cos(),
                0.27 - 0.06 * angle.sin(),
                0.13 * angle.sin(),
            )
        })
        .collect();
    assembly.add(materials.iron, &tube(&bail, 6, |_| 0.004).placed(at));
    scene.place_assembly("about", assembly);
}
