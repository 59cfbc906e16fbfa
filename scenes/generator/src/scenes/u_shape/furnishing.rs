//! Furniture, plants, unlit wall lamps and a painting.

use super::{CorridorMaterials, FAR, INNER, OUTER};
use crate::build::{
    bevelled_box, bevelled_cylinder, boxed, catmull_rom, cylinder, superellipsoid, tube,
};
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::DVec3;
use std::f64::consts::TAU;

pub(super) fn add(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    bench(scene, materials, detail);
    console(scene, materials, detail);
    sculpture(scene, materials, detail);
    plants(scene, materials, detail);
    sconces(scene, materials, detail);
    painting(scene, materials);
}

/// A leather bench at the left outer wall.
fn bench(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let seat = superellipsoid([0.285, 0.065, 0.235], 0.3, 0.22, detail.segments(36));
    let back = superellipsoid([0.285, 0.17, 0.055], 0.25, 0.3, detail.segments(36));
    for i in [-1.0, 0.0, 1.0] {
        assembly.add(
            materials.leather,
            &seat.placed(Pose::at(0.565 * i, 0.405, 0.0)),
        );
        assembly.add(
            materials.leather,
            &back.placed(Pose::at(0.565 * i, 0.62, -0.19).tilted(-8.0)),
        );
    }
    assembly.add(
        materials.walnut,
        &bevelled_box([-0.87, 0.29, -0.24], [0.87, 0.35, 0.24], 0.008),
    );
    for x in [-0.8, 0.8] {
        for z in [-0.18, 0.18] {
            let leg = tube(
                &[DVec3::new(x * 1.03, 0.0, z * 1.1), DVec3::new(x, 0.295, z)],
                detail.segments(12),
                |t| 0.011 + 0.008 * t,
            );
            assembly.add(materials.brass, &leg);
        }
    }
    scene.place_assembly(
        "bench",
        assembly.placed(Pose::at(-OUTER + 0.31, 0.0, -2.35).turned(90.0)),
    );
}

/// A narrow table at the left inner wall with a vase, a bowl and books.
fn console(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.black,
        &bevelled_box([-0.6, 0.78, -0.16], [0.6, 0.81, 0.16], 0.005),
    );
    assembly.add(
        materials.black,
        &bevelled_box([-0.52, 0.16, -0.12], [0.52, 0.175, 0.12], 0.003),
    );
    for x in [-0.54, 0.54] {
        for z in [-0.12, 0.12] {
            let leg = bevelled_box(
                [x - 0.011, 0.0, z - 0.011],
                [x + 0.011, 0.781, z + 0.011],
                0.002,
            );
            assembly.add(materials.brass, &leg);
        }
    }
    assembly.add(
        materials.glaze,
        &props::vase(detail).placed(Pose::at(-0.38, 0.81, 0.0).scaled(1.15)),
    );
    assembly.add(
        materials.bronze,
        &props::bowl(detail).placed(Pose::at(0.36, 0.81, 0.0).scaled(0.85)),
    );
    let books = props::lying_books(3, &mut Pcg32::new(5));
    for (i, book) in books.iter().enumerate() {
        assembly.add(
            materials.cover[i % 2],
            &book.placed(Pose::at(-0.02, 0.81, 0.0)),
        );
    }
    let lower = props::lying_books(2, &mut Pcg32::new(6));
    for (i, book) in lower.iter().enumerate() {
        assembly.add(
            materials.cover[(i + 1) % 2],
            &book.placed(Pose::at(0.2, 0.175, 0.0).turned(80.0)),
        );
    }
    scene.place_assembly(
        "console",
        assembly.placed(Pose::at(-INNER - 0.22, 0.0, -3.3).turned(-90.0)),
    );
}

/// A bronze knot on a plinth at the bend, and brass fins on the wall behind it.
fn sculpture(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let pieces = detail.segments(150);
    let knot: Vec<DVec3> = (0..=pieces)
        .map(|i| {
            let t = TAU * (i % pieces) as f64 / pieces as f64;
            let r = 0.2 + 0.085 * (3.0 * t).cos();
            DVec3::new(
                r * (2.0 * t).cos(),
                r * (2.0 * t).sin(),
                0.11 * (3.0 * t).sin(),
            )
        })
        .collect();
    let mut assembly = Assembly::default();
    let body = tube(&knot, detail.segments(14), |_| 0.047);
    assembly.add(
        materials.bronze,
        &body.placed(Pose::at(-1.72, 1.325, -6.3).turned(24.0)),
    );
    let base = bevelled_cylinder(0.09, 0.03, 0.004, detail.segments(28));
    assembly.add(materials.black, &base.placed(Pose::at(-1.72, 1.0, -6.3)));
    assembly.add(
        materials.stone[1],
        &bevelled_box([-1.95, 0.0, -6.53], [-1.49, 1.0, -6.07], 0.008),
    );
    for i in 0..19 {
        let x = -2.88 + 0.12 * f64::from(i);
        let fin = bevelled_box(
            [x - 0.008, 0.98, FAR],
            [x + 0.008, 2.55, FAR + 0.075],
            0.003,
        );
        assembly.add(materials.brass, &fin);
    }
    scene.place_assembly("sculpture", assembly);
}

