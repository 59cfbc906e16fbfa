//! The range and its hood.

use super::cabinets::STOVE;
use super::{BACK, HOBS, KitchenMaterials, WORKTOP, WORKTOP_FRONT, cookware};
use crate::build::{Edges, bevelled_box, bevelled_cylinder, boxed, grid, loft, torus, tube};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::Detail;
use glam::DVec3;

/// z of the front of the range.
const RANGE_FRONT: f64 = WORKTOP_FRONT - 0.03;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    range(&mut assembly, materials, detail);
    hood(&mut assembly, materials);
    cookware::add(&mut assembly, materials, detail);
    scene.place_assembly("stove", assembly);
}

/// A steel range with an oven and a glass top.
fn range(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right] = STOVE;
    let front = RANGE_FRONT;
    assembly.add(
        materials.satin_steel,
        &boxed([left, 0.09, BACK + 0.01], [right, 0.9, front - 0.03]),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [left + 0.03, 0.0, BACK + 0.05],
            [right - 0.03, 0.1, front - 0.08],
        ),
    );
    range_front(assembly, materials);
    oven_handle(assembly, materials, detail);
    knobs(assembly, materials, detail);
    let grate = torus(0.085, 0.005, detail.segments(24), 6);
    for (x, z) in HOBS {
        assembly.add(
            materials.iron,
            &grate.placed(Pose::at(x, WORKTOP + 0.009, z)),
        );
    }
}

/// The panels of the front, the oven window and the glass top.
fn range_front(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let [left, right] = STOVE;
    let front = RANGE_FRONT;
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left, 0.79, front - 0.05],
            [right, 0.905, front + 0.01],
            0.006,
        ),
    );
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left + 0.004, 0.27, front - 0.04],
            [right - 0.004, 0.782, front],
            0.006,
        ),
    );
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left + 0.004, 0.1, front - 0.04],
            [right - 0.004, 0.262, front - 0.002],
            0.006,
        ),
    );
    assembly.add(
        materials.black,
        &bevelled_box(
            [left + 0.13, 0.36, front - 0.01],
            [right - 0.13, 0.64, front + 0.003],
            0.002,
        ),
    );
    assembly.add(
        materials.black,
        &bevelled_box(
            [left, 0.895, BACK + 0.02],
            [right, WORKTOP + 0.004, front - 0.02],
            0.003,
        ),
    );
}

/// A bar on the oven door with a towel over it.
fn oven_handle(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right] = STOVE;
    let front = RANGE_FRONT;
    let width = right - left;
    let middle = (left + right) / 2.0;
    let half = width / 2.0 - 0.06;
    let bar = [(-half, 0.0), (-half, 0.045), (half, 0.045), (half, 0.0)]
        .map(|(x, z)| DVec3::new(middle + x, 0.72, front + z));
    assembly.add(materials.steel, &tube(&bar, detail.segments(10), |_| 0.009));
    towel(
        assembly,
        materials,
        detail,
        DVec3::new(middle + 0.17, 0.72, front + 0.045),
    );
}

/// A row of six knobs.
fn knobs(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right] = STOVE;
    let width = right - left;
    let knob = bevelled_cylinder(0.02, 0.026, 0.004, detail.segments(18));
    for i in 0..6 {
        let x = left + 0.1 + (width - 0.2) * f64::from(i) / 5.0;
        assembly.add(
            materials.steel,
            &knob.placed(Pose::at(x, 0.848, RANGE_FRONT + 0.008).tilted(90.0)),
        );
    }
}

/// A striped towel that hangs over a bar at a point `over` of its axis.
fn towel(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail, over: DVec3) {
    let columns = detail.segments(16);
    // Profile (height, depth) from the front hem over the bar to the back hem.
    let profile = [
        (-0.33, 0.016),
        (-0.3, 0.016),
        (-0.27, 0.016),
        (-0.15, 0.015),
        (-0.04, 0.013),
        (0.006, 0.008),
        (0.0115, 0.0),
        (0.006, -0.008),
        (-0.04, -0.013),
        (-0.22, -0.014),
    ];
    let row = |&(y, z): &(f64, f64)| -> Vec<DVec3> {
        (0..=columns)
            .map(|i| {
                let u = i as f64 / columns as f64;
                // Folds deepen below the bar, only in the front half.
                let fold = 0.014 * (-y).max(0.0) / 0.33 * (1.0 + (u * 15.0).sin());
                over + DVec3::new(0.2 * (u - 0.5), y, z + fold * z.signum().max(0.0))
            })
            .collect()
    };
    let rows: Vec<Vec<DVec3>> = profile.iter().map(row).collect();
    let cloth = |rows: &[Vec<DVec3>]| grid(rows, Edges::Open, 60.0);
    assembly.add(materials.linen, &cloth(&rows[..2]));
    assembly.add(materials.blue_glaze, &cloth(&rows[1..3]));
    assembly.add(materials.linen, &cloth(&rows[2..]));
}

/// A copper hood with a chimney.
fn hood(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let middle = (STOVE[0] + STOVE[1]) / 2.0;
    let ring = |half: f64, depth: f64, y: f64| {
        let (low, high) = (middle - half, middle + half);
        let (rear, front) = (BACK + 0.01, BACK + depth);
        [(low, rear), (low, front), (high, front), (high, rear)]
            .map(|(x, z)| DVec3::new(x, y, z))
            .to_vec()
    };
    let body = [
        ring(0.45, 0.5, 1.63),
        ring(0.45, 0.5, 1.7),
        ring(0.435, 0.485, 1.71),
        ring(0.33, 0.4, 1.86),
        ring(0.22, 0.31, 2.06),
        ring(0.16, 0.26, 2.22),
        ring(0.15, 0.25, 2.45),
        ring(0.15, 0.25, 2.62),
    ];
    assembly.add(materials.copper, &loft(&body, 28.0));
    for y in [1.645, 1.69] {
        let (low, high) = (middle - 0.453, middle + 0.453);
        assembly.add(
            materials.brass,
            &bevelled_box(
                [low, y - 0.007, BACK + 0.012],
                [high, y + 0.007, BACK + 0.504],
                0.002,
            ),
        );
    }
}
