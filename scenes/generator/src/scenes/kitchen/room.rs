//! Walls, floor, ceiling, tiles, window, daylight and lamps.

use super::{BACK, FRONT, HALF_WIDTH, HEIGHT, KitchenMaterials, WORKTOP, pick, tile};
use crate::build::{bevelled_box, boxed};
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind, SpotLight};
use glam::DVec3;

/// The window in the back wall: lowest and highest x, lowest and highest y.
const WINDOW: [f64; 4] = [-1.75, -0.6, 1.08, 2.16];
/// Thickness of the back wall.
const WALL: f64 = 0.22;
/// An opening in the right wall for the sun, outside the image: lowest and highest z, lowest and
/// highest y.
const SIDE: [f64; 4] = [1.55, 2.35, 0.95, 2.05];

/// Size of a wall tile with its joint.
const TILE: f64 = 0.105;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials) {
    shell(scene, materials);
    floor(scene, materials);
    backsplash(scene, materials);
    window(scene, materials);
    daylight(scene, materials);
    lamps(scene, materials);
}

/// Walls with two openings, the ceiling, oak beams and the window sill.
fn shell(scene: &mut Scene, materials: &KitchenMaterials) {
    let [left, right, sill, top] = WINDOW;
    let (outside, w) = (BACK - WALL, HALF_WIDTH);
    let mut assembly = Assembly::default();
    for (low, high) in [
        ([-w - 0.1, 0.0, outside], [left, HEIGHT, BACK]),
        ([right, 0.0, outside], [w + 0.1, HEIGHT, BACK]),
        ([left, 0.0, outside], [right, sill, BACK]),
        ([left, top, outside], [right, HEIGHT, BACK]),
        ([-w - 0.1, 0.0, BACK], [-w, HEIGHT, FRONT + 0.1]),
        ([w, 0.0, BACK], [w + 0.1, HEIGHT, SIDE[0]]),
        ([w, 0.0, SIDE[1]], [w + 0.1, HEIGHT, FRONT + 0.1]),
        ([w, 0.0, SIDE[0]], [w + 0.1, SIDE[2], SIDE[1]]),
        ([w, SIDE[3], SIDE[0]], [w + 0.1, HEIGHT, SIDE[1]]),
        ([-w, 0.0, FRONT], [w, HEIGHT, FRONT + 0.1]),
        (
            [-w - 0.1, HEIGHT, outside],
            [w + 0.1, HEIGHT + 0.1, FRONT + 0.1],
        ),
    ] {
        assembly.add(materials.plaster, &boxed(low, high));
    }
    for z in [-1.1, 0.35, 1.8] {
        let beam = bevelled_box(
            [-w - 0.02, HEIGHT - 0.16, z - 0.08],
            [w + 0.02, HEIGHT + 0.01, z + 0.08],
            0.01,
        );
        assembly.add(materials.oak, &beam.box_mapped(0.6));
    }
    assembly.add(
        materials.oak,
        &bevelled_box(
            [left - 0.03, sill - 0.03, outside],
            [right + 0.03, sill + 0.004, BACK + 0.03],
            0.004,
        )
        .box_mapped(0.6),
    );
    scene.place_assembly("room", assembly);
}

/// Square floor tiles, tilted slightly at random.
fn floor(scene: &mut Scene, materials: &KitchenMaterials) {
    /// Size of a floor tile with its joint.
    const SIZE: f64 = 0.3;
    let mut rng = Pcg32::new(21);
    let mut assembly = Assembly::default();
    let slab = tile(SIZE - 0.005, SIZE - 0.005, 0.006);
    let rows = ((FRONT - BACK) / SIZE).ceil() as i32;
    for row in 0..rows {
        for column in -8..8 {
            let pose = Pose::at(
                SIZE * (f64::from(column) + 0.5),
                -0.006,
                BACK + SIZE * (f64::from(row) + 0.5),
            )
            .tilted(-90.0 + rng.jitter(0.15));
            assembly.add(pick(materials.floor, &mut rng), &slab.placed(pose));
        }
    }
    let (w, bed) = (HALF_WIDTH + 0.1, -0.0035);
    assembly.add(
        materials.grout,
        &boxed([-w, -0.1, BACK - WALL], [w, bed, FRONT + 0.1]),
    );
    scene.place_assembly("floor", assembly);
}

/// Tiles on the back wall and the left wall above the worktop, tilted slightly at random.
fn backsplash(scene: &mut Scene, materials: &KitchenMaterials) {
    let mut rng = Pcg32::new(8);
    let mut assembly = Assembly::default();
    let glazed = tile(TILE - 0.003, TILE - 0.003, 0.008);
    let mut lay = |at: Pose, rng: &mut Pcg32| {
        let uneven = at.rolled(rng.jitter(0.5)).tilted(rng.jitter(0.7));
        let pose = Pose {
            turn: at.turn + rng.jitter(0.7),
            ..uneven
        };
        assembly.add(pick(materials.tiles, rng), &glazed.placed(pose));
    };
    for row in 0..16 {
        let y = WORKTOP + TILE * (f64::from(row) + 0.5);
        for column in 0..38 {
            let x = -HALF_WIDTH + TILE * (f64::from(column) + 0.5);
            if row < tile_rows(x) {
                lay(Pose::at(x, y, BACK), &mut rng);
            }
        }
        for column in 0..26 {
            if row < 5 {
                let z = BACK + TILE * (f64::from(column) + 0.5);
                lay(Pose::at(-HALF_WIDTH, y, z).turned(90.0), &mut rng);
            }
        }
    }
    grout(&mut assembly, materials);
    scene.place_assembly("backsplash", assembly);
}

