//! Fruit and breakfast on the table.

use super::{KitchenMaterials, TABLE_CENTER, TABLE_TOP};
use crate::build::{ball, bevelled_box, bevelled_cylinder, catmull_rom, superellipsoid, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    fruit(scene, materials, detail);
    let mut assembly = Assembly::default();
    bread(&mut assembly, materials, detail);
    jug(&mut assembly, materials, detail);
    coffee(&mut assembly, materials, detail);
    folded_cloth(&mut assembly, materials);
    scene.place_assembly("breakfast", assembly);
}

/// A pose on the table at an offset from its center.
fn on_table(dx: f64, dz: f64) -> Pose {
    Pose::at(TABLE_CENTER.0 + dx, TABLE_TOP, TABLE_CENTER.1 + dz)
}

/// A copper bowl of fruit, and a lemon on the table.
fn fruit(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let (x, z) = (TABLE_CENTER.0 - 0.2, TABLE_CENTER.1 - 0.05);
    let bowl = scene.add_mesh("fruit_bowl", props::bowl(detail));
    scene.place(
        "fruit_bowl",
        ShapeKind::Mesh(bowl),
        Pose::at(x, TABLE_TOP, z).scaled(1.2),
        materials.copper,
    );
    let round = detail.segments(20);
    let apple = scene.add_mesh("apple", apple(detail));
    let orange = scene.add_mesh("orange", ball(0.037, round));
    let lemon = scene.add_mesh("lemon", lemon(detail));
    for (i, (dx, y, dz, kind, turn, tilt)) in [
        (-0.075, 0.082, 0.02, 0, 0.0, 12.0),
        (0.005, 0.078, -0.075, 1, 0.0, 0.0),
        (0.08, 0.083, 0.005, 0, 120.0, -15.0),
        (0.01, 0.074, 0.07, 2, 30.0, 80.0),
        (-0.06, 0.089, -0.075, 2, -40.0, 70.0),
        (0.0, 0.135, 0.0, 1, 0.0, 0.0),
        (0.065, 0.135, 0.065, 1, 0.0, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        let (mesh, material) = [
            (apple, materials.apple),
            (orange, materials.orange),
            (lemon, materials.lemon),
        ][kind];
        let pose = Pose::at(x + dx, TABLE_TOP + y, z + dz)
            .tilted(tilt)
            .turned(turn);
        scene.place(&format!("fruit_{i}"), ShapeKind::Mesh(mesh), pose, material);
    }
    let rolled = Pose::at(x + 0.27, TABLE_TOP + 0.028, z + 0.14)
        .tilted(90.0)
        .turned(35.0);
    scene.place(
        "lemon_on_table",
        ShapeKind::Mesh(lemon),
        rolled,
        materials.lemon,
    );
}

/// An apple about the origin.
fn apple(detail: Detail) -> Mesh {
    let profile = [
        (0.0, -0.03),
        (0.012, -0.036),
        (0.03, -0.026),
        (0.039, 0.004),
        (0.03, 0.031),
        (0.012, 0.034),
        (0.0, 0.024),
    ];
    props::turned(&profile, 3, detail.segments(24))
}

/// A lemon about the origin.
fn lemon(detail: Detail) -> Mesh {
    let profile = [
        (0.0, -0.045),
        (0.006, -0.042),
        (0.018, -0.031),
        (0.028, -0.008),
        (0.028, 0.008),
        (0.018, 0.031),
        (0.007, 0.042),
        (0.0, 0.047),
    ];
    props::turned(&profile, 3, detail.segments(20))
}

/// A board with a loaf of bread and a knife.
fn bread(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let board_pose = on_table(0.36, 0.12).turned(14.0);
    let on_board = |dx: f64, dz: f64| {
        let point = board_pose
            .matrix()
            .transform_point3(DVec3::new(dx, 0.02, dz));
        Pose::at(point.x, point.y, point.z).turned(14.0)
    };
    let board = bevelled_box([-0.2, 0.0, -0.12], [0.2, 0.02, 0.12], 0.006);
    assembly.add(materials.walnut, &board.placed(board_pose));
    let loaf = superellipsoid([0.13, 0.05, 0.065], 0.75, 0.7, detail.segments(28));
    assembly.add(
        materials.crust,
        &loaf.placed(on_board(-0.03, -0.03).lifted(0.046)),
    );
    let blade = bevelled_box([-0.1, 0.0, -0.014], [0.1, 0.002, 0.014], 0.0008);
    assembly.add(materials.steel, &blade.placed(on_board(0.02, 0.075)));
    let grip = bevelled_box([-0.055, 0.0, -0.011], [0.055, 0.016, 0.011], 0.004);
    assembly.add(materials.black, &grip.placed(on_board(0.17, 0.075)));
}

/// A jug with green leaves.
fn jug(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let jug = [
        (0.0, 0.0),
        (0.05, 0.0),
        (0.05, 0.0),
        (0.066, 0.03),
        (0.07, 0.075),
        (0.055, 0.13),
        (0.046, 0.16),
        (0.054, 0.195),
        (0.054, 0.195),
        (0.05, 0.195),
        (0.05, 0.195),
        (0.042, 0.16),
        (0.042, 0.16),
        (0.0, 0.15),
    ];
    let pose = on_table(-0.55, 0.05);
    let jug = props::turned(&jug, 3, detail.segments(28));
    assembly.add(materials.blue_glaze, &jug.placed(pose));
    let ear = [
        (0.05, 0.17),
        (0.09, 0.165),
        (0.11, 0.12),
        (0.095, 0.07),
        (0.066, 0.055),
    ]
    .map(|(x, y)| DVec3::new(x, y, 0.0));
    let ear = tube(&catmull_rom(&ear, 4), detail.segments(10), |_| 0.007);
    assembly.add(materials.blue_glaze, &ear.placed(pose.turned(200.0)));
    let leaves = props::strap_plant(14, 0.34, 0.6, &mut Pcg32::new(14));
    assembly.add(materials.leaf, &leaves.placed(pose.lifted(0.15)));
}

/// A cup of coffee on a saucer.
fn coffee(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let saucer = [
        (0.0, 0.0),
        (0.04, 0.0),
        (0.05, 0.004),
        (0.076, 0.014),
        (0.076, 0.014),
        (0.075, 0.017),
        (0.05, 0.008),
        (0.0, 0.006),
    ];
    let cup = [
        (0.0, 0.0),
        (0.024, 0.0),
        (0.024, 0.0),
        (0.036, 0.016),
        (0.043, 0.06),
        (0.043, 0.06),
        (0.04, 0.06),
        (0.04, 0.06),
        (0.034, 0.03),
        (0.034, 0.03),
        (0.0, 0.03),
    ];
    let pose = on_table(-0.02, 0.24);
    let saucer = props::turned(&saucer, 2, detail.segments(28));
    assembly.add(materials.cream_glaze, &saucer.placed(pose));
    let cup = props::turned(&cup, 2, detail.segments(24));
    assembly.add(materials.cream_glaze, &cup.placed(pose.lifted(0.0065)));
    let coffee = bevelled_cylinder(0.0355, 0.012, 0.001, detail.segments(20));
    assembly.add(materials.coffee, &coffee.placed(pose.lifted(0.034)));
}

/// A folded cloth: three layers.
fn folded_cloth(assembly: &mut Assembly, materials: &KitchenMaterials) {
    for (i, y) in [0.0, 0.005, 0.01].into_iter().enumerate() {
        let half = 0.12 - 0.004 * i as f64;
        let layer = bevelled_box(
            [-half, y + 0.0002, -0.085],
            [half, y + 0.0048, 0.085],
            0.002,
        );
        let pose = on_table(-0.42, 0.29).turned(-12.0 + 2.0 * i as f64);
        assembly.add(materials.linen, &layer.placed(pose));
    }
}
