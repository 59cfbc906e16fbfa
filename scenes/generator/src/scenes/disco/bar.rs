//! The bar on the right: a copper counter, stools, lit shelves with bottles, and a high table.

use super::{DiscoMaterials, HALF_WIDTH};
use crate::build::{bevelled_box, bevelled_cylinder, cylinder, lathe, tube};
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, MeshId, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};

/// z of the near end of the counter and of the shelves.
const NEAR: f64 = 2.3;
/// z of the far end of the counter and of the shelves.
const FAR: f64 = -2.9;
/// x of the front of the counter.
const FACE: f64 = 3.55;

pub(super) fn add(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    counter(scene, materials, detail);
    stools(scene, materials, detail);
    shelves(scene, materials, detail);
    drinks(scene, materials, detail);
}

/// A counter with fluted copper and a foot rail.
fn counter(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.black,
        &bevelled_box([FACE + 0.03, 0.0, FAR], [FACE + 0.5, 1.06, NEAR], 0.006),
    );
    assembly.add(
        materials.walnut,
        &bevelled_box(
            [FACE - 0.14, 1.06, FAR - 0.06],
            [FACE + 0.56, 1.115, NEAR + 0.06],
            0.012,
        ),
    );
    let flute = cylinder(0.05, 0.86, detail.segments(16));
    let count = ((NEAR - FAR) / 0.1) as usize;
    for i in 0..count {
        let z = FAR + 0.05 + 0.1 * i as f64;
        assembly.add(
            materials.copper,
            &flute.placed(Pose::at(FACE + 0.035, 0.16, z)),
        );
    }
    assembly.add(
        materials.black,
        &bevelled_box(
            [FACE + 0.02, 0.0, FAR - 0.003],
            [FACE + 0.2, 0.161, NEAR + 0.003],
            0.004,
        ),
    );
    let rail = [
        DVec3::new(FACE - 0.16, 0.2, FAR),
        DVec3::new(FACE - 0.16, 0.2, NEAR),
    ];
    assembly.add(
        materials.brass,
        &tube(&rail, detail.segments(12), |_| 0.022),
    );
    for i in 0..5 {
        let z = FAR + 0.1 + 1.25 * f64::from(i);
        assembly.add(
            materials.brass,
            &bevelled_box(
                [FACE - 0.17, 0.19, z - 0.012],
                [FACE + 0.04, 0.21, z + 0.012],
                0.003,
            ),
        );
    }
    scene.place_assembly("counter", assembly);
}

/// Five stools.
fn stools(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut stool = Assembly::default();
    let round = detail.segments(28);
    let base = [
        (0.0, 0.0),
        (0.21, 0.0),
        (0.21, 0.0),
        (0.215, 0.008),
        (0.06, 0.03),
        (0.028, 0.06),
        (0.028, 0.06),
        (0.028, 0.72),
        (0.028, 0.72),
        (0.0, 0.72),
    ];
    stool.add(materials.steel, &props::turned(&base, 2, round));
    let seat = [
        (0.0, 0.7),
        (0.17, 0.7),
        (0.17, 0.7),
        (0.195, 0.73),
        (0.19, 0.775),
        (0.15, 0.795),
        (0.0, 0.79),
    ];
    stool.add(materials.leather, &props::turned(&seat, 2, round));
    let foot = crate::build::torus(0.16, 0.011, round, 8);
    stool.add(materials.steel, &foot.placed(Pose::at(0.0, 0.26, 0.0)));
    stool.add(
        materials.steel,
        &bevelled_box([-0.16, 0.252, -0.008], [0.16, 0.268, 0.008], 0.003),
    );
    let poses: Vec<Pose> = [-2.2, -1.35, -0.45, 0.4, 1.3]
        .into_iter()
        .zip([0.0, -0.08, 0.05, -0.02, -0.12])
        .map(|(z, aside)| Pose::at(FACE - 0.45 + aside, 0.0, z).turned(47.0 * z))
        .collect();
    scene.place_copies("stool", stool, &poses);
}

/// Number of lit shelves.
const SHELVES: u32 = 3;

/// Height of the upper side of a shelf.
fn shelf_height(level: u32) -> f64 {
    0.95 + 0.48 * f64::from(level)
}

/// Shelves on the right wall. A strip of light under each shelf lights the one below.
fn shelves(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let (front, wall) = (HALF_WIDTH - 0.3, HALF_WIDTH);
    assembly.add(
        materials.panel,
        &bevelled_box([wall - 0.03, 0.0, FAR], [wall, 2.4, NEAR], 0.006),
    );
    assembly.add(
        materials.black,
        &bevelled_box([wall - 0.5, 0.0, FAR], [wall - 0.02, 0.92, NEAR], 0.008),
    );
    for level in 0..=SHELVES {
        let y = shelf_height(level);
        assembly.add(
            materials.walnut,
            &bevelled_box([front, y - 0.03, FAR], [wall - 0.02, y, NEAR], 0.004),
        );
    }
    let mut bottles = Bottles::new(scene, detail);
    for level in 0..SHELVES {
        let y = shelf_height(level);
        bottles.fill_shelf(scene, materials, y);
        let strip = Pose::at(front + 0.06, y + 0.445, (NEAR + FAR) / 2.0)
            .tilted(90.0)
            .stretched(0.01, 2.5, 1.0);
        scene.place_emitter(
            &format!("shelf_strip_{level}"),
            ShapeKind::Rectangle,
            strip,
            materials.lamp,
            [52.0, 31.0, 14.0],
        );
    }
    scene.place_assembly("shelf", assembly);
}

