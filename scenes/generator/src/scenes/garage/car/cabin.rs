//! The cabin of the car and its windows.

use super::GarageMaterials;
use super::body::SPINE;
use crate::build::{Edges, grid, smooth_table, tube};
use crate::mesh::Mesh;
use crate::scene::Assembly;
use crate::scenes::Detail;
use glam::DVec3;

/// x of the rear end of the cabin.
const REAR: f64 = -1.95;
/// Length of the cabin.
const LENGTH: f64 = 2.9;

/// Height of the roof on the center line, by x.
const ROOF: &[(f64, f64)] = &[
    (-1.95, 0.84),
    (-1.6, 0.935),
    (-1.2, 1.07),
    (-0.8, 1.19),
    (-0.35, 1.26),
    (0.0, 1.255),
    (0.25, 1.2),
    (0.55, 1.07),
    (0.95, 0.85),
];

/// Half the width of the cabin at its base, by x.
const CABIN: &[(f64, f64)] = &[
    (-1.95, 0.4),
    (-1.5, 0.6),
    (-1.0, 0.72),
    (-0.3, 0.755),
    (0.3, 0.74),
    (0.65, 0.68),
    (0.95, 0.52),
];

/// The roof with its pillars; the windows lie on it.
pub(super) fn shell(detail: Detail) -> Mesh {
    let (along, around) = (detail.segments(40), detail.segments(36));
    let rows: Vec<Vec<DVec3>> = (0..=along)
        .map(|i| {
            let x = REAR + LENGTH * i as f64 / along as f64;
            (0..=around)
                .map(|k| cabin_point(x, 180.0 * k as f64 / around as f64))
                .collect()
        })
        .collect();
    grid(&rows, Edges::Open, 50.0).flipped()
}

/// The point of the cabin at `x` and `angle`, in degrees: 0 is the base on the +z side, 90 the
/// center line.
fn cabin_point(x: f64, angle: f64) -> DVec3 {
    let (width, roof) = (smooth_table(CABIN, x), smooth_table(ROOF, x));
    let base = smooth_table(SPINE, x) - 0.1;
    let (sin, cos) = angle.to_radians().sin_cos();
    let power = 2.0 / 2.7;
    let across = cos.abs().powf(power) * cos.signum();
    let up = sin.abs().powf(power);
    let height = base + (roof - base).max(0.01) * up;
    // The last factor leans the sides inwards.
    DVec3::new(x, height, width * across * (1.0 - 0.14 * up))
}

/// Outward unit normal of the cabin.
fn cabin_normal(x: f64, angle: f64) -> DVec3 {
    let along = cabin_point(x + 1e-3, angle) - cabin_point(x - 1e-3, angle);
    let around = cabin_point(x, angle + 0.1) - cabin_point(x, angle - 0.1);
    along.cross(around).normalize()
}

/// Dark panes in chrome frames.
pub(super) fn windows(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    // Corners (x, angle), counterclockwise seen from outside at +z.
    let front_side = [(-0.42, 13.0), (0.52, 13.0), (0.1, 39.0), (-0.42, 41.0)];
    let rear_side = [(-1.12, 15.0), (-0.48, 13.0), (-0.48, 41.0), (-0.82, 37.0)];
    for pane in [front_side, rear_side] {
        add_pane(assembly, materials, detail, pane);
        add_pane(
            assembly,
            materials,
            detail,
            pane.map(|(x, angle)| (x, 180.0 - angle)),
        );
    }
    add_pane(
        assembly,
        materials,
        detail,
        [(0.68, 38.0), (0.68, 142.0), (0.23, 128.0), (0.23, 52.0)],
    );
    add_pane(
        assembly,
        materials,
        detail,
        [(-0.92, 52.0), (-0.92, 128.0), (-1.5, 140.0), (-1.5, 40.0)],
    );
}

/// A pane between four corners (x, angle), 4 mm outside the cabin, with its frame.
fn add_pane(
    assembly: &mut Assembly,
    materials: &GarageMaterials,
    detail: Detail,
    corners: [(f64, f64); 4],
) {
    let n = detail.segments(14);
    let between = |s: f64, t: f64| {
        let mix = |pick: fn(&(f64, f64)) -> f64| {
            let [a, b, c, d] = corners.map(|corner| pick(&corner));
            (a * (1.0 - s) + b * s) * (1.0 - t) + (d * (1.0 - s) + c * s) * t
        };
        (mix(|c| c.0), mix(|c| c.1))
    };
    let at = |s: f64, t: f64| {
        let (x, angle) = between(s, t);
        cabin_point(x, angle) + cabin_normal(x, angle) * 0.004
    };
    let fraction = |i: usize| i as f64 / n as f64;
    let rows: Vec<Vec<DVec3>> = (0..=n)
        .map(|j| (0..=n).map(|i| at(fraction(i), fraction(j))).collect())
        .collect();
    let pane = grid(&rows, Edges::Open, 60.0);
    let (x, angle) = between(0.0, 0.0);
    let faces_out = pane.normals[0].dot(cabin_normal(x, angle)) > 0.0;
    assembly.add(
        materials.window,
        &if faces_out { pane } else { pane.flipped() },
    );

    let mut frame: Vec<DVec3> = Vec::new();
    frame.extend((0..n).map(|i| at(fraction(i), 0.0)));
    frame.extend((0..n).map(|i| at(1.0, fraction(i))));
    frame.extend((0..n).map(|i| at(1.0 - fraction(i), 1.0)));
    frame.extend((0..n).map(|i| at(0.0, 1.0 - fraction(i))));
    frame.push(frame[0]);
    assembly.add(materials.chrome, &tube(&frame, 8, |_| 0.008));
}
