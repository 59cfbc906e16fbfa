//! A corridor in the shape of a U, lit at one end and seen from the other.

use super::{Detail, props};
use crate::build::{
    bevelled_box, bevelled_cylinder, boxed, cylinder, moulding, superellipsoid, tube,
};
use crate::material::{Metal, coated, matte, metal, tinted_metal};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{About, Assembly, Camera, MaterialId, Scene, ShapeKind};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Outer walls in x, and where both legs and the part across end in z.
const OUTER: f64 = 3.0;
const INNER: f64 = 0.6;
const NEAR: f64 = 2.2;
const FAR: f64 = -7.4;
const BEND: f64 = -5.0;
const HEIGHT: f64 = 2.8;
const TILE: f64 = 0.6;

/// The scene.
pub(super) fn scene(detail: Detail) -> Scene {
    let mut scene = Scene::new(
        About {
            title: "U-shaped corridor",
            text: vec![
                "What it shows: the corridor of a grand hotel, bent twice. The only light is a tall window at the end of \
                 one leg; the eye stands at the end of the other. All that is seen has come round two corners, mostly over \
                 polished stone, lacquer, champagne-colored metal and brass, so that there is next to no direct light, and \
                 light that diffuse virtual lights cannot carry."
                    .to_owned(),
                "Units: meters, y up. The legs run along z, 2.4 wide and 2.8 high; x < 0 is that of the camera. Written \
                 by manylight-scenes."
                    .to_owned(),
            ],
        },
        Camera {
            origin: DVec3::new(-1.95, 1.42, 1.85),
            target: DVec3::new(-1.62, 1.12, -4.0),
            fov_x: 64.0,
            size: [640, 360],
            max_depth: 24,
        },
    );
    let materials = CorridorMaterials::new(&mut scene);
    floor(&mut scene, &materials);
    walls(&mut scene, &materials);
    ceiling(&mut scene, &materials, detail);
    window(&mut scene, &materials);
    door(&mut scene, &materials, detail);
    bench(&mut scene, &materials, detail);
    console(&mut scene, &materials, detail);
    sculpture(&mut scene, &materials, detail);
    plants(&mut scene, &materials, detail);
    sconces(&mut scene, &materials, detail);
    painting(&mut scene, &materials);
    scene
}

/// The materials.
struct CorridorMaterials {
    stone: [MaterialId; 2],
    backing: MaterialId,
    plaster: MaterialId,
    sage: MaterialId,
    walnut: MaterialId,
    champagne: MaterialId,
    brass: MaterialId,
    bronze: MaterialId,
    leather: MaterialId,
    black: MaterialId,
    glaze: MaterialId,
    opal: MaterialId,
    leaf: MaterialId,
    soil: MaterialId,
    cover: [MaterialId; 2],
}

impl CorridorMaterials {
    fn new(scene: &mut Scene) -> CorridorMaterials {
        CorridorMaterials {
            stone: [
                scene.add_material("dark_stone", coated([0.055, 0.07, 0.065], 0.09)),
                scene.add_material("pale_stone", coated([0.62, 0.56, 0.47], 0.11)),
            ],
            backing: scene.add_material("backing", matte([0.05, 0.045, 0.04])),
            plaster: scene.add_material("plaster", matte([0.82, 0.79, 0.73])),
            sage: scene.add_material("sage_lacquer", coated([0.64, 0.74, 0.66], 0.16)),
            walnut: scene.add_material("walnut", coated([0.38, 0.185, 0.085], 0.14)),
            champagne: scene.add_material(
                "champagne_metal",
                tinted_metal(Metal::Aluminium, 0.2, [0.86, 0.8, 0.71]),
            ),
            brass: scene.add_material("brass", metal(Metal::Brass, 0.12)),
            bronze: scene.add_material("bronze", metal(Metal::Bronze, 0.1)),
            leather: scene.add_material("leather", coated([0.45, 0.085, 0.045], 0.3)),
            black: scene.add_material("black_lacquer", coated([0.02, 0.02, 0.022], 0.08)),
            glaze: scene.add_material("teal_glaze", coated([0.02, 0.17, 0.19], 0.08)),
            opal: scene.add_material("opal_glass", coated([0.85, 0.82, 0.76], 0.1)),
            leaf: scene.add_material("leaf", coated([0.1, 0.28, 0.06], 0.25)),
            soil: scene.add_material("soil", matte([0.07, 0.045, 0.03])),
            cover: [
                scene.add_material("red_cloth", coated([0.42, 0.07, 0.05], 0.35)),
                scene.add_material("sand_cloth", coated([0.6, 0.48, 0.3], 0.35)),
            ],
        }
    }
}

