//! Objects of more than one scene. Each stands on the plane y = 0 about the y axis.

use super::Detail;
use crate::build::{Edges, bevelled_box, grid, lathe};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use glam::{DVec2, DVec3};

/// Fractional part of the golden ratio. Successive leaves are turned by this fraction of a full
/// turn.
const GOLDEN_FRACTION: f64 = 0.618_034;

/// A surface of revolution of a [smoothed] profile of (radius, height), with `steps` segments
/// between its points.
pub(super) fn turned(profile: &[(f64, f64)], steps: usize, segments: usize) -> Mesh {
    lathe(&smoothed(profile, steps), segments)
}

/// A smooth curve through the points of a profile, with a corner wherever a point occurs twice in a
/// row.
pub(super) fn smoothed(profile: &[(f64, f64)], steps: usize) -> Vec<DVec2> {
    let mut curve: Vec<DVec2> = Vec::new();
    for run in runs(profile) {
        if run.len() == 2 {
            curve.extend(run.iter().copied().map(DVec2::from));
            continue;
        }
        let points: Vec<DVec3> = run.iter().map(|&(r, y)| DVec3::new(r, y, 0.0)).collect();
        let smooth = crate::build::catmull_rom(&points, steps);
        // The spline must not overshoot the axis.
        curve.extend(smooth.iter().map(|p| DVec2::new(p.x.max(0.0), p.y)));
    }
    curve.dedup_by(|a, b| a.distance(*b) < 1e-9);
    curve
}

/// The parts of a profile between repeated points, with both ends.
fn runs(profile: &[(f64, f64)]) -> Vec<&[(f64, f64)]> {
    let mut runs = Vec::new();
    let mut start = 0;
    for i in 1..profile.len() {
        if profile[i] == profile[i - 1] {
            if i - start >= 2 {
                runs.push(&profile[start..i]);
            }
            start = i;
        }
    }
    runs.push(&profile[start..]);
    runs
}

/// A pot with a wall, open at the top: radius 0.17, height 0.36, inner floor at height 0.3.
pub(super) fn pot(detail: Detail) -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.11, 0.0),
        (0.11, 0.0),
        (0.15, 0.08),
        (0.17, 0.2),
        (0.155, 0.32),
        (0.15, 0.36),
        (0.15, 0.36),
        (0.138, 0.36),
        (0.138, 0.36),
        (0.142, 0.31),
        (0.142, 0.31),
        (0.0, 0.3),
    ];
    turned(&profile, 4, detail.segments(28))
}

/// A tuft of strap leaves from the origin. With `spread` 0 all leaves stand; with 1 the outer ones
/// arch to the ground.
pub(super) fn strap_plant(leaves: usize, height: f64, spread: f64, rng: &mut Pcg32) -> Mesh {
    let mut plant = Mesh::default();
    for i in 0..leaves {
        let turn = 360.0 * (i as f64 * GOLDEN_FRACTION) + rng.jitter(12.0);
        let outer = i as f64 / leaves as f64;
        let length = height * rng.range(0.8, 1.1);
        let leaf = strap_leaf(length, spread * (0.2 + 0.8 * outer) + rng.jitter(0.08));
        plant.append(&leaf.placed(Pose::identity().turned(turn)));
    }
    plant
}

/// A leaf that rises along y, bends towards x by `bend` and is folded along its middle.
fn strap_leaf(length: f64, bend: f64) -> Mesh {
    const ROWS: usize = 10;
    let width = 0.055 * length;
    let mut along = DVec3::new(0.012, 0.0, 0.0);
    let mut angle: f64 = 0.1;
    let step = length / ROWS as f64;
    let rows: Vec<Vec<DVec3>> = (0..=ROWS)
        .map(|i| {
            let t = i as f64 / ROWS as f64;
            let half = width * (0.45 + 1.9 * t) * (1.0 - t * t).max(0.0).sqrt() * 0.9;
            let up = DVec3::new(-angle.cos(), angle.sin(), 0.0);
            let fold = up * (0.35 * half);
            let row = vec![
                along + fold + DVec3::Z * half,
                along,
                along + fold - DVec3::Z * half,
            ];
            along += DVec3::new(angle.sin(), angle.cos(), 0.0) * step;
            angle += bend * 2.2 * step / length * (0.5 + t);
            row
        })
        .collect();
    grid(&rows, Edges::Open, 80.0)
}

/// A vase: radius 0.09, height 0.32.
pub(super) fn vase(detail: Detail) -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.045, 0.0),
        (0.045, 0.0),
        (0.075, 0.06),
        (0.09, 0.13),
        (0.07, 0.21),
        (0.032, 0.265),
        (0.03, 0.29),
        (0.042, 0.32),
        (0.042, 0.32),
        (0.037, 0.32),
        (0.037, 0.32),
        (0.025, 0.29),
        (0.026, 0.26),
        (0.026, 0.26),
        (0.0, 0.24),
    ];
    turned(&profile, 4, detail.segments(28))
}

/// A wide bowl: radius 0.15, height 0.09.
pub(super) fn bowl(detail: Detail) -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.05, 0.0),
        (0.05, 0.0),
        (0.055, 0.012),
        (0.11, 0.04),
        (0.15, 0.09),
        (0.15, 0.09),
        (0.145, 0.09),
        (0.145, 0.09),
        (0.105, 0.048),
        (0.05, 0.02),
        (0.0, 0.015),
    ];
    turned(&profile, 4, detail.segments(32))
}

/// Books of random size and angle, stacked from y = 0.
pub(super) fn lying_books(count: usize, rng: &mut Pcg32) -> Vec<Mesh> {
    let mut height = 0.0;
    (0..count)
        .map(|_| {
            let thick = rng.range(0.02, 0.04);
            let (x, z) = (rng.range(0.095, 0.13), rng.range(0.075, 0.095));
            let book = bevelled_box([-x, 0.0, -z], [x, thick, z], 0.003);
            let pose = Pose::at(0.0, height, 0.0).turned(rng.jitter(9.0));
            height += thick;
            book.placed(pose)
        })
        .collect()
}
