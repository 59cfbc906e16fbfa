//! Cabinets, worktops, shelves, sink and fridge.

use super::{BACK, HALF_WIDTH, KitchenMaterials, WORKTOP, WORKTOP_FRONT};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, catmull_rom, cylinder, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene};
use crate::scenes::{Detail, props};
use glam::DVec3;

/// The stove stands between these.
pub(super) const STOVE: [f64; 2] = [-0.05, 0.85];
/// Where the fridge begins.
const FRIDGE: f64 = 1.62;
/// Top of the cabinets' fronts, and the toe space beneath them.
const FRONT_TOP: f64 = WORKTOP - 0.045;
const TOE: f64 = 0.1;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    lower_run(&mut assembly, materials, detail);
    worktops(&mut assembly, materials);
    assembly.add_placed(
        &wall_cabinets(materials, detail),
        Pose::at(-HALF_WIDTH, 0.0, BACK + 2.15).turned(90.0),
    );
    scene.place_assembly("unit", assembly);

    let mut rest = Assembly::default();
    shelves(&mut rest, materials);
    sink(&mut rest, materials, detail);
    fridge(&mut rest, materials, detail);
    scene.place_assembly("fitting", rest);
}

/// Doors and drawers below the worktop, along the back wall and along the left one.
fn lower_run(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let back_left = -HALF_WIDTH + 0.62;
    let front = WORKTOP_FRONT - 0.045;
    let carcass = |assembly: &mut Assembly, low: [f64; 2], high: [f64; 2], top: f64| {
        assembly.add(
            materials.lacquer,
            &boxed([low[0], TOE, low[1]], [high[0], top, high[1]]),
        );
        assembly.add(
            materials.iron,
            &boxed([low[0], 0.0, low[1]], [high[0], TOE + 0.01, high[1] - 0.05]),
        );
    };
    // Lower beneath the sink, which hangs into it.
    let top = FRONT_TOP + 0.005;
    let (sink_left, sink_right) = (SINK[0] - 0.02, SINK[1] + 0.02);
    carcass(assembly, [-HALF_WIDTH, BACK], [sink_left, front], top);
    carcass(assembly, [sink_left, BACK], [sink_right, front], 0.69);
    carcass(assembly, [sink_right, BACK], [STOVE[0] - 0.004, front], top);
    carcass(
        assembly,
        [STOVE[1] + 0.004, BACK],
        [FRIDGE - 0.02, front],
        top,
    );
    assembly.add(
        materials.lacquer,
        &boxed(
            [-HALF_WIDTH, TOE, BACK],
            [back_left - 0.045, FRONT_TOP + 0.005, 0.5],
        ),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [-HALF_WIDTH, 0.0, BACK],
            [back_left - 0.095, TOE + 0.01, 0.48],
        ),
    );

    for (left, width, kind) in [
        (back_left + 0.03, 0.56, CabinetFront::Door),
        (back_left + 0.6, 0.56, CabinetFront::Door),
        (back_left + 1.17, 0.54, CabinetFront::Drawers),
    ] {
        let pose = Pose::at(left, 0.0, front);
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
        Pose::at(right, 0.0, front),
    );
    for i in 0..3 {
        let kind = if i == 1 {
            CabinetFront::Drawers
        } else {
            CabinetFront::Door
        };
        let pose = Pose::at(back_left - 0.045, 0.0, 0.48 - 0.585 * f64::from(i)).turned(90.0);
        assembly.add_placed(&unit_front(materials, detail, 0.575, kind), pose);
    }
}

/// What closes a cabinet.
#[derive(Clone, Copy)]
enum CabinetFront {
    Door,
    Drawers,
}

/// The front of a lower cabinet from x = 0, in the plane z = 0.
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
                let knob = Pose::at(width - 0.04, high - 0.09, 0.02).tilted(90.0);
                assembly.add(materials.brass, &knob_mesh(detail).placed(knob));
            }
            CabinetFront::Drawers => assembly.add(
                materials.brass,
                &handle(detail, 0.14).placed(Pose::at(width / 2.0, high - 0.045, 0.02)),
            ),
        }
    }
    assembly
}