/// Slabs of two kinds of stone in a checkerboard, none of them quite level.
fn floor(scene: &mut Scene, materials: &CorridorMaterials) {
    let mut rng = Pcg32::new(11);
    let mut assembly = Assembly::default();
    let columns = (2.0 * OUTER / TILE).round() as i32;
    let rows = ((NEAR - FAR) / TILE).round() as i32;
    for row in 0..rows {
        for column in 0..columns {
            let x = -OUTER + TILE * (f64::from(column) + 0.5);
            let z = FAR + TILE * (f64::from(row) + 0.5);
            if x.abs() < INNER && z > BEND {
                continue;
            }
            let half = TILE / 2.0 - 0.001;
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

/// The way round the room with the room on the right hand.
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

/// Panels above a wainscot on each wall, between mouldings that go all the way round.
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
        let post = |half: f64| {
            bevelled_box(
                [x - half, 0.13, BEND - half],
                [x + half, 2.56, BEND + half],
                0.006,
            )
        };
        assembly.add(materials.brass, &post(0.034));
    }
    let profile =
        |points: &[(f64, f64)]| points.iter().copied().map(DVec2::from).collect::<Vec<_>>();
    let skirting = profile(&[
        (0.0, 0.001),
        (0.036, 0.001),
        (0.036, 0.1),
        (0.028, 0.125),
        (0.0, 0.125),
    ]);
    let rail = profile(&[
        (0.0, 0.93),
        (0.04, 0.935),
        (0.046, 0.95),
        (0.04, 0.965),
        (0.0, 0.97),
    ]);
    let cornice = profile(&[
        (0.0, 2.56),
        (0.03, 2.56),
        (0.034, 2.6),
        (0.055, 2.66),
        (0.1, 2.72),
        (0.16, 2.75),
        (0.165, 2.801),
        (0.0, 2.801),
    ]);
    assembly.add(materials.walnut, &moulding(&skirting, &outline(0.0), 35.0));
    assembly.add(materials.brass, &moulding(&rail, &outline(0.0), 35.0));
    assembly.add(materials.plaster, &moulding(&cornice, &outline(0.0), 35.0));
    scene.place_assembly("wall", assembly);
}

/// A wall along x from 0 that faces z.
fn panels(materials: &CorridorMaterials, upper: MaterialId, length: f64) -> Assembly {
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

/// Plaster between beams, with unlit lamps let into it.
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
    scene.place_assembly("ceiling", assembly);
}

/// The light, behind steel bars at the end of the other leg.
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

/// A closed door in the wall on the left.
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
    scene.place_assembly("door", {
        let mut placed = Assembly::default();
        placed.add_placed(&assembly, Pose::at(-OUTER, 0.0, -5.25).turned(90.0));
        placed
    });
}

/// A leather bench by the outer wall.
fn bench(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let seat = superellipsoid([0.285, 0.065, 0.235], 0.3, 0.22, detail.segments(36));
    let back = superellipsoid([0.285, 0.17, 0.055], 0.25, 0.3, detail.segments(36));
    for i in [-1.0, 0.0, 1.0] {
        assembly.add(
            materials.leather,
            &seat.placed(Pose::at(0.565 * i, 0.405, 0.0)),
        );
        assembly.add(
            materials.leather,
            &back.placed(Pose::at(0.565 * i, 0.62, -0.19).tilted(-8.0)),
        );
    }
    assembly.add(
        materials.walnut,
        &bevelled_box([-0.87, 0.29, -0.24], [0.87, 0.35, 0.24], 0.008),
    );
    for x in [-0.8, 0.8] {
        for z in [-0.18, 0.18] {
            let leg = tube(
                &[DVec3::new(x * 1.03, 0.0, z * 1.1), DVec3::new(x, 0.295, z)],
                detail.segments(12),
                |t| 0.011 + 0.008 * t,
            );
            assembly.add(materials.brass, &leg);
        }
    }
    scene.place_assembly(
        "bench",
        assembly.placed(Pose::at(-OUTER + 0.31, 0.0, -2.35).turned(90.0)),
    );
}

