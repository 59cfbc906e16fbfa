//! Cabinets and worktops.

use super::sink::SINK;
use super::{BACK, HALF_WIDTH, KitchenMaterials, WORKTOP, WORKTOP_FRONT};
use crate::build::{bevelled_box, boxed, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene};
use crate::scenes::{Detail, props};
use glam::DVec3;

/// x of the left and right end of the stove.
pub(super) const STOVE: [f64; 2] = [-0.05, 0.85];
/// x of the left side of the fridge.
pub(super) const FRIDGE: f64 = 1.62;
/// Height of the upper edge of the fronts below the worktop.
const FRONT_TOP: f64 = WORKTOP - 0.045;
/// Height of the toe space below the cabinets.
const TOE: f64 = 0.1;
/// x of the left end of the fronts at the back wall, right of the cabinets at the left wall.
const BACK_LEFT: f64 = -HALF_WIDTH + 0.62;
/// z of the front of the cabinets at the back wall.
const CABINET_FRONT: f64 = WORKTOP_FRONT - 0.045;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    carcasses(&mut assembly, materials);
    lower_fronts(&mut assembly, materials, detail);
    worktops(&mut assembly, materials);
    assembly.add_placed(
        &wall_cabinets(materials, detail),
        Pose::at(-HALF_WIDTH, 0.0, BACK + 2.15).turned(90.0),
    );
    scene.place_assembly("unit", assembly);
}

/// Bodies of the lower cabinets at the back wall and the left wall.
fn carcasses(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let mut carcass = |low: [f64; 2], high: [f64; 2], top: f64| {
        assembly.add(
            materials.lacquer,
            &boxed([low[0], TOE, low[1]], [high[0], top, high[1]]),
        );
        assembly.add(
            materials.iron,
            &boxed([low[0], 0.0, low[1]], [high[0], TOE + 0.01, high[1] - 0.05]),
        );
    };
    let top = FRONT_TOP + 0.005;
    // The cabinet below the sink is lower, because the sink hangs into it.
    let (sink_left, sink_right) = (SINK[0] - 0.02, SINK[1] + 0.02);
    carcass([-HALF_WIDTH, BACK], [sink_left, CABINET_FRONT], top);
    carcass([sink_left, BACK], [sink_right, CABINET_FRONT], 0.69);
    carcass([sink_right, BACK], [STOVE[0] - 0.004, CABINET_FRONT], top);
    carcass(
        [STOVE[1] + 0.004, BACK],
        [FRIDGE - 0.02, CABINET_FRONT],
        top,
    );
    assembly.add(
        materials.lacquer,
        &boxed(
            [-HALF_WIDTH, TOE, BACK],
            [BACK_LEFT - 0.045, FRONT_TOP + 0.005, 0.5],
        ),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [-HALF_WIDTH, 0.0, BACK],
            [BACK_LEFT - 0.095, TOE + 0.01, 0.48],
        ),
    );
}

/// Doors and drawers of the lower cabinets.
fn lower_fronts(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    for (left, width, kind) in [
        (BACK_LEFT + 0.03, 0.56, CabinetFront::Door),
        (BACK_LEFT + 0.6, 0.56, CabinetFront::Door),
        (BACK_LEFT + 1.17, 0.54, CabinetFront::Drawers),
    ] {
        let pose = Pose::at(left, 0.0, CABINET_FRONT);
        assembly.add_placed(&unit_front(materials, detail, width, kind), pose);
    }
    let right = STOVE[1] + 0.012;
    assembly.add_placed(
        &unit_front(
            materials,
            detail,
            FRIDGE - 0.04 - right,
            CabinetFront::Drawers,
        ),
        Pose::at(right, 0.0, CABINET_FRONT),
    );
    for i in 0..3 {
        let kind = if i == 1 {
            CabinetFront::Drawers
        } else {
            CabinetFront::Door
        };
        let pose = Pose::at(BACK_LEFT - 0.045, 0.0, 0.48 - 0.585 * f64::from(i)).turned(90.0);
        assembly.add_placed(&unit_front(materials, detail, 0.575, kind), pose);
    }
}

/// The kind of front of a lower cabinet.
#[derive(Clone, Copy)]
enum CabinetFront {
    Door,
    Drawers,
}