/// A frame of four rails around a recessed panel.
fn framed_panel(assembly: &mut Assembly, material: MaterialId, low: [f64; 2], high: [f64; 2]) {
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

fn knob_mesh(detail: Detail) -> Mesh {
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

/// A bar on two posts, along x about x = 0.
fn handle(detail: Detail, length: f64) -> Mesh {
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

/// Stone on the cabinets, with a hole where the sink hangs.
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

/// The sink's opening: x, x, z, z.
const SINK: [f64; 4] = [-1.47, -0.88, BACK + 0.14, BACK + 0.54];

/// A steel basin and its tap.
fn sink(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
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
    let drain = cylinder(0.035, 0.004, detail.segments(18));
    assembly.add(
        materials.steel,
        &drain.placed(Pose::at(x, floor + 0.006, (rear + fore) / 2.0)),
    );
}

/// Cabinets on the left wall, along x from 0, facing z; their doors are framed, too.
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
            &knob_mesh(detail).placed(Pose::at(knob_x, low + 0.08, 0.02).tilted(90.0)),
        );
        assembly.add_placed(&door, Pose::at(0.0, 0.0, depth));
    }
    assembly
}

/// Two oak shelves on iron brackets to the right of the stove.
fn shelves(assembly: &mut Assembly, materials: &KitchenMaterials) {
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

/// Undersides of the shelves.
pub(super) const SHELVES: [f64; 2] = [1.455, 1.85];

/// A brushed-steel fridge with two doors.
fn fridge(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let (right, front) = (HALF_WIDTH - 0.03, BACK + 0.7);
    assembly.add(
        materials.satin_steel,
        &boxed([FRIDGE, 0.05, BACK + 0.03], [right, 1.9, front - 0.06]),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [FRIDGE + 0.02, 0.0, BACK + 0.05],
            [right - 0.02, 0.06, front - 0.1],
        ),
    );
    for (low, high) in [(0.06, 0.68), (0.69, 1.9)] {
        assembly.add(
            materials.satin_steel,
            &bevelled_box([FRIDGE, low, front - 0.055], [right, high, front], 0.012),
        );
    }
    for (low, high) in [(0.36, 0.62), (0.78, 1.3)] {
        let bar = handle(detail, high - low).placed(Pose::identity().stretched(1.0, 1.0, 1.6));
        let pose = Pose::at(FRIDGE + 0.07, (low + high) / 2.0, front).rolled(90.0);
        assembly.add(materials.steel, &bar.placed(pose));
    }
    // Notes under magnets.
    for (x, y, tilt, paper, magnet) in [
        (1.92, 1.42, 4.0, materials.linen, materials.red_enamel),
        (2.07, 1.36, -6.0, materials.lemon, materials.blue_glaze),
        (1.95, 1.22, -2.0, materials.cream_glaze, materials.black),
    ] {
        let note = bevelled_box([-0.055, -0.08, 0.0003], [0.055, 0.08, 0.0012], 0.0002);
        assembly.add(paper, &note.placed(Pose::at(x, y, front).rolled(tilt)));
        let button = bevelled_cylinder(0.011, 0.008, 0.002, detail.segments(12));
        assembly.add(
            magnet,
            &button.placed(Pose::at(x, y + 0.06, front).tilted(90.0)),
        );
    }
    // A cabinet above fills the space to the beam.
    assembly.add(
        materials.lacquer,
        &boxed([FRIDGE - 0.01, 1.95, BACK], [HALF_WIDTH, 2.4, front - 0.08]),
    );
    let mut door = Assembly::default();
    framed_panel(
        &mut door,
        materials.lacquer,
        [FRIDGE, 1.96],
        [HALF_WIDTH - 0.02, 2.39],
    );
    assembly.add_placed(&door, Pose::at(0.0, 0.0, front - 0.08));
}
