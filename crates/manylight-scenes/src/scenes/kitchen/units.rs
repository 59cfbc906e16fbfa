//! Cabinets, worktops, shelves, sink and fridge.

use super::{BACK, HALF_WIDTH, Look, WORKTOP, WORKTOP_FRONT};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, catmull_rom, cylinder, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Batch, MaterialId, Scene};
use crate::scenes::{Detail, props};
use glam::DVec3;

/// The stove stands between these.
pub(super) const STOVE: [f64; 2] = [-0.05, 0.85];
/// Where the fridge begins.
const FRIDGE: f64 = 1.62;
/// Top of the cabinets' fronts, and the toe space beneath them.
const FRONT_TOP: f64 = WORKTOP - 0.045;
const TOE: f64 = 0.1;

pub(super) fn add(scene: &mut Scene, look: &Look, detail: Detail) {
    let mut batch = Batch::default();
    lower_run(&mut batch, look, detail);
    worktops(&mut batch, look);
    batch.add_placed(
        &wall_cabinets(look, detail),
        Pose::at(-HALF_WIDTH, 0.0, BACK + 2.15).turned(90.0),
    );
    scene.add_batch("unit", batch);

    let mut rest = Batch::default();
    shelves(&mut rest, look);
    sink(&mut rest, look, detail);
    fridge(&mut rest, look, detail);
    scene.add_batch("fitting", rest);
}

/// Doors and drawers below the worktop, along the back wall and along the left one.
fn lower_run(batch: &mut Batch, look: &Look, detail: Detail) {
    let back_left = -HALF_WIDTH + 0.62;
    let front = WORKTOP_FRONT - 0.045;
    let carcass = |batch: &mut Batch, low: [f64; 2], high: [f64; 2], top: f64| {
        batch.add(
            look.lacquer,
            &boxed([low[0], TOE, low[1]], [high[0], top, high[1]]),
        );
        batch.add(
            look.iron,
            &boxed([low[0], 0.0, low[1]], [high[0], TOE + 0.01, high[1] - 0.05]),
        );
    };
    // Lower beneath the sink, which hangs into it.
    let top = FRONT_TOP + 0.005;
    let (sink_left, sink_right) = (SINK[0] - 0.02, SINK[1] + 0.02);
    carcass(batch, [-HALF_WIDTH, BACK], [sink_left, front], top);
    carcass(batch, [sink_left, BACK], [sink_right, front], 0.69);
    carcass(batch, [sink_right, BACK], [STOVE[0] - 0.004, front], top);
    carcass(batch, [STOVE[1] + 0.004, BACK], [FRIDGE - 0.02, front], top);
    batch.add(
        look.lacquer,
        &boxed(
            [-HALF_WIDTH, TOE, BACK],
            [back_left - 0.045, FRONT_TOP + 0.005, 0.5],
        ),
    );
    batch.add(
        look.iron,
        &boxed(
            [-HALF_WIDTH, 0.0, BACK],
            [back_left - 0.095, TOE + 0.01, 0.48],
        ),
    );

    for (left, width, kind) in [
        (back_left + 0.03, 0.56, Front::Door),
        (back_left + 0.6, 0.56, Front::Door),
        (back_left + 1.17, 0.54, Front::Drawers),
    ] {
        let pose = Pose::at(left, 0.0, front);
        batch.add_placed(&unit_front(look, detail, width, kind), pose);
    }
    let right = STOVE[1] + 0.012;
    batch.add_placed(
        &unit_front(look, detail, FRIDGE - 0.04 - right, Front::Drawers),
        Pose::at(right, 0.0, front),
    );
    for i in 0..3 {
        let kind = if i == 1 { Front::Drawers } else { Front::Door };
        let pose = Pose::at(back_left - 0.045, 0.0, 0.48 - 0.585 * f64::from(i)).turned(90.0);
        batch.add_placed(&unit_front(look, detail, 0.575, kind), pose);
    }
}

/// What closes a cabinet.
#[derive(Clone, Copy)]
enum Front {
    Door,
    Drawers,
}

/// The front of a lower cabinet from x = 0, in the plane z = 0.
fn unit_front(look: &Look, detail: Detail, width: f64, kind: Front) -> Batch {
    let mut batch = Batch::default();
    let rows: &[(f64, f64)] = match kind {
        Front::Door => &[(TOE + 0.01, FRONT_TOP - 0.005)],
        Front::Drawers => &[
            (TOE + 0.01, 0.39),
            (0.396, 0.655),
            (0.661, FRONT_TOP - 0.005),
        ],
    };
    for &(low, high) in rows {
        framed_panel(
            &mut batch,
            look.lacquer,
            [0.003, low],
            [width - 0.003, high],
        );
        match kind {
            Front::Door => {
                let knob = Pose::at(width - 0.04, high - 0.09, 0.02).tilted(90.0);
                batch.add(look.brass, &knob_mesh(detail).placed(knob));
            }
            Front::Drawers => batch.add(
                look.brass,
                &handle(detail, 0.14).placed(Pose::at(width / 2.0, high - 0.045, 0.02)),
            ),
        }
    }
    batch
}

