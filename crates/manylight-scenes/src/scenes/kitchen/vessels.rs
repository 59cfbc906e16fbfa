//! Jars, plates, cups and bottles on shelves, worktops and the window sill.

use super::units::SHELVES;
use super::{BACK, HALF_WIDTH, Look, WORKTOP};
use crate::build::{bevelled_box, bevelled_cylinder, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg;
use crate::pose::Pose;
use crate::scene::{Geometry, MaterialId, MeshId, Scene};
use crate::scenes::{Detail, props};
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, look: &Look, detail: Detail) {
    let forms = Forms::new(scene, detail);
    on_shelves(scene, look, &forms);
    on_worktops(scene, look, &forms, detail);
    on_sill(scene, look, &forms);
}

/// Meshes that are used more than once.
pub(super) struct Forms {
    plate: MeshId,
    bowl: MeshId,
    mug: MeshId,
    jar: MeshId,
    filling: MeshId,
    cork: MeshId,
    bottle: MeshId,
    pot: MeshId,
    herb: MeshId,
}

impl Forms {
    fn new(scene: &mut Scene, detail: Detail) -> Forms {
        let round = detail.pieces(28);
        let mut mug = props::turned(
            &[
                (0.0, 0.0),
                (0.034, 0.0),
                (0.034, 0.0),
                (0.04, 0.01),
                (0.042, 0.05),
                (0.042, 0.092),
                (0.042, 0.092),
                (0.038, 0.092),
                (0.038, 0.092),
                (0.037, 0.02),
                (0.03, 0.008),
                (0.0, 0.006),
            ],
            2,
            round,
        );
        let ear = [
            (0.04, 0.022),
            (0.06, 0.024),
            (0.073, 0.046),
            (0.062, 0.07),
            (0.04, 0.074),
        ]
        .map(|(x, y)| DVec3::new(x, y, 0.0));
        mug.append(&tube(&crate::build::catmull_rom(&ear, 3), 8, |_| 0.0045));
        let plate = [
            (0.0, 0.0),
            (0.07, 0.0),
            (0.075, 0.003),
            (0.12, 0.018),
            (0.12, 0.018),
            (0.119, 0.021),
            (0.119, 0.021),
            (0.078, 0.008),
            (0.0, 0.006),
        ];
        let jar = [
            (0.0, 0.0),
            (0.046, 0.0),
            (0.046, 0.0),
            (0.05, 0.006),
            (0.05, 0.13),
            (0.038, 0.15),
            (0.038, 0.165),
            (0.038, 0.165),
            (0.035, 0.165),
            (0.035, 0.165),
            (0.035, 0.149),
            (0.0465, 0.129),
            (0.0465, 0.007),
            (0.044, 0.0045),
            (0.044, 0.0045),
            (0.0, 0.0045),
        ];
        let bottle = [
            (0.0, 0.0),
            (0.034, 0.0),
            (0.034, 0.0),
            (0.037, 0.006),
            (0.037, 0.16),
            (0.03, 0.19),
            (0.014, 0.22),
            (0.0125, 0.275),
            (0.0125, 0.275),
            (0.015, 0.278),
            (0.015, 0.29),
            (0.0, 0.29),
        ];
        let filling = bevelled_cylinder(0.0455, 0.115, 0.004, round);
        let herb = props::strap_plant(26, 0.22, 0.4, &mut Pcg::new(77));
        Forms {
            plate: scene.mesh("plate", props::turned(&plate, 2, round)),
            bowl: scene.mesh("bowl", props::bowl(detail)),
            mug: scene.mesh("mug", mug),
            jar: scene.mesh("jar", props::turned(&jar, 2, round)),
            filling: scene.mesh("filling", filling),
            cork: scene.mesh(
                "cork",
                bevelled_cylinder(0.0345, 0.03, 0.003, detail.pieces(18)),
            ),
            bottle: scene.mesh("bottle", props::turned(&bottle, 3, round)),
            pot: scene.mesh("herb_pot", props::pot(detail)),
            herb: scene.mesh("herb", herb),
        }
    }
}

fn put(scene: &mut Scene, name: &str, mesh: MeshId, pose: Pose, material: MaterialId) {
    scene.place(name, Geometry::Mesh(mesh), pose, material);
}

/// A glass jar with something in it and a cork.
fn jar(scene: &mut Scene, look: &Look, forms: &Forms, name: &str, pose: Pose, inside: MaterialId) {
    let lifted = |by: f64| Pose {
        position: pose.position + DVec3::Y * by * pose.scale.y,
        ..pose
    };
    put(scene, &format!("{name}_glass"), forms.jar, pose, look.glass);
    put(
        scene,
        &format!("{name}_filling"),
        forms.filling,
        lifted(0.0055),
        inside,
    );
    put(
        scene,
        &format!("{name}_cork"),
        forms.cork,
        lifted(0.149),
        look.oak_plain,
    );
}

/// Jars whose names are numbered.
fn jars(
    scene: &mut Scene,
    look: &Look,
    forms: &Forms,
    name: &str,
    places: [(Pose, MaterialId); 3],
) {
    for (i, (pose, inside)) in places.into_iter().enumerate() {
        jar(scene, look, forms, &format!("{name}_{i}"), pose, inside);
    }
}

