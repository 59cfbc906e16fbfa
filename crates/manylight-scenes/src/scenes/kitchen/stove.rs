//! The range with its hood, what cooks on it, and the pans on the rail beside it.

use super::units::STOVE;
use super::{BACK, KitchenMaterials, WORKTOP, WORKTOP_FRONT};
use crate::build::{
    Edges, bevelled_box, bevelled_cylinder, boxed, cylinder, grid, loft, torus, tube,
};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::{Detail, props};
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    range(&mut assembly, materials, detail);
    hood(&mut assembly, materials);
    pots(&mut assembly, materials, detail);
    rail(&mut assembly, materials, detail);
    scene.place_assembly("stove", assembly);
}

/// A steel range: black glass on top, an oven with a window, a row of knobs.
fn range(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let [left, right] = STOVE;
    let front = WORKTOP_FRONT - 0.03;
    let width = right - left;
    let middle = (left + right) / 2.0;
    assembly.add(
        materials.satin_steel,
        &boxed([left, 0.09, BACK + 0.01], [right, 0.9, front - 0.03]),
    );
    assembly.add(
        materials.iron,
        &boxed(
            [left + 0.03, 0.0, BACK + 0.05],
            [right - 0.03, 0.1, front - 0.08],
        ),
    );
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left, 0.79, front - 0.05],
            [right, 0.905, front + 0.01],
            0.006,
        ),
    );
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left + 0.004, 0.27, front - 0.04],
            [right - 0.004, 0.782, front],
            0.006,
        ),
    );
    assembly.add(
        materials.satin_steel,
        &bevelled_box(
            [left + 0.004, 0.1, front - 0.04],
            [right - 0.004, 0.262, front - 0.002],
            0.006,
        ),
    );
    assembly.add(
        materials.black,
        &bevelled_box(
            [left + 0.13, 0.36, front - 0.01],
            [right - 0.13, 0.64, front + 0.003],
            0.002,
        ),
    );
    assembly.add(
        materials.black,
        &bevelled_box(
            [left, 0.895, BACK + 0.02],
            [right, WORKTOP + 0.004, front - 0.02],
            0.003,
        ),
    );
    let half = width / 2.0 - 0.06;
    let bar = [(-half, 0.0), (-half, 0.045), (half, 0.045), (half, 0.0)]
        .map(|(x, z)| DVec3::new(middle + x, 0.72, front + z));
    assembly.add(materials.steel, &tube(&bar, detail.segments(10), |_| 0.009));
    towel(
        assembly,
        materials,
        detail,
        DVec3::new(middle + 0.17, 0.72, front + 0.045),
    );
    let knob = bevelled_cylinder(0.02, 0.026, 0.004, detail.segments(18));
    for i in 0..6 {
        let x = left + 0.1 + (width - 0.2) * f64::from(i) / 5.0;
        assembly.add(
            materials.steel,
            &knob.placed(Pose::at(x, 0.848, front + 0.008).tilted(90.0)),
        );
    }
    let grate = torus(0.085, 0.005, detail.segments(24), 6);
    for (x, z) in HOBS {
        assembly.add(
            materials.iron,
            &grate.placed(Pose::at(x, WORKTOP + 0.009, z)),
        );
    }
}

/// A towel with a stripe, hung over the bar before the oven at a point of its axis.
fn towel(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail, over: DVec3) {
    let columns = detail.segments(16);
    // From its front hem over the bar to the one at the back.
    let course = [
        (-0.33, 0.016),
        (-0.3, 0.016),
        (-0.27, 0.016),
        (-0.15, 0.015),
        (-0.04, 0.013),
        (0.006, 0.008),
        (0.0115, 0.0),
        (0.006, -0.008),
        (-0.04, -0.013),
        (-0.22, -0.014),
    ];
    let row = |&(y, z): &(f64, f64)| -> Vec<DVec3> {
        (0..=columns)
            .map(|i| {
                let u = i as f64 / columns as f64;
                // Folds grow with the distance from the bar, outwards only.
                let fold = 0.014 * (-y).max(0.0) / 0.33 * (1.0 + (u * 15.0).sin());
                over + DVec3::new(0.2 * (u - 0.5), y, z + fold * z.signum().max(0.0))
            })
            .collect()
    };
    let rows: Vec<Vec<DVec3>> = course.iter().map(row).collect();
    let cloth = |rows: &[Vec<DVec3>]| grid(rows, Edges::Open, 60.0);
    assembly.add(materials.linen, &cloth(&rows[..2]));
    assembly.add(materials.blue_glaze, &cloth(&rows[1..3]));
    assembly.add(materials.linen, &cloth(&rows[2..]));
}

