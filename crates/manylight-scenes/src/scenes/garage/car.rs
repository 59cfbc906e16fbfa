//! The car: a coupe of the sixties, nose towards +x. Its shells are cross-sections lofted along its length.

use super::GarageMaterials;
use crate::build::{
    Edges, ball, bevelled_box, catmull_rom, grid, smooth_table, superellipsoid, tube,
};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::{Detail, props};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// Half the wheelbase, and the wheels' radius.
pub(super) const AXLE: f64 = 1.27;
pub(super) const WHEEL: f64 = 0.315;
/// Radius of the openings around the wheels.
const ARCH: f64 = 0.35;
/// Lower edge of the sides.
const SILL: f64 = 0.19;

/// Half the width at its widest height.
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
/// Height of the bonnet and the boot on the center line.
const SPINE: &[(f64, f64)] = &[
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
/// How square the shoulders are: exponent of the superellipse over the widest height.
const SHOULDER: &[(f64, f64)] = &[
    (-2.1, 3.0),
    (-1.2, 3.6),
    (-0.2, 3.2),
    (0.5, 3.2),
    (1.3, 3.8),
    (2.1, 2.6),
];
/// Lower edge without the wheels' openings.
const KEEL: &[(f64, f64)] = &[
    (-2.17, 0.42),
    (-2.08, 0.33),
    (-1.85, 0.26),
    (-1.6, SILL),
    (1.6, SILL),
    (1.95, 0.23),
    (2.17, 0.34),
];
/// Height of the roof on the center line.
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
/// Half the width of the cabin at its base.
const CABIN: &[(f64, f64)] = &[
    (-1.95, 0.4),
    (-1.5, 0.6),
    (-1.0, 0.72),
    (-0.3, 0.755),
    (0.3, 0.74),
    (0.65, 0.68),
    (0.95, 0.52),
];

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail, parked: Pose) {
    let mut assembly = Assembly::default();
    assembly.add(materials.body, &shell(detail));
    assembly.add(materials.body, &cabin(detail));
    windows(&mut assembly, materials, detail);
    seams(&mut assembly, materials, detail);
    underside(&mut assembly, materials, detail);
    face(&mut assembly, materials, detail);
    tail(&mut assembly, materials, detail);
    flanks(&mut assembly, materials, detail);
    scene.place_assembly("car", assembly.placed(parked));
}

/// Half the outline of the cross-section at `x`, from its lower edge to the center line: (height, half width).
fn section(x: f64) -> Vec<DVec2> {
    const PIECES: usize = 48;
    let (width, spine) = (smooth_table(PLAN, x), smooth_table(SPINE, x));
    let keel = smooth_table(KEEL, x);
    let widest = keel + 0.62 * (spine - keel);
    let power = 2.0 / smooth_table(SHOULDER, x);
    let side = (0..PIECES / 3).map(|i| {
        let t = 1.0 - 3.0 * i as f64 / PIECES as f64;
        DVec2::new(widest - (widest - keel) * t, width * (1.0 - 0.13 * t * t))
    });
    let over = (0..=PIECES).map(|i| {
        let angle = FRAC_PI_2 * i as f64 / PIECES as f64;
        let (sin, cos) = angle.sin_cos();
        let inwards = if i == PIECES { 0.0 } else { cos.powf(power) };
        DVec2::new(widest + (spine - widest) * sin.powf(power), width * inwards)
    });
    side.chain(over).collect()
}

/// Lower edge of the side at `x`: the keel, or the edge of an opening for a wheel.
fn lower_edge(x: f64) -> f64 {
    let keel = smooth_table(KEEL, x);
    let from_axle = (x.abs() - AXLE).abs();
    if from_axle >= ARCH {
        return keel;
    }
    keel.max(WHEEL + (ARCH * ARCH - from_axle * from_axle).sqrt())
}

/// The part of the outline above `low`, as `count` + 1 points at equal distances.
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

