//! The table before the eye, what lies on it, stools, and the lamps above.

use super::KitchenMaterials;
use crate::build::{ball, bevelled_box, bevelled_cylinder, superellipsoid, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// Height of the table top, and its middle.
const TOP: f64 = 0.76;
const MIDDLE: (f64, f64) = (-0.25, 0.75);
/// Half its length and width.
const HALF: (f64, f64) = (0.95, 0.42);

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    table(scene, materials, detail);
    fruit(scene, materials, detail);
    breakfast(scene, materials, detail);
    stools(scene, materials, detail);
    pendants(scene, materials, detail);
}

/// Boards on turned legs.
fn table(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let boards = 5;
    let width = 2.0 * HALF.1 / f64::from(boards);
    for i in 0..boards {
        let z = -HALF.1 + width * f64::from(i);
        let board = bevelled_box(
            [-HALF.0, TOP - 0.035, z + 0.0005],
            [HALF.0, TOP, z + width - 0.0005],
            0.003,
        );
        // Each board gets its own part of the picture.
        let mut mapped = board.box_mapped(0.7);
        for uv in &mut mapped.uvs {
            *uv += DVec2::new(0.37 * f64::from(i), 0.61 * f64::from(i));
        }
        assembly.add(materials.oak, &mapped);
    }
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let (x, z) = (x * (HALF.0 - 0.09), z * (HALF.1 - 0.08));
        let leg = [
            (0.0, 0.0),
            (0.02, 0.0),
            (0.02, 0.0),
            (0.026, 0.12),
            (0.036, 0.42),
            (0.03, 0.5),
            (0.034, 0.52),
            (0.034, 0.52),
            (0.034, 0.61),
            (0.0, 0.61),
        ];
        let turned = props::turned(&leg, 3, detail.segments(20)).box_mapped(0.5);
        assembly.add(materials.oak, &turned.placed(Pose::at(x, 0.0, z)));
        assembly.add(
            materials.oak,
            &bevelled_box(
                [x - 0.035, 0.6, z - 0.035],
                [x + 0.035, TOP - 0.034, z + 0.035],
                0.003,
            )
            .box_mapped(0.5),
        );
    }
    let (x, z) = (HALF.0 - 0.1, HALF.1 - 0.085);
    for side in [-1.0, 1.0] {
        assembly.add(
            materials.oak,
            &bevelled_box(
                [-x, 0.63, side * z - 0.011],
                [x, TOP - 0.034, side * z + 0.011],
                0.002,
            )
            .box_mapped(0.5),
        );
        assembly.add(
            materials.oak,
            &bevelled_box(
                [side * x - 0.011, 0.631, -z],
                [side * x + 0.011, TOP - 0.0345, z],
                0.002,
            )
            .box_mapped(0.5),
        );
    }
    scene.place_assembly("table", assembly.placed(Pose::at(MIDDLE.0, 0.0, MIDDLE.1)));
}

/// A copper bowl of fruit.
fn fruit(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let (x, z) = (MIDDLE.0 - 0.2, MIDDLE.1 - 0.05);
    let bowl = scene.add_mesh("fruit_bowl", props::bowl(detail));
    scene.place(
        "fruit_bowl",
        ShapeKind::Mesh(bowl),
        Pose::at(x, TOP, z).scaled(1.2),
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
        let pose = Pose::at(x + dx, TOP + y, z + dz).tilted(tilt).turned(turn);
        scene.place(&format!("fruit_{i}"), ShapeKind::Mesh(mesh), pose, material);
    }
    let rolled = Pose::at(x + 0.27, TOP + 0.028, z + 0.14)
        .tilted(90.0)
        .turned(35.0);
    scene.place(
        "lemon_on_table",
        ShapeKind::Mesh(lemon),
        rolled,
        materials.lemon,
    );
}

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

