//! Two oak shelves right of the stove.

use super::{BACK, KitchenMaterials};
use crate::build::bevelled_box;
use crate::scene::Assembly;

/// Heights of the undersides of the shelves.
pub(super) const SHELVES: [f64; 2] = [1.455, 1.85];

/// Adds the shelves with iron brackets.
pub(super) fn add(assembly: &mut Assembly, materials: &KitchenMaterials) {
    for y in SHELVES {
        let board = bevelled_box([0.95, y, BACK], [1.57, y + 0.03, BACK + 0.25], 0.003);
        assembly.add(materials.oak, &board.box_mapped(0.5));
        for x in [1.05, 1.47] {
            assembly.add(
                materials.iron,
                &bevelled_box(
                    [x - 0.012, y - 0.006, BACK],
                    [x + 0.012, y + 0.001, BACK + 0.22],
                    0.001,
                ),
            );
            assembly.add(
                materials.iron,
                &bevelled_box(
                    [x - 0.012, y - 0.13, BACK],
                    [x + 0.012, y, BACK + 0.014],
                    0.001,
                ),
            );
        }
    }
}