/// The front of a lower cabinet of a width, from x = 0 in the plane z = 0.
fn unit_front(
    materials: &KitchenMaterials,
    detail: Detail,
    width: f64,
    kind: CabinetFront,
) -> Assembly {
    let mut assembly = Assembly::default();
    let rows: &[(f64, f64)] = match kind {
        CabinetFront::Door => &[(TOE + 0.01, FRONT_TOP - 0.005)],
        CabinetFront::Drawers => &[
            (TOE + 0.01, 0.39),
            (0.396, 0.655),
            (0.661, FRONT_TOP - 0.005),
        ],
    };
    for &(low, high) in rows {
        framed_panel(
            &mut assembly,
            materials.lacquer,
            [0.003, low],
            [width - 0.003, high],
        );
        match kind {
            CabinetFront::Door => {
                let pose = Pose::at(width - 0.04, high - 0.09, 0.02).tilted(90.0);
                assembly.add(materials.brass, &knob(detail).placed(pose));
            }
            CabinetFront::Drawers => assembly.add(
                materials.brass,
                &handle(detail, 0.14).placed(Pose::at(width / 2.0, high - 0.045, 0.02)),
            ),
        }
    }
    assembly
}

/// A panel framed by four rails, between two corners (x, y).
pub(super) fn framed_panel(
    assembly: &mut Assembly,
    material: MaterialId,
    low: [f64; 2],
    high: [f64; 2],
) {
    /// Width of a rail.
    const RAIL: f64 = 0.062;
    let mut rail = |a: [f64; 2], b: [f64; 2], z: f64| {
        assembly.add(
            material,
            &bevelled_box([a[0], a[1], 0.001], [b[0], b[1], z], 0.0025),
        );
    };
    rail(low, [low[0] + RAIL, high[1]], 0.021);
    rail([high[0] - RAIL, low[1]], high, 0.021);
    rail(
        [low[0] + RAIL - 0.001, low[1]],
        [high[0] - RAIL + 0.001, low[1] + RAIL],
        0.0205,
    );
    rail(
        [low[0] + RAIL - 0.001, high[1] - RAIL],
        [high[0] - RAIL + 0.001, high[1]],
        0.0205,
    );
    let inside = 0.01;
    rail(
        [low[0] + RAIL - inside, low[1] + RAIL - inside],
        [high[0] - RAIL + inside, high[1] - RAIL + inside],
        0.011,
    );
}

/// A knob about the y axis.
fn knob(detail: Detail) -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.007, 0.0),
        (0.007, 0.0),
        (0.0055, 0.01),
        (0.015, 0.018),
        (0.013, 0.028),
        (0.0, 0.031),
    ];
    props::turned(&profile, 2, detail.segments(14))
}

/// A bar handle of a length on two posts, along x about x = 0.
pub(super) fn handle(detail: Detail, length: f64) -> Mesh {
    let half = length / 2.0;
    let path = [
        (-half, 0.0),
        (-half, 0.022),
        (-half + 0.01, 0.03),
        (half - 0.01, 0.03),
        (half, 0.022),
        (half, 0.0),
    ]
    .map(|(x, z)| DVec3::new(x, 0.0, z));
    tube(&path, detail.segments(8), |_| 0.005)
}

/// Stone worktops with an opening for the sink.
fn worktops(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let (low, front) = (WORKTOP - 0.04, WORKTOP_FRONT);
    let [left, right, rear, fore] = SINK;
    let mut slab = |from: [f64; 2], to: [f64; 2]| {
        assembly.add(
            materials.stone,
            &bevelled_box([from[0], low, from[1]], [to[0], WORKTOP, to[1]], 0.003),
        );
    };
    slab([-HALF_WIDTH, BACK], [left, front]);
    slab([left - 0.003, BACK], [right + 0.003, rear]);
    slab([left - 0.003, fore], [right + 0.003, front]);
    slab([right, BACK], [STOVE[0] - 0.003, front]);
    slab([STOVE[1] + 0.003, BACK], [FRIDGE - 0.015, front]);
    slab([-HALF_WIDTH, front - 0.003], [-HALF_WIDTH + 0.63, 0.52]);
}

/// Wall cabinets along x from x = 0 that face +z.
fn wall_cabinets(materials: &KitchenMaterials, detail: Detail) -> Assembly {
    let (low, high, depth) = (1.46, 2.2, 0.32);
    let mut assembly = Assembly::default();
    assembly.add(
        materials.lacquer,
        &boxed([0.0, low, 0.0], [1.8, high, depth]),
    );
    assembly.add(
        materials.lacquer,
        &bevelled_box(
            [-0.015, high - 0.002, 0.0],
            [1.815, high + 0.05, depth + 0.045],
            0.008,
        ),
    );
    for i in 0..4 {
        let left = 0.45 * f64::from(i);
        let mut door = Assembly::default();
        framed_panel(
            &mut door,
            materials.lacquer,
            [left + 0.003, low + 0.003],
            [left + 0.447, high - 0.004],
        );
        let knob_x = if i % 2 == 0 {
            left + 0.415
        } else {
            left + 0.035
        };
        door.add(
            materials.brass,
            &knob(detail).placed(Pose::at(knob_x, low + 0.08, 0.02).tilted(90.0)),
        );
        assembly.add_placed(&door, Pose::at(0.0, 0.0, depth));
    }
    assembly
}