/// A narrow table by the inner wall with a vase, a bowl and books.
fn console(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.black,
        &bevelled_box([-0.6, 0.78, -0.16], [0.6, 0.81, 0.16], 0.005),
    );
    assembly.add(
        materials.black,
        &bevelled_box([-0.52, 0.16, -0.12], [0.52, 0.175, 0.12], 0.003),
    );
    for x in [-0.54, 0.54] {
        for z in [-0.12, 0.12] {
            let leg = bevelled_box(
                [x - 0.011, 0.0, z - 0.011],
                [x + 0.011, 0.781, z + 0.011],
                0.002,
            );
            assembly.add(materials.brass, &leg);
        }
    }
    assembly.add(
        materials.glaze,
        &props::vase(detail).placed(Pose::at(-0.38, 0.81, 0.0).scaled(1.15)),
    );
    assembly.add(
        materials.bronze,
        &props::bowl(detail).placed(Pose::at(0.36, 0.81, 0.0).scaled(0.85)),
    );
    let books = props::lying_books(3, &mut Pcg32::new(5));
    for (i, book) in books.iter().enumerate() {
        assembly.add(
            materials.cover[i % 2],
            &book.placed(Pose::at(-0.02, 0.81, 0.0)),
        );
    }
    let lower = props::lying_books(2, &mut Pcg32::new(6));
    for (i, book) in lower.iter().enumerate() {
        assembly.add(
            materials.cover[(i + 1) % 2],
            &book.placed(Pose::at(0.2, 0.175, 0.0).turned(80.0)),
        );
    }
    scene.place_assembly(
        "console",
        assembly.placed(Pose::at(-INNER - 0.22, 0.0, -3.3).turned(-90.0)),
    );
}

/// A knot of bronze on a plinth where the corridor bends, before fins of brass.
fn sculpture(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let pieces = detail.segments(150);
    let knot: Vec<DVec3> = (0..=pieces)
        .map(|i| {
            let t = TAU * (i % pieces) as f64 / pieces as f64;
            let r = 0.2 + 0.085 * (3.0 * t).cos();
            DVec3::new(
                r * (2.0 * t).cos(),
                r * (2.0 * t).sin(),
                0.11 * (3.0 * t).sin(),
            )
        })
        .collect();
    let mut assembly = Assembly::default();
    let body = tube(&knot, detail.segments(14), |_| 0.047);
    assembly.add(
        materials.bronze,
        &body.placed(Pose::at(-1.72, 1.325, -6.3).turned(24.0)),
    );
    let base = bevelled_cylinder(0.09, 0.03, 0.004, detail.segments(28));
    assembly.add(materials.black, &base.placed(Pose::at(-1.72, 1.0, -6.3)));
    assembly.add(
        materials.stone[1],
        &bevelled_box([-1.95, 0.0, -6.53], [-1.49, 1.0, -6.07], 0.008),
    );
    for i in 0..19 {
        let x = -2.88 + 0.12 * f64::from(i);
        let fin = bevelled_box(
            [x - 0.008, 0.98, FAR],
            [x + 0.008, 2.55, FAR + 0.075],
            0.003,
        );
        assembly.add(materials.brass, &fin);
    }
    scene.place_assembly("sculpture", assembly);
}