/// From one lower edge over the top to the other.
fn across(half: &[DVec2], x: f64) -> Vec<DVec3> {
    let point = |p: &DVec2, side: f64| DVec3::new(x, p.x, side * p.y);
    let far = half.iter().map(|p| point(p, 1.0));
    let near = half.iter().rev().skip(1).map(|p| point(p, -1.0));
    far.chain(near).collect()
}

/// Stations along the car: even ones, more where the ends are round, and those on which the openings' edges lie.
fn stations(detail: Detail) -> Vec<f64> {
    let even = detail.segments(44);
    let mut stations: Vec<f64> = (0..=even)
        .map(|i| {
            let t = 2.0 * i as f64 / even as f64 - 1.0;
            2.17 * (0.6 * t + 0.4 * (FRAC_PI_2 * t).sin())
        })
        .filter(|x| (x.abs() - AXLE).abs() > ARCH + 0.02)
        .collect();
    let on_arch = detail.segments(20);
    for axle in [-AXLE, AXLE] {
        stations.extend((0..=on_arch).map(|i| {
            let angle = std::f64::consts::PI * i as f64 / on_arch as f64;
            // The last ones just inside, so that the edge rises upright from the sill.
            axle - (ARCH - 0.0005) * angle.cos()
        }));
        stations.extend([axle - ARCH - 0.0005, axle + ARCH + 0.0005]);
    }
    stations.sort_by(f64::total_cmp);
    stations
}