/// Plants in glazed pots.
fn plants(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut rng = Pcg32::new(3);
    let pot = scene.add_mesh("pot", props::pot(detail));
    let soil = scene.add_mesh("soil", cylinder(0.141, 0.02, detail.segments(24)));
    let leaves = detail.count(30).min(240);
    let tuft = scene.add_mesh(
        "strap_plant",
        props::strap_plant(leaves, 0.85, 0.6, &mut rng),
    );
    for (i, (x, z, scale, turn)) in [
        (-1.08, -0.75, 1.1, 0.0),
        (-2.4, -4.3, 1.2, 140.0),
        (0.0, -6.83, 1.15, 70.0),
    ]
    .into_iter()
    .enumerate()
    {
        let stand = Pose::at(x, 0.0, z).scaled(scale);
        let pose = stand.turned(turn);
        let glaze = if i == 1 {
            materials.opal
        } else {
            materials.glaze
        };
        scene.place(&format!("pot_{i}"), ShapeKind::Mesh(pot), stand, glaze);
        scene.place(
            &format!("soil_{i}"),
            ShapeKind::Mesh(soil),
            pose.lifted(0.3 * scale),
            materials.soil,
        );
        scene.place(
            &format!("plant_{i}"),
            ShapeKind::Mesh(tuft),
            pose.lifted(0.31 * scale),
            materials.leaf,
        );
    }
}

/// Unlit wall lamps.
fn sconces(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let shade = props::turned(
        &[
            (0.03, 0.0),
            (0.06, 0.02),
            (0.085, 0.08),
            (0.09, 0.15),
            (0.09, 0.15),
            (0.086, 0.15),
            (0.086, 0.15),
            (0.081, 0.08),
            (0.056, 0.024),
            (0.0, 0.01),
        ],
        3,
        detail.segments(24),
    );
    assembly.add(materials.opal, &shade.placed(Pose::at(0.0, 1.72, 0.135)));
    let cup = props::turned(
        &[
            (0.0, -0.02),
            (0.03, -0.015),
            (0.045, 0.012),
            (0.045, 0.012),
            (0.0, 0.012),
        ],
        3,
        detail.segments(20),
    );
    assembly.add(materials.brass, &cup.placed(Pose::at(0.0, 1.72, 0.135)));
    assembly.add(
        materials.brass,
        &bevelled_box([-0.035, 1.6, 0.0], [0.035, 1.84, 0.026], 0.005),
    );
    let arm = [(1.66, 0.02), (1.655, 0.09), (1.67, 0.125), (1.705, 0.135)]
        .map(|(y, z)| DVec3::new(0.0, y, z));
    assembly.add(
        materials.brass,
        &tube(&catmull_rom(&arm, 4), detail.segments(10), |_| 0.008),
    );

    let mut placed = Assembly::default();
    for z in [-0.9, -2.2, -4.4] {
        placed.add_placed(&assembly, Pose::at(-INNER, 0.0, z).turned(-90.0));
    }
    for z in [-1.15, -3.65] {
        placed.add_placed(&assembly, Pose::at(-OUTER, 0.0, z).turned(90.0));
    }
    for x in [-0.3, 1.4] {
        placed.add_placed(&assembly, Pose::at(x, 0.0, FAR));
    }
    scene.place_assembly("sconce", placed);
}

/// A painting in a black frame on the left outer wall.
fn painting(scene: &mut Scene, materials: &CorridorMaterials) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.black,
        &bevelled_box([-0.5, 1.2, 0.0], [0.5, 1.95, 0.045], 0.004),
    );
    assembly.add(
        materials.plaster,
        &bevelled_box([-0.47, 1.23, 0.01], [0.47, 1.92, 0.047], 0.001),
    );
    for (material, low, high) in [
        (materials.glaze, [-0.36, 1.34], [0.02, 1.81]),
        (materials.cover[0], [0.05, 1.34], [0.36, 1.58]),
        (materials.cover[1], [0.05, 1.61], [0.36, 1.81]),
    ] {
        assembly.add(
            material,
            &boxed([low[0], low[1], 0.02], [high[0], high[1], 0.0475]),
        );
    }
    scene.place_assembly(
        "painting",
        assembly.placed(Pose::at(-OUTER + 0.015, 0.0, -2.4).turned(90.0)),
    );
}
