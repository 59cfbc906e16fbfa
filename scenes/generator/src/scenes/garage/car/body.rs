//! The lower body of the car: its shell, seams and underside.

use super::{AXLE, GarageMaterials, WHEEL};
use crate::build::{Edges, bevelled_box, cylinder, grid, smooth_table, tube};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::Assembly;
use crate::scenes::Detail;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Half the length of the body.
const HALF_LENGTH: f64 = 2.17;
/// Radius of the wheel arches.
const ARCH: f64 = 0.35;
/// Height of the lower edge of the sides between the wheels.
const SILL: f64 = 0.19;

/// Half the width of the body at its widest height, by x.
const PLAN: &[(f64, f64)] = &[
    (-2.17, 0.56),
    (-2.1, 0.68),
    (-1.9, 0.78),
    (-1.6, 0.835),
    (-1.2, 0.865),
    (-0.8, 0.855),
    (-0.2, 0.825),
    (0.4, 0.825),
    (0.9, 0.845),
    (1.3, 0.855),
    (1.65, 0.82),
    (1.95, 0.72),
    (2.1, 0.6),
    (2.17, 0.48),
];

/// Height of the bonnet and the boot on the center line, by x.
pub(super) const SPINE: &[(f64, f64)] = &[
    (-2.17, 0.74),
    (-2.1, 0.8),
    (-1.9, 0.855),
    (-1.5, 0.9),
    (-0.5, 0.9),
    (0.5, 0.875),
    (1.0, 0.835),
    (1.5, 0.76),
    (1.85, 0.675),
    (2.05, 0.6),
    (2.14, 0.54),
    (2.17, 0.48),
];

/// Exponent of the superellipse above the widest height, by x. Larger values give squarer
/// shoulders.
const SHOULDER: &[(f64, f64)] = &[
    (-2.1, 3.0),
    (-1.2, 3.6),
    (-0.2, 3.2),
    (0.5, 3.2),
    (1.3, 3.8),
    (2.1, 2.6),
];

/// Height of the lower edge without the wheel arches, by x.
const KEEL: &[(f64, f64)] = &[
    (-2.17, 0.42),
    (-2.08, 0.33),
    (-1.85, 0.26),
    (-1.6, SILL),
    (1.6, SILL),
    (1.95, 0.23),
    (2.17, 0.34),
];

/// The lower body, closed at nose and tail.
pub(super) fn shell(detail: Detail) -> Mesh {
    let count = detail.segments(22);
    let rows: Vec<Vec<DVec3>> = stations(detail)
        .iter()
        .map(|&x| across(&resampled(&section(x), lower_edge(x), count), x))
        .collect();
    let mut tail = rounded_end(&rows[0], -0.035);
    tail.reverse();
    let nose = rounded_end(&rows[rows.len() - 1], 0.04);
    grid(&[tail, rows, nose].concat(), Edges::Open, 40.0).flipped()
}

/// x of the cross-sections: evenly spaced, denser at nose and tail, and along the edges of the
/// wheel arches.
fn stations(detail: Detail) -> Vec<f64> {
    let even = detail.segments(44);
    let mut stations: Vec<f64> = (0..=even)
        .map(|i| {
            let t = 2.0 * i as f64 / even as f64 - 1.0;
            HALF_LENGTH * (0.6 * t + 0.4 * (FRAC_PI_2 * t).sin())
        })
        .filter(|x| (x.abs() - AXLE).abs() > ARCH + 0.02)
        .collect();
    let on_arch = detail.segments(20);
    for axle in [-AXLE, AXLE] {
        stations.extend((0..=on_arch).map(|i| {
            let angle = PI * i as f64 / on_arch as f64;
            // Just inside the arch; with the stations just outside it, the edge rises almost
            // upright from the sill.
            axle - (ARCH - 0.0005) * angle.cos()
        }));
        stations.extend([axle - ARCH - 0.0005, axle + ARCH + 0.0005]);
    }
    stations.sort_by(f64::total_cmp);
    stations
}

/// One side of the cross-section at `x`, from the lower edge to the center line, as (height, half
/// width).
fn section(x: f64) -> Vec<DVec2> {
    /// Segments of the part above the widest height.
    const SEGMENTS: usize = 48;
    let (width, spine) = (smooth_table(PLAN, x), smooth_table(SPINE, x));
    let keel = smooth_table(KEEL, x);
    let widest = keel + 0.62 * (spine - keel);
    let power = 2.0 / smooth_table(SHOULDER, x);
    let side = (0..SEGMENTS / 3).map(|i| {
        let t = 1.0 - 3.0 * i as f64 / SEGMENTS as f64;
        DVec2::new(widest - (widest - keel) * t, width * (1.0 - 0.13 * t * t))
    });
    let over = (0..=SEGMENTS).map(|i| {
        let angle = FRAC_PI_2 * i as f64 / SEGMENTS as f64;
        let (sin, cos) = angle.sin_cos();
        let inwards = if i == SEGMENTS { 0.0 } else { cos.powf(power) };
        DVec2::new(widest + (spine - widest) * sin.powf(power), width * inwards)
    });
    side.chain(over).collect()
}

/// Height of the lower edge at `x`, with the wheel arches.
fn lower_edge(x: f64) -> f64 {
    let keel = smooth_table(KEEL, x);
    let from_axle = (x.abs() - AXLE).abs();
    if from_axle >= ARCH {
        return keel;
    }
    keel.max(WHEEL + (ARCH * ARCH - from_axle * from_axle).sqrt())
}

