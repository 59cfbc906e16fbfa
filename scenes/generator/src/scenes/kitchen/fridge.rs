//! The fridge and the cabinet above it.

use super::cabinets::{FRIDGE, framed_panel, handle};
use super::{BACK, HALF_WIDTH, KitchenMaterials};
use crate::build::{bevelled_box, bevelled_cylinder, boxed};
use crate::pose::Pose;
use crate::scene::Assembly;
use crate::scenes::Detail;

/// z of the front of the fridge.
const FRONT: f64 = BACK + 0.7;

/// Adds a steel fridge with two doors, notes on it, and a cabinet above.
pub(super) fn add(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let right = HALF_WIDTH - 0.03;
    assembly.add(
        materials.satin_steel,
        &boxed([FRIDGE, 0.05, BACK + 0.03], [right, 1.9, FRONT - 0.06]),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [FRIDGE + 0.02, 0.0, BACK + 0.05],
            [right - 0.02, 0.06, FRONT - 0.1],
        ),
    );
    for (low, high) in [(0.06, 0.68), (0.69, 1.9)] {
        assembly.add(
            materials.satin_steel,
            &bevelled_box([FRIDGE, low, FRONT - 0.055], [right, high, FRONT], 0.012),
        );
    }
    for (low, high) in [(0.36, 0.62), (0.78, 1.3)] {
        let bar = handle(detail, high - low).placed(Pose::identity().stretched(1.0, 1.0, 1.6));
        let pose = Pose::at(FRIDGE + 0.07, (low + high) / 2.0, FRONT).rolled(90.0);
        assembly.add(materials.steel, &bar.placed(pose));
    }
    notes(assembly, materials, detail);
    upper_cabinet(assembly, materials);
}

/// Notes under magnets.
fn notes(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    for (x, y, tilt, paper, magnet) in [
        (1.92, 1.42, 4.0, materials.linen, materials.red_enamel),
        (2.07, 1.36, -6.0, materials.lemon, materials.blue_glaze),
        (1.95, 1.22, -2.0, materials.cream_glaze, materials.black),
    ] {
        let note = bevelled_box([-0.055, -0.08, 0.0003], [0.055, 0.08, 0.0012], 0.0002);
        assembly.add(paper, &note.placed(Pose::at(x, y, FRONT).rolled(tilt)));
        let button = bevelled_cylinder(0.011, 0.008, 0.002, detail.segments(12));
        assembly.add(
            magnet,
            &button.placed(Pose::at(x, y + 0.06, FRONT).tilted(90.0)),
        );
    }
}

/// A cabinet above the fridge.
fn upper_cabinet(assembly: &mut Assembly, materials: &KitchenMaterials) {
    assembly.add(
        materials.lacquer,
        &boxed([FRIDGE - 0.01, 1.95, BACK], [HALF_WIDTH, 2.4, FRONT - 0.08]),
    );
    let mut door = Assembly::default();
    framed_panel(
        &mut door,
        materials.lacquer,
        [FRIDGE, 1.96],
        [HALF_WIDTH - 0.02, 2.39],
    );
    assembly.add_placed(&door, Pose::at(0.0, 0.0, FRONT - 0.08));
}