/// A frame of four rails around a recessed panel.
fn framed_panel(batch: &mut Batch, material: MaterialId, low: [f64; 2], high: [f64; 2]) {
    const RAIL: f64 = 0.062;
    let mut rail = |a: [f64; 2], b: [f64; 2], z: f64| {
        batch.add(
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
    props::turned(&profile, 2, detail.pieces(14))
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
    tube(&path, detail.pieces(8), |_| 0.005)
}

/// Stone on the cabinets, with a hole where the sink hangs.
fn worktops(batch: &mut Batch, look: &Look) {
    let (low, front) = (WORKTOP - 0.04, WORKTOP_FRONT);
    let [left, right, rear, fore] = SINK;
    let mut slab = |from: [f64; 2], to: [f64; 2]| {
        batch.add(
            look.stone,
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
fn sink(batch: &mut Batch, look: &Look, detail: Detail) {
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
        batch.add(look.satin_steel, &bevelled_box(low, high, 0.002));
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
        detail.pieces(18),
    );
    batch.add(look.steel, &foot.placed(Pose::at(x, WORKTOP, rear - 0.065)));
    let neck = [
        (0.0, 0.0),
        (0.17, 0.0),
        (0.27, 0.03),
        (0.315, 0.1),
        (0.27, 0.17),
        (0.21, 0.19),
    ]
    .map(|(y, z)| DVec3::new(x, WORKTOP + 0.01 + y, rear - 0.065 + z));
    batch.add(
        look.steel,
        &tube(&catmull_rom(&neck, 6), detail.pieces(12), |_| 0.011),
    );
    for side in [-1.0, 1.0] {
        let lever = [
            DVec3::new(x, WORKTOP + 0.05, rear - 0.065),
            DVec3::new(x + 0.075 * side, WORKTOP + 0.075, rear - 0.06),
        ];
        batch.add(
            look.steel,
            &tube(&lever, detail.pieces(10), |t| 0.008 - 0.002 * t),
        );
    }
    let drain = cylinder(0.035, 0.004, detail.pieces(18));
    batch.add(
        look.steel,
        &drain.placed(Pose::at(x, floor + 0.006, (rear + fore) / 2.0)),
    );
}

/// Cabinets on the left wall, along x from 0, facing z; their doors are framed, too.
fn wall_cabinets(look: &Look, detail: Detail) -> Batch {
    let (low, high, depth) = (1.46, 2.2, 0.32);
    let mut batch = Batch::default();
    batch.add(look.lacquer, &boxed([0.0, low, 0.0], [1.8, high, depth]));
    batch.add(
        look.lacquer,
        &bevelled_box(
            [-0.015, high - 0.002, 0.0],
            [1.815, high + 0.05, depth + 0.045],
            0.008,
        ),
    );
    for i in 0..4 {
        let left = 0.45 * f64::from(i);
        let mut door = Batch::default();
        framed_panel(
            &mut door,
            look.lacquer,
            [left + 0.003, low + 0.003],
            [left + 0.447, high - 0.004],
        );
        let knob_x = if i % 2 == 0 {
            left + 0.415
        } else {
            left + 0.035
        };
        door.add(
            look.brass,
            &knob_mesh(detail).placed(Pose::at(knob_x, low + 0.08, 0.02).tilted(90.0)),
        );
        batch.add_placed(&door, Pose::at(0.0, 0.0, depth));
    }
    batch
}

/// Two oak shelves on iron brackets to the right of the stove.
fn shelves(batch: &mut Batch, look: &Look) {
    for y in SHELVES {
        let board = bevelled_box([0.95, y, BACK], [1.57, y + 0.03, BACK + 0.25], 0.003);
        batch.add(look.oak, &board.box_mapped(0.5));
        for x in [1.05, 1.47] {
            batch.add(
                look.iron,
                &bevelled_box(
                    [x - 0.012, y - 0.006, BACK],
                    [x + 0.012, y + 0.001, BACK + 0.22],
                    0.001,
                ),
            );
            batch.add(
                look.iron,
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
fn fridge(batch: &mut Batch, look: &Look, detail: Detail) {
    let (right, front) = (HALF_WIDTH - 0.03, BACK + 0.7);
    batch.add(
        look.satin_steel,
        &boxed([FRIDGE, 0.05, BACK + 0.03], [right, 1.9, front - 0.06]),
    );
    batch.add(
        look.iron,
        &boxed(
            [FRIDGE + 0.02, 0.0, BACK + 0.05],
            [right - 0.02, 0.06, front - 0.1],
        ),
    );
    for (low, high) in [(0.06, 0.68), (0.69, 1.9)] {
        batch.add(
            look.satin_steel,
            &bevelled_box([FRIDGE, low, front - 0.055], [right, high, front], 0.012),
        );
    }
    for (low, high) in [(0.36, 0.62), (0.78, 1.3)] {
        let bar = handle(detail, high - low).placed(Pose::identity().stretched(1.0, 1.0, 1.6));
        let pose = Pose::at(FRIDGE + 0.07, (low + high) / 2.0, front).rolled(90.0);
        batch.add(look.steel, &bar.placed(pose));
    }
    // Notes under magnets.
    for (x, y, tilt, paper, magnet) in [
        (1.92, 1.42, 4.0, look.linen, look.red_enamel),
        (2.07, 1.36, -6.0, look.lemon, look.blue_glaze),
        (1.95, 1.22, -2.0, look.cream_glaze, look.black),
    ] {
        let note = bevelled_box([-0.055, -0.08, 0.0003], [0.055, 0.08, 0.0012], 0.0002);
        batch.add(paper, &note.placed(Pose::at(x, y, front).rolled(tilt)));
        let button = bevelled_cylinder(0.011, 0.008, 0.002, detail.pieces(12));
        batch.add(
            magnet,
            &button.placed(Pose::at(x, y + 0.06, front).tilted(90.0)),
        );
    }
    // A cabinet above fills the space to the beam.
    batch.add(
        look.lacquer,
        &boxed([FRIDGE - 0.01, 1.95, BACK], [HALF_WIDTH, 2.4, front - 0.08]),
    );
    let mut door = Batch::default();
    framed_panel(
        &mut door,
        look.lacquer,
        [FRIDGE, 1.96],
        [HALF_WIDTH - 0.02, 2.39],
    );
    batch.add_placed(&door, Pose::at(0.0, 0.0, front - 0.08));
}