/// The lower body, closed at nose and tail.
fn shell(detail: Detail) -> Mesh {
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

/// Rings that close the last cross-section in a shallow dome which stands out by `bulge`.
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

/// A point of the cabin: `x` along the car, `angle` from 0 at its base on the +z side over 90 degrees on the center line.
fn cabin_point(x: f64, angle: f64) -> DVec3 {
    let (width, roof) = (smooth_table(CABIN, x), smooth_table(ROOF, x));
    let base = smooth_table(SPINE, x) - 0.1;
    let (sin, cos) = angle.to_radians().sin_cos();
    let power = 2.0 / 2.7;
    let across = cos.abs().powf(power) * cos.signum();
    let up = sin.abs().powf(power);
    // Sides lean in towards the roof.
    let height = base + (roof - base).max(0.01) * up;
    DVec3::new(x, height, width * across * (1.0 - 0.14 * up))
}

fn cabin(detail: Detail) -> Mesh {
    let (along, around) = (detail.segments(40), detail.segments(36));
    let rows: Vec<Vec<DVec3>> = (0..=along)
        .map(|i| {
            let x = -1.95 + 2.9 * i as f64 / along as f64;
            (0..=around)
                .map(|k| cabin_point(x, 180.0 * k as f64 / around as f64))
                .collect()
        })
        .collect();
    grid(&rows, Edges::Open, 50.0).flipped()
}

/// Dark panes a few millimeters proud of the cabin, each in a frame of chrome.
fn windows(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    // Corners as (x, angle), counterclockwise seen from outside at +z.
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

/// Direction away from the cabin at one of its points.
fn cabin_normal(x: f64, angle: f64) -> DVec3 {
    let along = cabin_point(x + 1e-3, angle) - cabin_point(x - 1e-3, angle);
    let around = cabin_point(x, angle + 0.1) - cabin_point(x, angle - 0.1);
    along.cross(around).normalize()
}

/// A pane between four corners, given as (x, angle).
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
    let share = |i: usize| i as f64 / n as f64;
    let rows: Vec<Vec<DVec3>> = (0..=n)
        .map(|j| (0..=n).map(|i| at(share(i), share(j))).collect())
        .collect();
    let pane = grid(&rows, Edges::Open, 60.0);
    let (x, angle) = between(0.0, 0.0);
    let faces_out = pane.normals[0].dot(cabin_normal(x, angle)) > 0.0;
    assembly.add(
        materials.window,
        &if faces_out { pane } else { pane.flipped() },
    );

    let mut frame: Vec<DVec3> = Vec::new();
    frame.extend((0..n).map(|i| at(share(i), 0.0)));
    frame.extend((0..n).map(|i| at(1.0, share(i))));
    frame.extend((0..n).map(|i| at(1.0 - share(i), 1.0)));
    frame.extend((0..n).map(|i| at(0.0, 1.0 - share(i))));
    frame.push(frame[0]);
    assembly.add(materials.chrome, &tube(&frame, 8, |_| 0.008));
}

/// A point of the body's surface at a height on the +z side, or on top where `height` is above.
fn on_side(x: f64, height: f64) -> DVec3 {
    let outline = section(x);
    let p = resampled(&outline, height, 1)[0];
    DVec3::new(x, p.x, p.y)
}

/// A point of the body's top at half the width `z`.
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

/// Dark joints of doors, bonnet and boot, half sunk into the surface.
fn seams(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let n = detail.segments(12);
    let line = |from: (f64, f64), to: (f64, f64), f: fn(f64, f64) -> DVec3| -> Vec<DVec3> {
        (0..=n)
            .map(|i| {
                let t = i as f64 / n as f64;
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

/// What closes the car from below, and the dark behind the wheels.
fn underside(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    assembly.add(
        materials.dark,
        &bevelled_box([-1.95, 0.2, -0.6], [1.95, 0.4, 0.6], 0.05),
    );
    assembly.add(
        materials.dark,
        &bevelled_box([-0.9, 0.18, -0.7], [0.9, 0.3, 0.7], 0.02),
    );
    let well = crate::build::cylinder(ARCH + 0.03, 1.22, detail.segments(24));
    for axle in [-AXLE, AXLE] {
        assembly.add(
            materials.dark,
            &well.placed(Pose::at(axle, WHEEL, -0.61).tilted(90.0)),
        );
    }
    // A chrome lip around each opening.
    let pieces = detail.segments(24);
    for axle in [-AXLE, AXLE] {
        for side in [-1.0, 1.0] {
            let lip: Vec<DVec3> = (0..=pieces)
                .map(|i| {
                    let angle = std::f64::consts::PI * i as f64 / pieces as f64;
                    let x = axle - (ARCH - 0.0006) * angle.cos();
                    let p = on_side(x, lower_edge(x));
                    DVec3::new(p.x, p.y, side * p.z)
                })
                .collect();
            assembly.add(materials.chrome, &tube(&lip, 8, |_| 0.007));
        }
    }
}

/// Grille, lamps, bumper.
fn face(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let round = detail.segments(28);
    let mouth = superellipsoid([0.05, 0.075, 0.34], 0.8, 0.6, round);
    assembly.add(materials.dark, &mouth.placed(Pose::at(2.185, 0.43, 0.0)));
    let rim: Vec<DVec3> = (0..=round)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * (i % round) as f64 / round as f64).sin_cos();
            let power = |v: f64| v.abs().powf(0.7) * v.signum();
            DVec3::new(2.215, 0.43 + 0.075 * power(sin), 0.34 * power(cos))
        })
        .collect();
    assembly.add(materials.chrome, &tube(&rim, 8, |_| 0.011));
    for i in -6..=6 {
        let z = 0.048 * f64::from(i);
        let half = 0.07 * (1.0 - (z / 0.35).powi(4)).max(0.0).sqrt();
        assembly.add(
            materials.chrome,
            &bevelled_box(
                [2.2, 0.43 - half, z - 0.003],
                [2.245, 0.43 + half, z + 0.003],
                0.001,
            ),
        );
    }
    for side in [-1.0, 1.0] {
        let bowl = props::turned(
            &[
                (0.0, -0.1),
                (0.09, -0.09),
                (0.098, 0.0),
                (0.104, 0.012),
                (0.098, 0.02),
                (0.092, 0.012),
                (0.0, 0.012),
            ],
            2,
            round,
        );
        let pose = Pose::at(1.93, 0.605, side * 0.6)
            .rolled(-76.0)
            .turned(-7.0 * side);
        assembly.add(materials.chrome, &bowl.placed(pose));
        let lens =
            superellipsoid([0.092, 0.03, 0.092], 1.0, 1.0, round).placed(Pose::at(0.0, 0.012, 0.0));
        assembly.add(materials.lens, &lens.placed(pose));
        let signal = superellipsoid([0.03, 0.028, 0.055], 1.0, 1.0, detail.segments(16));
        assembly.add(
            materials.orange,
            &signal.placed(Pose::at(2.105, 0.45, side * 0.5)),
        );
    }
    let bumper: Vec<DVec3> = [
        (1.75, 0.86),
        (1.98, 0.77),
        (2.13, 0.62),
        (2.215, 0.35),
        (2.235, 0.0),
        (2.215, -0.35),
        (2.13, -0.62),
        (1.98, -0.77),
        (1.75, -0.86),
    ]
    .map(|(x, z)| DVec3::new(x, 0.335, z))
    .to_vec();
    assembly.add(
        materials.chrome,
        &tube(&catmull_rom(&bumper, 5), detail.segments(12), |_| 0.026),
    );
}

/// Lamps, bumper, plate, pipes.
fn tail(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for side in [-1.0, 1.0] {
        for i in 0..2 {
            let z = side * (0.36 + 0.15 * f64::from(i));
            let lamp = superellipsoid([0.03, 0.055, 0.06], 1.0, 1.0, detail.segments(20));
            assembly.add(
                materials.tail_light,
                &lamp.placed(Pose::at(-2.165, 0.64, z)),
            );
        }
        let pipe = [
            DVec3::new(-1.9, 0.24, side * 0.42),
            DVec3::new(-2.2, 0.24, side * 0.42),
        ];
        assembly.add(
            materials.chrome,
            &tube(&pipe, detail.segments(14), |_| 0.032),
        );
    }
    let bumper: Vec<DVec3> = [
        (-1.75, 0.87),
        (-2.0, 0.8),
        (-2.15, 0.66),
        (-2.22, 0.35),
        (-2.235, 0.0),
        (-2.22, -0.35),
        (-2.15, -0.66),
        (-2.0, -0.8),
        (-1.75, -0.87),
    ]
    .map(|(x, z)| DVec3::new(x, 0.42, z))
    .to_vec();
    assembly.add(
        materials.chrome,
        &tube(&catmull_rom(&bumper, 5), detail.segments(12), |_| 0.026),
    );
}

/// Door handles, mirrors, a chrome strip along the sill.
fn flanks(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for side in [-1.0, 1.0] {
        let mirror_side = |p: DVec3| p * DVec3::new(1.0, 1.0, side);
        let grip: Vec<DVec3> = [(-0.34, 0.0), (-0.32, 0.028), (-0.2, 0.03), (-0.18, 0.0)]
            .map(|(x, out)| mirror_side(on_side(x, 0.7) + DVec3::Z * out))
            .to_vec();
        assembly.add(
            materials.chrome,
            &tube(&grip, detail.segments(10), |_| 0.008),
        );
        let sill: Vec<DVec3> = (0..=10)
            .map(|i| mirror_side(on_side(-0.86 + 1.72 * f64::from(i) / 10.0, 0.225)))
            .collect();
        assembly.add(
            materials.chrome,
            &tube(&sill, detail.segments(8), |_| 0.011),
        );
        let foot = mirror_side(on_side(0.55, 0.8) + DVec3::Z * -0.03);
        let head = foot + DVec3::new(-0.02, 0.1, 0.07 * side);
        assembly.add(
            materials.chrome,
            &tube(&[foot, head], detail.segments(10), |_| 0.009),
        );
        let shell = superellipsoid([0.05, 0.045, 0.065], 0.8, 0.9, detail.segments(20));
        assembly.add(
            materials.chrome,
            &shell.placed(Pose::at(head.x, head.y + 0.02, head.z)),
        );
    }
    // Badge on the bonnet, filler cap behind the roof.
    assembly.add(
        materials.chrome,
        &ball(0.03, detail.segments(12))
            .placed(Pose::at(2.02, 0.612, 0.0).stretched(1.0, 0.3, 1.0)),
    );
}