/// Middles of the four hobs.
const HOBS: [(f64, f64); 4] = [
    (0.17, BACK + 0.19),
    (0.63, BACK + 0.19),
    (0.17, BACK + 0.45),
    (0.63, BACK + 0.45),
];

/// A hood of copper: a skirt, a tapering body, a chimney.
fn hood(assembly: &mut Assembly, materials: &KitchenMaterials) {
    let middle = (STOVE[0] + STOVE[1]) / 2.0;
    let ring = |half: f64, depth: f64, y: f64| {
        let (low, high) = (middle - half, middle + half);
        let (rear, front) = (BACK + 0.01, BACK + depth);
        [(low, rear), (low, front), (high, front), (high, rear)]
            .map(|(x, z)| DVec3::new(x, y, z))
            .to_vec()
    };
    let body = [
        ring(0.45, 0.5, 1.63),
        ring(0.45, 0.5, 1.7),
        ring(0.435, 0.485, 1.71),
        ring(0.33, 0.4, 1.86),
        ring(0.22, 0.31, 2.06),
        ring(0.16, 0.26, 2.22),
        ring(0.15, 0.25, 2.45),
        ring(0.15, 0.25, 2.62),
    ];
    assembly.add(materials.copper, &loft(&body, 28.0));
    for y in [1.645, 1.69] {
        let (low, high) = (middle - 0.453, middle + 0.453);
        assembly.add(
            materials.brass,
            &bevelled_box(
                [low, y - 0.007, BACK + 0.012],
                [high, y + 0.007, BACK + 0.504],
                0.002,
            ),
        );
    }
}

/// A copper pan, an enamelled casserole, a steel stock pot, a kettle.
fn pots(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let top = WORKTOP + 0.014;
    let [(x0, z0), (x1, z1), (x2, z2), (x3, z3)] = HOBS;
    let at = |x: f64, z: f64| Pose::at(x, top, z);
    assembly.add(materials.steel, &pan(0.1, 0.17, detail).placed(at(x0, z0)));
    assembly.add(
        materials.steel,
        &lid(0.1, detail).placed(Pose::at(x0, top + 0.17, z0)),
    );
    for side in [0.0, 180.0] {
        assembly.add(
            materials.steel,
            &loop_handle(0.1, 0.13, detail).placed(at(x0, z0).turned(side + 20.0)),
        );
    }
    assembly.add(
        materials.red_enamel,
        &pan(0.125, 0.105, detail).placed(at(x1, z1)),
    );
    assembly.add(
        materials.red_enamel,
        &lid(0.125, detail).placed(Pose::at(x1, top + 0.105, z1)),
    );
    for side in [0.0, 180.0] {
        assembly.add(
            materials.red_enamel,
            &loop_handle(0.125, 0.085, detail).placed(at(x1, z1).turned(side - 10.0)),
        );
    }
    assembly.add(
        materials.copper,
        &pan(0.09, 0.085, detail).placed(at(x3, z3)),
    );
    assembly.add(
        materials.brass,
        &long_handle(0.09, 0.065, detail).placed(at(x3, z3).turned(-40.0)),
    );
    kettle(assembly, materials, detail, at(x2, z2).turned(205.0));
}

/// An open pan of a radius and height.
fn pan(radius: f64, height: f64, detail: Detail) -> Mesh {
    let (r, h, t) = (radius, height, 0.003);
    let profile = [
        (0.0, 0.0),
        (r - 0.012, 0.0),
        (r - 0.012, 0.0),
        (r - 0.003, 0.004),
        (r, 0.014),
        (r, 0.014),
        (r, h - 0.006),
        (r, h - 0.006),
        (r + 0.004, h),
        (r + 0.004, h),
        (r - t, h - 0.004),
        (r - t, h - 0.004),
        (r - t, 0.01),
        (r - t, 0.01),
        (0.0, 0.007),
    ];
    props::turned(&profile, 2, detail.segments(32))
}

