//! Pots on the stove, and pans on a rail beside it.

use super::{BACK, HOBS, KitchenMaterials, WORKTOP};
use crate::build::{catmull_rom, cylinder, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::Assembly;
use crate::scenes::{Detail, props};
use glam::DVec3;

pub(super) fn add(assembly: &mut Assembly, materials: &KitchenMaterials, detail: Detail) {
    pots(assembly, materials, detail);
    rail(assembly, materials, detail);
}

/// A stock pot, a casserole, a saucepan and a kettle.
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

/// An open pan on the plane y = 0.
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

/// A domed lid with a knob for a pan of `radius`, with its rim at y = 0.
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

/// A loop handle at +x for a pan of `radius`, at `height`.
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

/// A long handle towards +x for a pan of `radius`, from `height` slightly upwards.
fn long_handle(radius: f64, height: f64, detail: Detail) -> Mesh {
    let path = [(-0.002, 0.0), (0.03, 0.006), (0.1, 0.025), (0.19, 0.04)]
        .map(|(x, y)| DVec3::new(radius + x, height + y, 0.0));
    tube(&path, detail.segments(8), |t| 0.007 + 0.002 * t)
}

/// A kettle with its spout towards +x.
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
    let grip = catmull_rom(
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

/// A brass rail between window and hood, with two pans on hooks.
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
        // The bottom of the pan faces the wall, the handle points up.
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
