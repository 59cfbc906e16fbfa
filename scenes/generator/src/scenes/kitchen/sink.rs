//! The sink and its tap.

use super::{BACK, KitchenMaterials, WORKTOP};
use crate::build::{bevelled_box, catmull_rom, cylinder, tube};
use crate::pose::Pose;
use crate::scene::Assembly;
use crate::scenes::{Detail, props};
use glam::DVec3;

/// The opening in the worktop: lowest and highest x, lowest and highest z.
pub(super) const SINK: [f64; 4] = [-1.47, -0.88, BACK + 0.14, BACK + 0.54];

/// Adds a steel basin with a drain, and the tap.
pub(super) fn add(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right, rear, fore] = SINK;
    let (rim, floor) = (WORKTOP - 0.006, WORKTOP - 0.2);
    let thin = 0.006;
    for (low, high) in [
        (
            [left - thin, floor, rear - thin],
            [left + thin, rim, fore + thin],
        ),
        (
            [right - thin, floor, rear - thin],
            [right + thin, rim, fore + thin],
        ),
        ([left, floor, rear - thin], [right, rim, rear + thin]),
        ([left, floor, fore - thin], [right, rim, fore + thin]),
        (
            [left - thin, floor - thin, rear - thin],
            [right + thin, floor + thin, fore + thin],
        ),
    ] {
        assembly.add(materials.satin_steel, &bevelled_box(low, high, 0.002));
    }
    tap(assembly, materials, detail);
    let drain = cylinder(0.035, 0.004, detail.segments(18));
    assembly.add(
        materials.steel,
        &drain.placed(Pose::at(
            (left + right) / 2.0,
            floor + 0.006,
            (rear + fore) / 2.0,
        )),
    );
}

/// A tap with two levers behind the basin.
fn tap(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right, rear, _] = SINK;
    let x = (left + right) / 2.0;
    let foot = props::turned(
        &[
            (0.0, 0.0),
            (0.026, 0.0),
            (0.026, 0.0),
            (0.024, 0.01),
            (0.014, 0.02),
            (0.0, 0.02),
        ],
        2,
        detail.segments(18),
    );
    assembly.add(
        materials.steel,
        &foot.placed(Pose::at(x, WORKTOP, rear - 0.065)),
    );
    let neck = [
        (0.0, 0.0),
        (0.17, 0.0),
        (0.27, 0.03),
        (0.315, 0.1),
        (0.27, 0.17),
        (0.21, 0.19),
    ]
    .map(|(y, z)| DVec3::new(x, WORKTOP + 0.01 + y, rear - 0.065 + z));
    assembly.add(
        materials.steel,
        &tube(&catmull_rom(&neck, 6), detail.segments(12), |_| 0.011),
    );
    for side in [-1.0, 1.0] {
        let lever = [
            DVec3::new(x, WORKTOP + 0.05, rear - 0.065),
            DVec3::new(x + 0.075 * side, WORKTOP + 0.075, rear - 0.06),
        ];
        assembly.add(
            materials.steel,
            &tube(&lever, detail.segments(10), |t| 0.008 - 0.002 * t),
        );
    }
}