/// The part of an outline above height `low`, as `count` + 1 points at equal distances.
fn resampled(outline: &[DVec2], low: f64, count: usize) -> Vec<DVec2> {
    let first = outline
        .partition_point(|p| p.x < low)
        .clamp(1, outline.len() - 1);
    let (under, above) = (outline[first - 1], outline[first]);
    let t = ((low - under.x) / (above.x - under.x)).clamp(0.0, 1.0);
    let start = under.lerp(above, t);
    let mut kept = vec![start];
    kept.extend(outline[first..].iter().filter(|p| p.distance(start) > 1e-6));
    let mut passed = vec![0.0];
    for pair in kept.windows(2) {
        passed.push(passed[passed.len() - 1] + pair[0].distance(pair[1]));
    }
    let total = passed[passed.len() - 1];
    (0..=count)
        .map(|i| {
            let wanted = total * i as f64 / count as f64;
            let after = passed
                .partition_point(|&d| d < wanted)
                .clamp(1, kept.len() - 1);
            let (a, b) = (passed[after - 1], passed[after]);
            kept[after - 1].lerp(kept[after], ((wanted - a) / (b - a)).clamp(0.0, 1.0))
        })
        .collect()
}

/// A whole cross-section from one lower edge over the top to the other, from one side.
fn across(half: &[DVec2], x: f64) -> Vec<DVec3> {
    let point = |p: &DVec2, side: f64| DVec3::new(x, p.x, side * p.y);
    let far = half.iter().map(|p| point(p, 1.0));
    let near = half.iter().rev().skip(1).map(|p| point(p, -1.0));
    far.chain(near).collect()
}

/// Cross-sections that close the end of the body with a shallow dome of height `bulge` along x.
fn rounded_end(last: &[DVec3], bulge: f64) -> Vec<Vec<DVec3>> {
    let (low, high) = (last[0].y, last[last.len() / 2].y);
    let middle = DVec3::new(last[0].x, (low + high) / 2.0, 0.0);
    [0.35, 0.7, 0.97]
        .map(|t: f64| {
            let out = DVec3::X * (bulge * (1.0 - (1.0 - t) * (1.0 - t)));
            last.iter().map(|p| p.lerp(middle, t) + out).collect()
        })
        .to_vec()
}

/// The point of the body at `x` and `height` on the +z side.
pub(super) fn on_side(x: f64, height: f64) -> DVec3 {
    let outline = section(x);
    let p = resampled(&outline, height, 1)[0];
    DVec3::new(x, p.x, p.y)
}

/// The point on top of the body at `x` and `z`.
fn on_top(x: f64, z: f64) -> DVec3 {
    let outline = section(x);
    let first = outline.iter().rposition(|p| p.y >= z.abs()).unwrap_or(0);
    let (a, b) = (outline[first], outline[(first + 1).min(outline.len() - 1)]);
    let t = if a.y > b.y {
        (a.y - z.abs()) / (a.y - b.y)
    } else {
        0.0
    };
    let p = a.lerp(b, t);
    DVec3::new(x, p.x, z)
}

/// Dark seams of the doors, the bonnet and the boot, half sunk into the surface.
pub(super) fn seams(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let segments = detail.segments(12);
    let line = |from: (f64, f64), to: (f64, f64), f: fn(f64, f64) -> DVec3| -> Vec<DVec3> {
        (0..=segments)
            .map(|i| {
                let t = i as f64 / segments as f64;
                f(from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t)
            })
            .collect()
    };
    let mut add = |path: &[DVec3]| {
        for side in [1.0, -1.0] {
            let mirrored: Vec<DVec3> = path
                .iter()
                .map(|p| *p * DVec3::new(1.0, 1.0, side))
                .collect();
            assembly.add(materials.dark, &tube(&mirrored, 6, |_| 0.0035));
        }
    };
    add(&line((0.6, 0.8), (0.64, 0.26), on_side));
    add(&line((-0.44, 0.8), (-0.38, 0.26), on_side));
    add(&line((0.64, 0.26), (-0.38, 0.26), on_side));
    add(&line((0.98, 0.58), (1.88, 0.4), on_top));
    add(&line((1.88, 0.4), (1.9, 0.0), on_top));
    add(&line((-1.98, 0.5), (-1.55, 0.62), on_top));
}

/// The dark floor of the car and the wheel wells.
pub(super) fn underside(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    assembly.add(
        materials.dark,
        &bevelled_box([-1.95, 0.2, -0.6], [1.95, 0.4, 0.6], 0.05),
    );
    assembly.add(
        materials.dark,
        &bevelled_box([-0.9, 0.18, -0.7], [0.9, 0.3, 0.7], 0.02),
    );
    let well = cylinder(ARCH + 0.03, 1.22, detail.segments(24));
    for axle in [-AXLE, AXLE] {
        assembly.add(
            materials.dark,
            &well.placed(Pose::at(axle, WHEEL, -0.61).tilted(90.0)),
        );
    }
    wheel_arch_trim(assembly, materials, detail);
}

/// A chrome trim around each wheel arch.
fn wheel_arch_trim(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let segments = detail.segments(24);
    for axle in [-AXLE, AXLE] {
        for side in [-1.0, 1.0] {
            let lip: Vec<DVec3> = (0..=segments)
                .map(|i| {
                    let angle = PI * i as f64 / segments as f64;
                    let x = axle - (ARCH - 0.0006) * angle.cos();
                    let p = on_side(x, lower_edge(x));
                    DVec3::new(p.x, p.y, side * p.z)
                })
                .collect();
            assembly.add(materials.chrome, &tube(&lip, 8, |_| 0.007));
        }
    }
}