/// A board with bread and a knife, a jug, a cup and saucer, a folded cloth.
fn breakfast(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let at = |dx: f64, dz: f64| Pose::at(MIDDLE.0 + dx, TOP, MIDDLE.1 + dz);
    let mut assembly = Assembly::default();
    let place = |assembly: &mut Assembly, material, mesh: &Mesh, pose: Pose| {
        assembly.add(material, &mesh.placed(pose))
    };

    let board = bevelled_box([-0.2, 0.0, -0.12], [0.2, 0.02, 0.12], 0.006);
    let on_board = |dx: f64, dz: f64| {
        let turned = at(0.36, 0.12)
            .turned(14.0)
            .matrix()
            .transform_point3(DVec3::new(dx, 0.02, dz));
        Pose::at(turned.x, turned.y, turned.z).turned(14.0)
    };
    place(
        &mut assembly,
        materials.walnut,
        &board,
        at(0.36, 0.12).turned(14.0),
    );
    let loaf = superellipsoid([0.13, 0.05, 0.065], 0.75, 0.7, detail.segments(28));
    let sunk = on_board(-0.03, -0.03);
    place(
        &mut assembly,
        materials.crust,
        &loaf,
        Pose {
            position: sunk.position + DVec3::Y * 0.046,
            ..sunk
        },
    );
    let blade = bevelled_box([-0.1, 0.0, -0.014], [0.1, 0.002, 0.014], 0.0008);
    place(
        &mut assembly,
        materials.steel,
        &blade,
        on_board(0.02, 0.075),
    );
    let grip = bevelled_box([-0.055, 0.0, -0.011], [0.055, 0.016, 0.011], 0.004);
    place(&mut assembly, materials.black, &grip, on_board(0.17, 0.075));

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
    place(
        &mut assembly,
        materials.blue_glaze,
        &props::turned(&jug, 3, detail.segments(28)),
        at(-0.55, 0.05),
    );
    let ear = [
        (0.05, 0.17),
        (0.09, 0.165),
        (0.11, 0.12),
        (0.095, 0.07),
        (0.066, 0.055),
    ]
    .map(|(x, y)| DVec3::new(x, y, 0.0));
    let ear = tube(
        &crate::build::catmull_rom(&ear, 4),
        detail.segments(10),
        |_| 0.007,
    );
    place(
        &mut assembly,
        materials.blue_glaze,
        &ear,
        at(-0.55, 0.05).turned(200.0),
    );
    let stems = props::strap_plant(14, 0.34, 0.6, &mut Pcg32::new(14));
    let vase_top = at(-0.55, 0.05);
    place(
        &mut assembly,
        materials.leaf,
        &stems,
        Pose {
            position: vase_top.position + DVec3::Y * 0.15,
            ..vase_top
        },
    );

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
    let here = at(-0.02, 0.24);
    place(
        &mut assembly,
        materials.cream_glaze,
        &props::turned(&saucer, 2, detail.segments(28)),
        here,
    );
    let lifted = Pose {
        position: here.position + DVec3::Y * 0.0065,
        ..here
    };
    place(
        &mut assembly,
        materials.cream_glaze,
        &props::turned(&cup, 2, detail.segments(24)),
        lifted,
    );
    let coffee = bevelled_cylinder(0.0355, 0.012, 0.001, detail.segments(20));
    place(
        &mut assembly,
        materials.coffee,
        &coffee,
        Pose {
            position: here.position + DVec3::Y * 0.034,
            ..here
        },
    );
    for (i, fold) in [0.0, 0.005, 0.01].into_iter().enumerate() {
        let half = 0.12 - 0.004 * i as f64;
        let cloth = bevelled_box(
            [-half, fold + 0.0002, -0.085],
            [half, fold + 0.0048, 0.085],
            0.002,
        );
        place(
            &mut assembly,
            materials.linen,
            &cloth,
            at(-0.42, 0.29).turned(-12.0 + 2.0 * i as f64),
        );
    }
    scene.place_assembly("breakfast", assembly);
}

/// Two stools at the table.
fn stools(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut stool = Assembly::default();
    let seat = [
        (0.0, 0.425),
        (0.15, 0.425),
        (0.165, 0.435),
        (0.165, 0.448),
        (0.15, 0.455),
        (0.06, 0.449),
        (0.0, 0.447),
    ];
    stool.add(
        materials.walnut,
        &props::turned(&seat, 2, detail.segments(32)),
    );
    for i in 0..4 {
        let side = DVec3::X.rotate_y((f64::from(i) + 0.5) * FRAC_PI_2);
        let leg = [side * 0.185, side * 0.11 + DVec3::Y * 0.428];
        stool.add(
            materials.walnut,
            &tube(&leg, detail.segments(10), |t| 0.011 + 0.004 * t),
        );
        let next = side.rotate_y(FRAC_PI_2);
        let height = 0.14 + 0.03 * f64::from(i % 2);
        let on_leg = |s: DVec3| s * (0.185 - 0.075 * height / 0.428) + DVec3::Y * height;
        stool.add(
            materials.walnut,
            &tube(&[on_leg(side), on_leg(next)], 8, |_| 0.007),
        );
    }
    let poses = [(-0.78, 1.42, 10.0), (0.55, 0.02, 40.0)]
        .map(|(x, z, turn)| Pose::at(x, 0.0, z).turned(turn));
    scene.place_copies("stool", stool, &poses);
}

/// Copper shades on cords, not lit.
fn pendants(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let shade = [
        (0.16, 0.0),
        (0.15, 0.05),
        (0.1, 0.11),
        (0.03, 0.14),
        (0.025, 0.17),
        (0.025, 0.17),
        (0.0, 0.172),
        (0.0, 0.172),
        (0.0, 0.145),
        (0.0, 0.145),
        (0.03, 0.135),
        (0.098, 0.106),
        (0.146, 0.048),
        (0.156, 0.0),
        (0.156, 0.0),
        (0.16, 0.0),
    ];
    let shade = scene.add_mesh(
        "pendant_shade",
        props::turned(&shade, 3, detail.segments(36)),
    );
    let mut assembly = Assembly::default();
    for (i, x) in [-0.5, 0.25].into_iter().enumerate() {
        let pose = Pose::at(MIDDLE.0 + x, 1.68, MIDDLE.1 - 0.1);
        scene.place(
            &format!("pendant_{i}"),
            ShapeKind::Mesh(shade),
            pose,
            materials.copper,
        );
        let up = |y: f64| Pose {
            position: pose.position + DVec3::Y * y,
            ..pose
        };
        assembly.add(
            materials.cream_glaze,
            &ball(0.04, detail.segments(16)).placed(up(0.075)),
        );
        assembly.add(
            materials.brass,
            &bevelled_cylinder(0.016, 0.06, 0.002, 14).placed(up(0.095)),
        );
        let cord = [DVec3::Y * 0.17, DVec3::Y * 0.925].map(|p| p + pose.position);
        assembly.add(materials.black, &tube(&cord, 6, |_| 0.003));
    }
    scene.place_assembly("pendant", assembly);
}