/// Places bottles of random size and color.
struct Bottles {
    bottle: MeshId,
    label: MeshId,
    rng: Pcg32,
    /// Number of bottles so far.
    count: usize,
}

impl Bottles {
    fn new(scene: &mut Scene, detail: Detail) -> Bottles {
        let bottle = [
            (0.0, 0.0),
            (0.034, 0.0),
            (0.034, 0.0),
            (0.037, 0.006),
            (0.037, 0.17),
            (0.03, 0.2),
            (0.0135, 0.225),
            (0.0125, 0.285),
            (0.0125, 0.285),
            (0.0155, 0.288),
            (0.0155, 0.305),
            (0.0, 0.305),
        ];
        let label = [(0.0377, 0.0), (0.0377, 0.07)].map(DVec2::from);
        let segments = detail.segments(18);
        Bottles {
            bottle: scene.add_mesh("bottle", props::turned(&bottle, 2, segments)),
            label: scene.add_mesh("label", lathe(&label, segments)),
            rng: Pcg32::new(88),
            count: 0,
        }
    }

    /// Places a row of bottles on a shelf at height `y`.
    fn fill_shelf(&mut self, scene: &mut Scene, materials: &DiscoMaterials, y: f64) {
        let colors = [
            materials.green_glass,
            materials.amber_glass,
            materials.blue_glass,
            materials.amber_glass,
        ];
        let mut z = FAR + 0.15;
        while z < NEAR - 0.15 {
            let glass = colors[self.rng.index(colors.len())];
            let size = self.rng.range(0.85, 1.15);
            let x = HALF_WIDTH - 0.16 + self.rng.jitter(0.03);
            scene.place(
                &format!("bottle_{}", self.count),
                ShapeKind::Mesh(self.bottle),
                Pose::at(x, y, z).stretched(1.0, size, 1.0),
                glass,
            );
            scene.place(
                &format!("label_{}", self.count),
                ShapeKind::Mesh(self.label),
                Pose::at(x, y + 0.06, z),
                materials.label,
            );
            self.count += 1;
            z += self.rng.range(0.1, 0.3);
        }
    }
}

/// Glasses and an ice bucket on the counter, and the high table.
fn drinks(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let tumbler = [
        (0.0, 0.0),
        (0.03, 0.0),
        (0.03, 0.0),
        (0.035, 0.005),
        (0.04, 0.1),
        (0.04, 0.1),
        (0.0375, 0.1),
        (0.0375, 0.1),
        (0.033, 0.014),
        (0.033, 0.014),
        (0.0, 0.012),
    ];
    let tumbler = scene.add_mesh("tumbler", props::turned(&tumbler, 2, detail.segments(24)));
    for (i, z) in [1.55, 1.66, -0.2, -1.5].into_iter().enumerate() {
        let pose = Pose::at(FACE + 0.12 + 0.05 * (i % 2) as f64, 1.115, z);
        scene.place(
            &format!("tumbler_{i}"),
            ShapeKind::Mesh(tumbler),
            pose,
            materials.glass,
        );
    }
    let bucket = [
        (0.0, 0.0),
        (0.07, 0.0),
        (0.07, 0.0),
        (0.075, 0.008),
        (0.1, 0.2),
        (0.106, 0.205),
        (0.106, 0.205),
        (0.096, 0.2),
        (0.07, 0.012),
        (0.07, 0.012),
        (0.0, 0.01),
    ];
    let bucket = scene.add_mesh("bucket", props::turned(&bucket, 2, detail.segments(28)));
    high_table(scene, materials, detail, tumbler);
    scene.place(
        "bucket",
        ShapeKind::Mesh(bucket),
        Pose::at(FACE + 0.15, 1.115, 0.6),
        materials.steel,
    );
}

/// A high table near the camera with two glasses and a candle.
fn high_table(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail, tumbler: MeshId) {
    /// Height of the table top.
    const TOP: f64 = 1.09;
    let (x, z) = (-2.55, 3.0);
    let mut assembly = Assembly::default();
    let base = [
        (0.0, 0.0),
        (0.24, 0.0),
        (0.24, 0.0),
        (0.245, 0.012),
        (0.05, 0.035),
        (0.03, 0.06),
        (0.03, 0.06),
        (0.03, 1.02),
        (0.03, 1.02),
        (0.12, 1.06),
        (0.12, 1.06),
        (0.0, 1.06),
    ];
    assembly.add(
        materials.steel,
        &props::turned(&base, 2, detail.segments(28)).placed(Pose::at(x, 0.0, z)),
    );
    let top = bevelled_cylinder(0.32, 0.031, 0.007, detail.segments(40));
    assembly.add(materials.walnut, &top.placed(Pose::at(x, TOP - 0.031, z)));
    let candle = bevelled_cylinder(0.032, 0.045, 0.003, detail.segments(18));
    assembly.add(
        materials.label,
        &candle.placed(Pose::at(x - 0.02, TOP, z + 0.12)),
    );
    scene.place_assembly("high_table", assembly);
    for (i, (dx, dz)) in [(0.1, -0.07), (-0.14, -0.03)].into_iter().enumerate() {
        let pose = Pose::at(x + dx, TOP, z + dz);
        scene.place(
            &format!("table_tumbler_{i}"),
            ShapeKind::Mesh(tumbler),
            pose,
            materials.glass,
        );
        let drink = scene.add_mesh(
            &format!("drink_{i}"),
            bevelled_cylinder(0.0325, 0.035, 0.002, detail.segments(20)),
        );
        let inside = Pose::at(x + dx, TOP + 0.0145, z + dz);
        scene.place(
            &format!("drink_{i}"),
            ShapeKind::Mesh(drink),
            inside,
            materials.amber_glass,
        );
    }
}
