//! The table, two stools, and unlit pendant lamps above.

use super::{KitchenMaterials, TABLE_CENTER, TABLE_TOP, food};
use crate::build::{ball, bevelled_box, bevelled_cylinder, tube};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// Half the length and half the width of the table.
const HALF: (f64, f64) = (0.95, 0.42);

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    table(scene, materials, detail);
    food::add(scene, materials, detail);
    stools(scene, materials, detail);
    pendants(scene, materials, detail);
}

/// A table of oak boards.
fn table(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let boards = 5;
    let width = 2.0 * HALF.1 / f64::from(boards);
    for i in 0..boards {
        let z = -HALF.1 + width * f64::from(i);
        let board = bevelled_box(
            [-HALF.0, TABLE_TOP - 0.035, z + 0.0005],
            [HALF.0, TABLE_TOP, z + width - 0.0005],
            0.003,
        );
        // Each board shows another part of the texture.
        let mut mapped = board.box_mapped(0.7);
        for uv in &mut mapped.uvs {
            *uv += DVec2::new(0.37 * f64::from(i), 0.61 * f64::from(i));
        }
        assembly.add(materials.oak, &mapped);
    }
    legs(&mut assembly, materials, detail);
    apron(&mut assembly, materials);
    scene.place_assembly(
        "table",
        assembly.placed(Pose::at(TABLE_CENTER.0, 0.0, TABLE_CENTER.1)),
    );
}

/// Turned legs with square upper ends.
fn legs(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let (x, z) = (x * (HALF.0 - 0.09), z * (HALF.1 - 0.08));
        let leg = [
            (0.0, 0.0),
            (0.02, 0.0),
            (0.02, 0.0),
            (0.026, 0.12),
            (0.036, 0.42),
            (0.03, 0.5),
            (0.034, 0.52),
            (0.034, 0.52),
            (0.034, 0.61),
            (0.0, 0.61),
        ];
        let turned = props::turned(&leg, 3, detail.segments(20)).box_mapped(0.5);
        assembly.add(materials.oak, &turned.placed(Pose::at(x, 0.0, z)));
        assembly.add(
            materials.oak,
            &bevelled_box(
                [x - 0.035, 0.6, z - 0.035],
                [x + 0.035, TABLE_TOP - 0.034, z + 0.035],
                0.003,
            )
            .box_mapped(0.5),
        );
    }
}

/// The apron between the legs.
fn apron(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let (x, z) = (HALF.0 - 0.1, HALF.1 - 0.085);
    for side in [-1.0, 1.0] {
        assembly.add(
            materials.oak,
            &bevelled_box(
                [-x, 0.63, side * z - 0.011],
                [x, TABLE_TOP - 0.034, side * z + 0.011],
                0.002,
            )
            .box_mapped(0.5),
        );
        assembly.add(
            materials.oak,
            &bevelled_box(
                [side * x - 0.011, 0.631, -z],
                [side * x + 0.011, TABLE_TOP - 0.0345, z],
                0.002,
            )
            .box_mapped(0.5),
        );
    }
}

/// Two stools.
fn stools(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut stool = Assembly::default();
    let seat = [
        (0.0, 0.425),
        (0.15, 0.425),
        (0.165, 0.435),
        (0.165, 0.448),
        (0.15, 0.455),
        (0.06, 0.449),
        (0.0, 0.447),
    ];
    stool.add(
        materials.walnut,
        &props::turned(&seat, 2, detail.segments(32)),
    );
    for i in 0..4 {
        let side = DVec3::X.rotate_y((f64::from(i) + 0.5) * FRAC_PI_2);
        let leg = [side * 0.185, side * 0.11 + DVec3::Y * 0.428];
        stool.add(
            materials.walnut,
            &tube(&leg, detail.segments(10), |t| 0.011 + 0.004 * t),
        );
        let next = side.rotate_y(FRAC_PI_2);
        let height = 0.14 + 0.03 * f64::from(i % 2);
        let on_leg = |s: DVec3| s * (0.185 - 0.075 * height / 0.428) + DVec3::Y * height;
        stool.add(
            materials.walnut,
            &tube(&[on_leg(side), on_leg(next)], 8, |_| 0.007),
        );
    }
    let poses = [(-0.78, 1.42, 10.0), (0.55, 0.02, 40.0)]
        .map(|(x, z, turn)| Pose::at(x, 0.0, z).turned(turn));
    scene.place_copies("stool", stool, &poses);
}

/// Two unlit lamps with copper shades on cords.
fn pendants(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let shade = [
        (0.16, 0.0),
        (0.15, 0.05),
        (0.1, 0.11),
        (0.03, 0.14),
        (0.025, 0.17),
        (0.025, 0.17),
        (0.0, 0.172),
        (0.0, 0.172),
        (0.0, 0.145),
        (0.0, 0.145),
        (0.03, 0.135),
        (0.098, 0.106),
        (0.146, 0.048),
        (0.156, 0.0),
        (0.156, 0.0),
        (0.16, 0.0),
    ];
    let shade = scene.add_mesh(
        "pendant_shade",
        props::turned(&shade, 3, detail.segments(36)),
    );
    let mut assembly = Assembly::default();
    for (i, x) in [-0.5, 0.25].into_iter().enumerate() {
        let pose = Pose::at(TABLE_CENTER.0 + x, 1.68, TABLE_CENTER.1 - 0.1);
        scene.place(
            &format!("pendant_{i}"),
            ShapeKind::Mesh(shade),
            pose,
            materials.copper,
        );
        assembly.add(
            materials.cream_glaze,
            &ball(0.04, detail.segments(16)).placed(pose.lifted(0.075)),
        );
        assembly.add(
            materials.brass,
            &bevelled_cylinder(0.016, 0.06, 0.002, 14).placed(pose.lifted(0.095)),
        );
        let cord = [DVec3::Y * 0.17, DVec3::Y * 0.925].map(|p| p + pose.position);
        assembly.add(materials.black, &tube(&cord, 6, |_| 0.003));
    }
    scene.place_assembly("pendant", assembly);
}
