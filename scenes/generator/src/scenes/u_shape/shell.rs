//! Floor, walls, ceiling, the lit window and the door.

use super::{BEND, CorridorMaterials, FAR, HEIGHT, INNER, NEAR, OUTER};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, cylinder, moulding, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};

pub(super) fn add(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    floor(scene, materials);
    walls(scene, materials);
    ceiling(scene, materials, detail);
    window(scene, materials);
    door(scene, materials, detail);
}

/// A checkerboard of dark and pale stone slabs, tilted slightly at random.
fn floor(scene: &mut Scene, materials: &CorridorMaterials) {
    /// Side of a slab.
    const SLAB: f64 = 0.6;
    let mut rng = Pcg32::new(11);
    let mut assembly = Assembly::default();
    let columns = (2.0 * OUTER / SLAB).round() as i32;
    let rows = ((NEAR - FAR) / SLAB).round() as i32;
    for row in 0..rows {
        for column in 0..columns {
            let x = -OUTER + SLAB * (f64::from(column) + 0.5);
            let z = FAR + SLAB * (f64::from(row) + 0.5);
            if x.abs() < INNER && z > BEND {
                continue;
            }
            let half = SLAB / 2.0 - 0.001;
            let slab = bevelled_box([-half, -0.02, -half], [half, 0.0, half], 0.0025);
            let pose = Pose::at(x, 0.0, z)
                .rolled(rng.jitter(0.06))
                .tilted(rng.jitter(0.06));
            assembly.add(
                materials.stone[((row + column) % 2) as usize],
                &slab.placed(pose),
            );
        }
    }
    let grout = boxed(
        [-OUTER - 0.1, -0.06, FAR - 0.1],
        [OUTER + 0.1, -0.003, NEAR + 0.1],
    );
    assembly.add(materials.backing, &grout);
    scene.place_assembly("floor", assembly);
}

/// Panels above a wainscot on each wall, with a post at both inner corners.
fn walls(scene: &mut Scene, materials: &CorridorMaterials) {
    let mut assembly = Assembly::default();
    for (start, end) in outline(0.0).iter().zip(&outline(0.0)[1..]) {
        let along = *end - *start;
        let turn = (-along.z).atan2(along.x).to_degrees();
        let inner = start.x.abs() < OUTER - 0.1 && end.x.abs() < OUTER - 0.1;
        let upper = if inner {
            materials.sage
        } else {
            materials.champagne
        };
        let wall = panels(materials, upper, along.length());
        assembly.add_placed(&wall, Pose::at(start.x, 0.0, start.z).turned(turn));
    }
    for x in [-INNER, INNER] {
        let half = 0.034;
        let post = bevelled_box(
            [x - half, 0.13, BEND - half],
            [x + half, 2.56, BEND + half],
            0.006,
        );
        assembly.add(materials.brass, &post);
    }
    mouldings(&mut assembly, materials);
    scene.place_assembly("wall", assembly);
}

/// Skirting, rail and cornice along all walls.
fn mouldings(assembly: &mut Assembly, materials: &CorridorMaterials) {
    let skirting = [
        (0.0, 0.001),
        (0.036, 0.001),
        (0.036, 0.1),
        (0.028, 0.125),
        (0.0, 0.125),
    ]
    .map(DVec2::from);
    let rail = [
        (0.0, 0.93),
        (0.04, 0.935),
        (0.046, 0.95),
        (0.04, 0.965),
        (0.0, 0.97),
    ]
    .map(DVec2::from);
    let cornice = [
        (0.0, 2.56),
        (0.03, 2.56),
        (0.034, 2.6),
        (0.055, 2.66),
        (0.1, 2.72),
        (0.16, 2.75),
        (0.165, 2.801),
        (0.0, 2.801),
    ]
    .map(DVec2::from);
    assembly.add(materials.walnut, &moulding(&skirting, &outline(0.0), 35.0));
    assembly.add(materials.brass, &moulding(&rail, &outline(0.0), 35.0));
    assembly.add(materials.plaster, &moulding(&cornice, &outline(0.0), 35.0));
}

/// The outline of the floor plan at height `y`, closed, with the room on the right.
fn outline(y: f64) -> Vec<DVec3> {
    [
        (-OUTER, NEAR),
        (-OUTER, FAR),
        (OUTER, FAR),
        (OUTER, NEAR),
        (INNER, NEAR),
        (INNER, BEND),
        (-INNER, BEND),
        (-INNER, NEAR),
        (-OUTER, NEAR),
    ]
    .map(|(x, z)| DVec3::new(x, y, z))
    .to_vec()
}