/// A domed lid with a knob, its rim at y = 0.
fn lid(radius: f64, detail: Detail) -> Mesh {
    let r = radius + 0.004;
    let profile = [
        (0.0, 0.001),
        (r, 0.001),
        (r, 0.001),
        (r, 0.006),
        (r * 0.93, 0.012),
        (r * 0.6, 0.024),
        (0.012, 0.031),
        (0.012, 0.031),
        (0.009, 0.041),
        (0.018, 0.048),
        (0.016, 0.056),
        (0.0, 0.058),
    ];
    props::turned(&profile, 2, detail.segments(32))
}

/// A handle like an ear at +x.
fn loop_handle(radius: f64, height: f64, detail: Detail) -> Mesh {
    let path = [
        (-0.002, -0.035),
        (0.02, -0.034),
        (0.033, -0.02),
        (0.033, 0.02),
        (0.02, 0.034),
        (-0.002, 0.035),
    ]
    .map(|(x, z)| DVec3::new(radius + x, height, z));
    tube(&path, detail.segments(8), |_| 0.005)
}

/// A long handle towards +x that rises a little.
fn long_handle(radius: f64, height: f64, detail: Detail) -> Mesh {
    let path = [(-0.002, 0.0), (0.03, 0.006), (0.1, 0.025), (0.19, 0.04)]
        .map(|(x, y)| DVec3::new(radius + x, height + y, 0.0));
    tube(&path, detail.segments(8), |t| 0.007 + 0.002 * t)
}

fn kettle(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail, pose: Pose) {
    let body = [
        (0.0, 0.0),
        (0.1, 0.0),
        (0.1, 0.0),
        (0.106, 0.015),
        (0.1, 0.07),
        (0.06, 0.125),
        (0.04, 0.132),
        (0.04, 0.132),
        (0.035, 0.142),
        (0.01, 0.147),
        (0.01, 0.147),
        (0.014, 0.16),
        (0.0, 0.168),
    ];
    assembly.add(
        materials.steel,
        &props::turned(&body, 3, detail.segments(32)).placed(pose),
    );
    let spout = [(0.085, 0.06), (0.125, 0.095), (0.15, 0.125)].map(|(x, y)| DVec3::new(x, y, 0.0));
    assembly.add(
        materials.steel,
        &tube(&spout, detail.segments(12), |t| 0.02 - 0.009 * t).placed(pose),
    );
    let grip = crate::build::catmull_rom(
        &[
            (-0.085, 0.09),
            (-0.09, 0.17),
            (-0.05, 0.225),
            (0.03, 0.23),
            (0.062, 0.17),
            (0.06, 0.12),
        ]
        .map(|(x, y)| DVec3::new(x, y, 0.0)),
        4,
    );
    assembly.add(
        materials.black,
        &tube(&grip, detail.segments(10), |_| 0.007).placed(pose),
    );
}

/// A brass rail on the tiles between window and hood, with pans on hooks.
fn rail(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    let (y, z) = (1.92, BACK + 0.06);
    let (left, right) = (-0.43, -0.06);
    assembly.add(
        materials.brass,
        &tube(
            &[DVec3::new(left, y, z), DVec3::new(right, y, z)],
            detail.segments(12),
            |_| 0.008,
        ),
    );
    for x in [left + 0.03, right - 0.03] {
        assembly.add(
            materials.brass,
            &cylinder(0.006, 0.062, 8).placed(Pose::at(x, y, BACK).tilted(90.0)),
        );
    }
    for (i, (x, radius, drop)) in [(-0.345, 0.085, 0.2), (-0.145, 0.072, 0.17)]
        .into_iter()
        .enumerate()
    {
        let hook = [
            (0.012, -0.004),
            (0.0, 0.011),
            (-0.012, 0.0),
            (-0.012, -0.03),
        ]
        .map(|(dz, dy)| DVec3::new(x, y + dy, z + dz));
        assembly.add(materials.iron, &tube(&hook, 6, |_| 0.0025));
        // Its bottom towards the wall, its handle up.
        let material = if i == 0 {
            materials.copper
        } else {
            materials.steel
        };
        let center = Pose::at(x, y - 0.03 - drop - radius, BACK + 0.018);
        assembly.add(
            material,
            &pan(radius, 0.045, detail).placed(center.tilted(90.0)),
        );
        let handle = [
            (0.0, radius - 0.003),
            (0.012, radius + 0.04),
            (0.018, radius + drop * 0.6),
            (0.026, radius + drop + 0.005),
        ]
        .map(|(dz, dy)| DVec3::new(0.0, dy, 0.02 + dz));
        assembly.add(materials.iron, &tube(&handle, 8, |_| 0.006).placed(center));
    }
}