/// Plants in glazed pots.
fn plants(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut rng = Pcg32::new(3);
    let pot = scene.add_mesh("pot", props::pot(detail));
    let soil = scene.add_mesh("soil", cylinder(0.141, 0.02, detail.segments(24)));
    let leaves = detail.count(30).min(240);
    let tuft = scene.add_mesh(
        "strap_plant",
        props::strap_plant(leaves, 0.85, 0.6, &mut rng),
    );
    for (i, (x, z, scale, turn)) in [
        (-1.08, -0.75, 1.1, 0.0),
        (-2.4, -4.3, 1.2, 140.0),
        (0.0, -6.83, 1.15, 70.0),
    ]
    .into_iter()
    .enumerate()
    {
        let stand = Pose::at(x, 0.0, z).scaled(scale);
        let pose = stand.turned(turn);
        let lifted = |by: f64| Pose {
            position: pose.position + DVec3::Y * by * scale,
            ..pose
        };
        let glaze = if i == 1 {
            materials.opal
        } else {
            materials.glaze
        };
        scene.place(&format!("pot_{i}"), ShapeKind::Mesh(pot), stand, glaze);
        scene.place(
            &format!("soil_{i}"),
            ShapeKind::Mesh(soil),
            lifted(0.3),
            materials.soil,
        );
        scene.place(
            &format!("plant_{i}"),
            ShapeKind::Mesh(tuft),
            lifted(0.31),
            materials.leaf,
        );
    }
}

/// A painting of a few fields of color in a black frame, on the wall on the left.
fn painting(scene: &mut Scene, materials: &CorridorMaterials) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.black,
        &bevelled_box([-0.5, 1.2, 0.0], [0.5, 1.95, 0.045], 0.004),
    );
    assembly.add(
        materials.plaster,
        &bevelled_box([-0.47, 1.23, 0.01], [0.47, 1.92, 0.047], 0.001),
    );
    for (material, low, high) in [
        (materials.glaze, [-0.36, 1.34], [0.02, 1.81]),
        (materials.cover[0], [0.05, 1.34], [0.36, 1.58]),
        (materials.cover[1], [0.05, 1.61], [0.36, 1.81]),
    ] {
        assembly.add(
            material,
            &boxed([low[0], low[1], 0.02], [high[0], high[1], 0.0475]),
        );
    }
    scene.place_assembly(
        "painting",
        assembly.placed(Pose::at(-OUTER + 0.015, 0.0, -2.4).turned(90.0)),
    );
}

/// Lamps on the walls, not lit.
fn sconces(scene: &mut Scene, materials: &CorridorMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let shade = props::turned(
        &[
            (0.03, 0.0),
            (0.06, 0.02),
            (0.085, 0.08),
            (0.09, 0.15),
            (0.09, 0.15),
            (0.086, 0.15),
            (0.086, 0.15),
            (0.081, 0.08),
            (0.056, 0.024),
            (0.0, 0.01),
        ],
        3,
        detail.segments(24),
    );
    assembly.add(materials.opal, &shade.placed(Pose::at(0.0, 1.72, 0.135)));
    let cup = props::turned(
        &[
            (0.0, -0.02),
            (0.03, -0.015),
            (0.045, 0.012),
            (0.045, 0.012),
            (0.0, 0.012),
        ],
        3,
        detail.segments(20),
    );
    assembly.add(materials.brass, &cup.placed(Pose::at(0.0, 1.72, 0.135)));
    assembly.add(
        materials.brass,
        &bevelled_box([-0.035, 1.6, 0.0], [0.035, 1.84, 0.026], 0.005),
    );
    let arm = [(1.66, 0.02), (1.655, 0.09), (1.67, 0.125), (1.705, 0.135)]
        .map(|(y, z)| DVec3::new(0.0, y, z));
    assembly.add(
        materials.brass,
        &tube(
            &crate::build::catmull_rom(&arm, 4),
            detail.segments(10),
            |_| 0.008,
        ),
    );

    let mut placed = Assembly::default();
    for z in [-0.9, -2.2, -4.4] {
        placed.add_placed(&assembly, Pose::at(-INNER, 0.0, z).turned(-90.0));
    }
    for z in [-1.15, -3.65] {
        placed.add_placed(&assembly, Pose::at(-OUTER, 0.0, z).turned(90.0));
    }
    for x in [-0.3, 1.4] {
        placed.add_placed(&assembly, Pose::at(x, 0.0, FAR));
    }
    scene.place_assembly("sconce", placed);
}