/// A panelled wall from x = 0 along x that faces z. `upper` is the material above the wainscot.
fn panels(materials: &CorridorMaterials, upper: MaterialId, length: f64) -> Assembly {
    /// Width kept free at both ends.
    const MARGIN: f64 = 0.032;
    let mut assembly = Assembly::default();
    assembly.add(
        materials.backing,
        &boxed([-0.05, 0.0, -0.05], [length + 0.05, HEIGHT, 0.0]),
    );
    let count = (length / 0.8).round().max(1.0) as usize;
    let width = (length - 2.0 * MARGIN) / count as f64;
    for i in 0..count {
        let left = MARGIN + width * i as f64 + 0.003;
        let right = left + width - 0.006;
        let wainscot = bevelled_box([left, 0.12, -0.01], [right, 0.935, 0.022], 0.005);
        assembly.add(materials.walnut, &wainscot);
        let panel = bevelled_box([left, 0.967, -0.01], [right, 2.57, 0.018], 0.005);
        assembly.add(upper, &panel);
    }
    assembly
}

/// Plaster and beams. The plaster overlaps the walls.
fn ceiling(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let (top, over) = (HEIGHT + 0.05, 0.1);
    for side in [-1.0, 1.0] {
        let (low, high) = if side < 0.0 {
            (-OUTER - over, -INNER + over)
        } else {
            (INNER - over, OUTER + over)
        };
        assembly.add(
            materials.plaster,
            &boxed([low, HEIGHT, BEND], [high, top, NEAR + over]),
        );
        for i in 0..4 {
            let z = 1.0 - 1.8 * f64::from(i);
            let (left, right) = (low + over + 0.1, high - over - 0.1);
            let beam = bevelled_box([left, 2.66, z - 0.07], [right, 2.81, z + 0.07], 0.008);
            assembly.add(materials.walnut, &beam);
        }
    }
    assembly.add(
        materials.plaster,
        &boxed(
            [-OUTER - over, HEIGHT, FAR - over],
            [OUTER + over, top, BEND],
        ),
    );
    downlights(&mut assembly, materials, detail);
    scene.place_assembly("ceiling", assembly);
}

/// Unlit lamps recessed in the ceiling.
fn downlights(assembly: &mut Assembly, materials: &CorridorMaterials, detail: Detail) {
    let ring = props::turned(
        &[
            (0.04, 0.0),
            (0.065, -0.004),
            (0.07, 0.006),
            (0.07, 0.006),
            (0.04, 0.006),
        ],
        2,
        detail.segments(20),
    );
    let disk = cylinder(0.045, 0.004, detail.segments(20));
    for x in [-1.8, 1.8] {
        for i in 0..3 {
            let pose = Pose::at(x, HEIGHT - 0.004, 0.1 - 1.8 * f64::from(i));
            assembly.add(materials.brass, &ring.placed(pose));
            assembly.add(materials.opal, &disk.placed(pose));
        }
    }
}

/// The only light, behind steel bars at the end of the right leg.
fn window(scene: &mut Scene, materials: &CorridorMaterials) {
    let mut frame = Mesh::default();
    for i in 0..4 {
        let x = 0.8 + 2.0 / 3.0 * f64::from(i);
        frame.append(&bevelled_box(
            [x - 0.02, 0.3, 2.12],
            [x + 0.02, 2.5, 2.165],
            0.004,
        ));
    }
    for y in [0.3, 1.4, 2.5] {
        frame.append(&bevelled_box(
            [0.78, y - 0.02, 2.121],
            [2.82, y + 0.02, 2.164],
            0.004,
        ));
    }
    scene.place_mesh("window_frame", frame, materials.black);
    scene.place_emitter(
        "window",
        ShapeKind::Rectangle,
        Pose::at(1.8, 1.4, 2.15)
            .turned(180.0)
            .stretched(1.0, 1.1, 1.0),
        materials.black,
        [400.0, 396.0, 390.0],
    );
}

/// A closed door in the left outer wall.
fn door(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.walnut,
        &bevelled_box([0.06, 0.0, 0.0], [0.94, 2.1, 0.05], 0.003),
    );
    for (low, high) in [(0.16, 0.86), (1.0, 1.98)] {
        assembly.add(
            materials.walnut,
            &bevelled_box([0.18, low, 0.04], [0.82, high, 0.062], 0.012),
        );
    }
    for (low, high) in [
        ([0.0, 0.0], [0.08, 2.2]),
        ([0.92, 0.0], [1.0, 2.2]),
        ([0.07, 2.11], [0.93, 2.2]),
    ] {
        let jamb = bevelled_box([low[0], low[1], 0.0], [high[0], high[1], 0.085], 0.006);
        assembly.add(materials.black, &jamb);
    }
    let rose = bevelled_cylinder(0.026, 0.008, 0.002, detail.segments(18));
    assembly.add(
        materials.brass,
        &rose.placed(Pose::at(0.14, 1.03, 0.049).tilted(90.0)),
    );
    let lever = [(0.14, 0.05), (0.14, 0.1), (0.155, 0.112), (0.26, 0.112)]
        .map(|(x, z)| DVec3::new(x, 1.03, z));
    assembly.add(
        materials.brass,
        &tube(&lever, detail.segments(10), |_| 0.009),
    );
    let pose = Pose::at(-OUTER, 0.0, -5.25).turned(90.0);
    scene.place_assembly("door", assembly.placed(pose));
}