fn on_shelves(scene: &mut Scene, look: &Look, forms: &Forms) {
    let (low, high) = (SHELVES[0] + 0.03, SHELVES[1] + 0.03);
    let z = BACK + 0.13;
    let row = [
        (1.03, look.pasta),
        (1.16, look.coffee),
        (1.29, look.lentils),
    ];
    let row = row.map(|(x, inside)| (Pose::at(x, low, z), inside));
    jars(scene, look, forms, "jar", row);
    for i in 0..4 {
        let y = low + 0.012 * f64::from(i);
        put(
            scene,
            &format!("soup_bowl_{i}"),
            forms.bowl,
            Pose::at(1.455, y, z).scaled(0.62),
            look.blue_glaze,
        );
    }
    for i in 0..6 {
        let y = high + 0.0085 * f64::from(i);
        put(
            scene,
            &format!("plate_{i}"),
            forms.plate,
            Pose::at(1.09, y, z),
            look.cream_glaze,
        );
    }
    for (i, (x, turn, glaze)) in [
        (1.28, 40.0, look.green_glaze),
        (1.385, 10.0, look.cream_glaze),
        (1.49, -25.0, look.blue_glaze),
    ]
    .into_iter()
    .enumerate()
    {
        put(
            scene,
            &format!("mug_{i}"),
            forms.mug,
            Pose::at(x, high, z).turned(turn),
            glaze,
        );
    }
}

fn on_worktops(scene: &mut Scene, look: &Look, forms: &Forms, detail: Detail) {
    // Between stove and fridge: oil, a leaning board, a crock with spoons.
    put(
        scene,
        "oil",
        forms.bottle,
        Pose::at(0.96, WORKTOP, BACK + 0.16),
        look.green_glaze,
    );
    put(
        scene,
        "vinegar",
        forms.bottle,
        Pose::at(1.05, WORKTOP, BACK + 0.13).scaled(0.85),
        look.coffee,
    );
    let board = bevelled_box([-0.14, 0.0, -0.01], [0.14, 0.4, 0.01], 0.005).box_mapped(0.5);
    let leaning = scene.mesh("board", board);
    put(
        scene,
        "board",
        leaning,
        Pose::at(1.38, WORKTOP + 0.002, BACK + 0.105).tilted(-11.0),
        look.oak,
    );
    let spoon = scene.mesh("spoon", spoon(detail));
    put(
        scene,
        "crock",
        forms.pot,
        Pose::at(1.19, WORKTOP, BACK + 0.22).scaled(0.42),
        look.cream_glaze,
    );
    for (i, (turn, lean)) in [(20.0, 9.0), (140.0, 11.0), (250.0, 8.0)]
        .into_iter()
        .enumerate()
    {
        let pose = Pose::at(1.19, WORKTOP + 0.128, BACK + 0.22)
            .rolled(lean)
            .turned(turn);
        put(scene, &format!("spoon_{i}"), spoon, pose, look.oak_plain);
    }
    // Left of the sink and along the left wall.
    let row = [
        (-0.15, 1.25, look.pasta),
        (-0.31, 1.1, look.lentils),
        (-0.46, 0.95, look.coffee),
    ];
    let row = row.map(|(z, scale, inside)| {
        let pose = Pose::at(-HALF_WIDTH + 0.15, WORKTOP, z).scaled(scale);
        (pose, inside)
    });
    jars(scene, look, forms, "tall_jar", row);
    let bin = bevelled_box([-0.2, 0.0, -0.14], [0.2, 0.22, 0.14], 0.03);
    let bin = scene.mesh("bread_bin", bin);
    put(
        scene,
        "bread_bin",
        bin,
        Pose::at(-HALF_WIDTH + 0.2, WORKTOP, -1.2).turned(90.0),
        look.satin_steel,
    );
    let knob = scene.mesh(
        "bin_knob",
        bevelled_cylinder(0.014, 0.03, 0.004, detail.pieces(14)),
    );
    put(
        scene,
        "bin_knob",
        knob,
        Pose::at(-HALF_WIDTH + 0.339, WORKTOP + 0.12, -1.2)
            .tilted(90.0)
            .turned(90.0),
        look.brass,
    );
    put(
        scene,
        "left_bowl",
        forms.bowl,
        Pose::at(-HALF_WIDTH + 0.3, WORKTOP, 0.2).scaled(0.95),
        look.blue_glaze,
    );
    // Washed up, to the right of the sink.
    put(
        scene,
        "washed_mug",
        forms.mug,
        Pose::at(-0.7, WORKTOP, BACK + 0.2).turned(60.0),
        look.red_enamel,
    );
    put(
        scene,
        "washed_bowl",
        forms.bowl,
        Pose::at(-0.5, WORKTOP, BACK + 0.24).scaled(0.7),
        look.cream_glaze,
    );
}

/// A wooden spoon that stands on its handle's end.
fn spoon(detail: Detail) -> Mesh {
    let stick = tube(
        &[DVec3::new(0.0, -0.11, 0.0), DVec3::new(0.0, 0.16, 0.0)],
        detail.pieces(8),
        |_| 0.0055,
    );
    let bowl = crate::build::superellipsoid([0.024, 0.036, 0.007], 1.0, 1.0, detail.pieces(16));
    Mesh::joined(&[stick, bowl.placed(Pose::at(0.0, 0.185, 0.0))])
}

/// Herbs before the window.
fn on_sill(scene: &mut Scene, look: &Look, forms: &Forms) {
    let y = 1.084;
    for (i, (x, scale, glaze)) in [
        (-1.55, 0.38, look.cream_glaze),
        (-0.82, 0.42, look.terracotta),
    ]
    .into_iter()
    .enumerate()
    {
        let pose = Pose::at(x, y, BACK - 0.03).scaled(scale);
        put(scene, &format!("herb_pot_{i}"), forms.pot, pose, glaze);
        let above = Pose::at(x, y + 0.3 * scale, BACK - 0.03).turned(100.0 * i as f64);
        put(scene, &format!("herb_{i}"), forms.herb, above, look.leaf);
    }
}