/// Number of rows of tiles on the back wall at `x`: 1 below the window, 16 between window and
/// shelves, 5 elsewhere.
fn tile_rows(x: f64) -> u32 {
    if x > WINDOW[0] - 0.11 && x < WINDOW[1] + 0.11 {
        1
    } else if (-1.0..1.02).contains(&x) {
        16
    } else {
        5
    }
}

/// Grout between the tiles.
fn grout(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let h = WORKTOP + 5.0 * TILE;
    assembly.add(
        materials.grout,
        &boxed(
            [-HALF_WIDTH, WORKTOP, BACK - 0.01],
            [WINDOW[0] - 0.1, h, BACK + 0.0045],
        ),
    );
    assembly.add(
        materials.grout,
        &boxed(
            [WINDOW[0] - 0.11, WORKTOP, BACK - 0.01],
            [WINDOW[1] + 0.1, WORKTOP + TILE, BACK + 0.0045],
        ),
    );
    assembly.add(
        materials.grout,
        &boxed(
            [WINDOW[1] + 0.1, WORKTOP, BACK - 0.01],
            [1.02, HEIGHT, BACK + 0.0045],
        ),
    );
    assembly.add(
        materials.grout,
        &boxed([1.02, WORKTOP, BACK - 0.01], [1.6, h, BACK + 0.0045]),
    );
    assembly.add(
        materials.grout,
        &boxed(
            [-HALF_WIDTH - 0.01, WORKTOP, BACK],
            [-HALF_WIDTH + 0.0045, h, BACK + 26.0 * TILE],
        ),
    );
}

/// A painted window frame with bars.
fn window(scene: &mut Scene, materials: &KitchenMaterials) {
    let [left, right, sill, top] = WINDOW;
    let z = BACK - 0.13;
    let mut assembly = Assembly::default();
    let mut bar = |low: [f64; 2], high: [f64; 2], depth: f64| {
        let solid = bevelled_box(
            [low[0], low[1], z - depth],
            [high[0], high[1], z + depth],
            0.004,
        );
        assembly.add(materials.plaster, &solid);
    };
    let middle = (left + right) / 2.0;
    for x in [left, middle - 0.03, right - 0.06] {
        bar([x, sill], [x + 0.06, top], 0.03);
    }
    for y in [sill, top - 0.06] {
        bar([left + 0.01, y], [right - 0.01, y + 0.06], 0.028);
    }
    for x in [left, middle] {
        let center = x + (right - left) / 4.0;
        bar(
            [center - 0.011, sill + 0.01],
            [center + 0.011, top - 0.01],
            0.014,
        );
    }
    for part in [1.0, 2.0] {
        let y = sill + (top - sill) * part / 3.0;
        bar([left + 0.01, y - 0.011], [right - 0.01, y + 0.011], 0.013);
    }
    scene.place_assembly("window", assembly);
}

/// The sky outside the window, and the sun through the opening in the right wall.
fn daylight(scene: &mut Scene, materials: &KitchenMaterials) {
    let [left, right, sill, top] = WINDOW;
    let (x, y) = ((left + right) / 2.0, (sill + top) / 2.0);
    let (half_x, half_y) = ((right - left) / 2.0, (top - sill) / 2.0);
    scene.place_emitter(
        "sky",
        ShapeKind::Rectangle,
        Pose::at(x, y, BACK - WALL - 0.05).stretched(half_x + 0.25, half_y + 0.25, 1.0),
        materials.lamp,
        [1.0, 0.9, 0.78],
    );
    let opening = DVec3::new(
        HALF_WIDTH,
        (SIDE[2] + SIDE[3]) / 2.0,
        (SIDE[0] + SIDE[1]) / 2.0,
    );
    scene.spots.push(SpotLight {
        origin: opening + DVec3::new(7.0, 1.15, 2.9),
        target: opening,
        intensity: [2600.0, 1600.0, 760.0],
        cutoff: 7.0,
        beam: 6.5,
    });
}

/// Lamps under the shelf, the cabinets and the hood, and on top of the tall cabinets.
fn lamps(scene: &mut Scene, materials: &KitchenMaterials) {
    for (name, pose) in [
        (
            "shelf_lamp",
            Pose::at(1.24, 1.448, BACK + 0.12).stretched(0.28, 0.012, 1.0),
        ),
        (
            "left_lamp",
            Pose::at(-HALF_WIDTH + 0.14, 1.452, -0.75)
                .turned(90.0)
                .stretched(0.6, 0.012, 1.0),
        ),
        (
            "hood_lamp",
            Pose::at(0.4, 1.618, BACK + 0.25).stretched(0.16, 0.05, 1.0),
        ),
    ] {
        scene.place_emitter(
            name,
            ShapeKind::Rectangle,
            pose.tilted(90.0),
            materials.lamp,
            [46.0, 31.0, 17.0],
        );
    }
    // Towards the ceiling.
    for (name, pose) in [
        (
            "left_cove",
            Pose::at(-HALF_WIDTH + 0.15, 2.27, -0.75)
                .turned(90.0)
                .stretched(0.8, 0.03, 1.0),
        ),
        (
            "right_cove",
            Pose::at(2.0, 2.42, BACK + 0.35).stretched(0.33, 0.03, 1.0),
        ),
    ] {
        scene.place_emitter(
            name,
            ShapeKind::Rectangle,
            pose.tilted(-90.0),
            materials.lamp,
            [105.0, 80.0, 54.0],
        );
    }
}
