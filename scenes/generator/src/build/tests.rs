use super::*;
use crate::mesh::Mesh;
use crate::pose::Pose;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Asserts that a mesh is closed, faces outwards and has unit shading normals on the outer side of
/// its faces.
#[track_caller]
fn assert_solid(mesh: &Mesh) {
    assert!(mesh.is_closed(), "open edges");
    assert!(mesh.volume() > 0.0, "inside out: {}", mesh.volume());
    assert_eq!(mesh.positions.len(), mesh.normals.len());
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        let face = (b - a).cross(c - a).normalize();
        for &i in t {
            let normal = mesh.normals[i as usize];
            assert!((normal.length() - 1.0).abs() < 1e-9);
            assert!(normal.dot(face) > 0.2, "normal {normal} of face {face}");
        }
    }
}

#[track_caller]
fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value / expected - 1.0).abs() < tolerance,
        "{value} is not {expected}"
    );
}

#[test]
fn boxes() {
    let sharp = boxed([1.0, 2.0, 3.0], [3.0, 3.0, 6.0]);
    assert_solid(&sharp);
    assert!(sharp.is_flat());
    assert_near(sharp.volume(), 6.0, 1e-12);
    assert_near(sharp.area(), 22.0, 1e-12);

    let round = bevelled_box([1.0, 2.0, 3.0], [3.0, 3.0, 6.0], 0.01);
    assert_solid(&round);
    assert!(!round.is_flat());
    assert_eq!(round.triangles.len(), 44);
    assert_near(round.volume(), 6.0, 1e-3);
    assert_near(round.area(), 22.0, 1e-2);
}

#[test]
fn superellipsoids() {
    let sphere = superellipsoid([2.0; 3], 1.0, 1.0, 64);
    assert_solid(&sphere);
    assert_near(sphere.area(), 16.0 * PI, 0.01);
    assert_solid(&superellipsoid([0.3, 0.1, 0.2], 0.4, 0.5, 32));
}

#[test]
fn turned_bodies() {
    let can = cylinder(0.5, 2.0, 128);
    assert_solid(&can);
    assert_near(can.area(), PI * 2.5, 1e-3);
    assert_near(can.volume(), PI * 0.5, 1e-3);
    assert_solid(&bevelled_cylinder(0.5, 2.0, 0.02, 24));

    let sphere = ball(1.0, 64);
    assert_solid(&sphere);
    assert_near(sphere.volume(), 4.0 / 3.0 * PI, 0.01);

    let ring = torus(2.0, 0.5, 96, 32);
    assert_solid(&ring);
    assert_near(ring.area(), 4.0 * PI * PI, 0.01);

    let bowl = [(0.0, 0.0), (0.5, 0.2), (0.45, 0.2), (0.0, 0.05)].map(DVec2::from);
    assert_solid(&lathe(&bowl, 16));
}

#[test]
fn tubes() {
    let path = catmull_rom(
        &[
            DVec3::ZERO,
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(2.0, 0.0, 1.0),
        ],
        16,
    );
    assert_solid(&tube(&path, 12, |_| 0.05));
    assert_solid(&tube(&path, 8, |t| 0.1 - 0.05 * t));

    let straight = tube(&[DVec3::ZERO, DVec3::Y * 2.0], 64, |_| 0.5);
    assert_near(straight.area(), PI * 2.5, 1e-2);

    let around: Vec<DVec3> = (0..=32)
        .map(|i| DVec3::new(2.0, 0.0, 0.0).rotate_y(i as f64 / 16.0 * PI))
        .collect();
    assert_solid(&tube(&around, 16, |_| 0.3));
}

#[test]
fn profiles() {
    let l_shape = [
        (0.0, 0.0),
        (2.0, 0.0),
        (2.0, 1.0),
        (1.0, 1.0),
        (1.0, 3.0),
        (0.0, 3.0),
    ];
    let angle = extrude(&l_shape.map(DVec2::from), 0.5, 30.0);
    assert_solid(&angle);
    assert_near(angle.volume(), 2.0, 1e-12);
    assert_near(angle.area(), 8.0 + 5.0, 1e-12);

    let square = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.2), (0.0, 0.2)].map(DVec2::from);
    let corner = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, 1.0)];
    let open = moulding(&square, &corner, 30.0);
    assert_solid(&open);
    // A profile on the inner side of a right turn is shorter: the mitre removes half a square from
    // each leg.
    assert_near(open.volume(), 0.02 * (2.0 - 0.1), 1e-9);

    let room = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::Z,
        DVec3::ZERO,
    ];
    assert_solid(&moulding(&square, &room, 30.0));
}

#[test]
fn lofts() {
    let rings: Vec<Vec<DVec3>> = (0..5)
        .map(|i| {
            arc(DVec2::ZERO, 1.0 + 0.1 * f64::from(i), 0.0, 337.5, 15)
                .into_iter()
                .map(|p| p.extend(f64::from(i)))
                .collect()
        })
        .collect();
    assert_solid(&loft(&rings, 30.0));
}

#[test]
fn a_sheet_is_open() {
    let rows = [
        vec![DVec3::ZERO, DVec3::X],
        vec![DVec3::Y, DVec3::X + DVec3::Y],
    ];
    let sheet = grid(&rows, Edges::Open, 30.0);
    assert!(!sheet.is_closed());
    assert_near(sheet.area(), 1.0, 1e-12);
    assert!(sheet.normals.iter().all(|n| n.distance(DVec3::Z) < 1e-12));
}

#[test]
fn tables() {
    let table = [(0.0, 1.0), (1.0, 2.0), (3.0, 2.0)];
    assert_eq!(smooth_table(&table, -1.0), 1.0);
    let between = smooth_table(&table, 0.5);
    assert!(between > 1.3 && between < 1.7);
    assert_eq!(smooth_table(&table, 9.0), 2.0);
    assert_eq!(smooth_table(&table, 1.0), 2.0);
    // Constant between equal entries: no overshoot.
    assert_eq!(smooth_table(&table, 2.0), 2.0);
}

#[test]
fn poses_and_mirrors_keep_solids_solid() {
    let vase = lathe(
        &[(0.0, 0.0), (0.2, 0.1), (0.1, 0.4), (0.0, 0.4)].map(DVec2::from),
        12,
    );
    let stretched = vase.placed(
        Pose::at(1.0, 2.0, 3.0)
            .turned(30.0)
            .stretched(1.0, 2.0, 0.5),
    );
    assert_solid(&stretched);
    assert_near(stretched.volume(), vase.volume(), 1e-9);
    assert_solid(&vase.placed(Pose::identity().stretched(-1.0, 1.0, 1.0)));
    assert!(vase.flipped().volume() < 0.0);
}
