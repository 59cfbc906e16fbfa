//! The wheels of the car, and a stack of tires.

use super::GarageMaterials;
use super::car::{AXLE, WHEEL};
use crate::build::{bevelled_cylinder, cylinder, lathe, loft};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, MeshId, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Half the width of a tire.
const HALF_WIDTH: f64 = 0.095;

/// Adds the four wheels of the car at the pose `parked`, and the stack.
pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail, parked: Pose) {
    let tire = scene.add_mesh("tire", tire(detail));
    let mut parts = Assembly::default();
    rim(&mut parts, materials, detail);
    let parts = scene.add_meshes("wheel", parts);
    for (i, (x, side)) in [(AXLE, 1.0), (AXLE, -1.0), (-AXLE, 1.0), (-AXLE, -1.0)]
        .into_iter()
        .enumerate()
    {
        let center = parked
            .matrix()
            .transform_point3(DVec3::new(x, WHEEL, side * 0.7));
        let away = if side > 0.0 { 0.0 } else { 180.0 };
        // The axle lies along z of the car, the outer side away from it.
        let pose = Pose {
            turn: parked.turn + away,
            ..Pose::at(center.x, center.y, center.z).tilted(90.0)
        };
        scene.place(
            &format!("tire_{i}"),
            ShapeKind::Mesh(tire),
            pose,
            materials.rubber,
        );
        for (k, &(material, mesh)) in parts.iter().enumerate() {
            scene.place(
                &format!("wheel_{i}_{k}"),
                ShapeKind::Mesh(mesh),
                pose,
                material,
            );
        }
    }
    spares(scene, materials, tire);
}

/// A stack of four tires by the left wall.
fn spares(scene: &mut Scene, materials: &GarageMaterials, tire: MeshId) {
    let stack = |i: usize, dx: f64, dz: f64| {
        Pose::at(
            -4.75 + dx,
            HALF_WIDTH + 2.0 * HALF_WIDTH * i as f64,
            1.15 + dz,
        )
        .turned(40.0 * i as f64)
    };
    for (i, (dx, dz)) in [(0.0, 0.0), (0.03, -0.02), (-0.02, 0.01), (0.025, 0.03)]
        .into_iter()
        .enumerate()
    {
        scene.place(
            &format!("spare_{i}"),
            ShapeKind::Mesh(tire),
            stack(i, dx, dz),
            materials.rubber,
        );
    }
}

/// A tire about the y axis with a grooved tread.
fn tire(detail: Detail) -> Mesh {
    let r = WHEEL;
    let half = [
        (0.205, 0.06),
        (0.205, 0.075),
        (0.225, 0.09),
        (0.265, HALF_WIDTH),
        (0.298, 0.088),
        (r - 0.004, 0.07),
        (r - 0.001, 0.06),
        (r - 0.001, 0.05),
        (r - 0.009, 0.048),
        (r - 0.009, 0.04),
        (r, 0.038),
        (r, 0.006),
        (r - 0.009, 0.004),
    ];
    let mut profile: Vec<_> = half.iter().map(|&(x, y)| (x, -y)).collect();
    profile.extend(half.iter().rev());
    profile.push(profile[0]);
    let points: Vec<_> = profile.into_iter().map(DVec2::from).collect();
    lathe(&points, detail.segments(44))
}

/// A rim about the y axis with its outer side at +y, and the brake disk behind it.
fn rim(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let round = detail.segments(36);
    let well = [
        (0.2, -0.075),
        (0.212, -0.08),
        (0.212, -0.06),
        (0.19, -0.05),
        (0.19, 0.05),
        (0.212, 0.066),
        (0.212, 0.084),
        (0.206, 0.088),
        (0.2, 0.082),
        (0.196, 0.07),
        (0.18, 0.045),
        (0.18, -0.045),
        (0.2, -0.075),
    ];
    assembly.add(materials.rim, &lathe(&well.map(DVec2::from), round));
    let hub = props::turned(
        &[
            (0.0, -0.03),
            (0.055, -0.03),
            (0.055, -0.03),
            (0.055, 0.03),
            (0.045, 0.042),
            (0.03, 0.045),
            (0.03, 0.045),
            (0.028, 0.055),
            (0.0, 0.058),
        ],
        2,
        detail.segments(24),
    );
    assembly.add(materials.rim, &hub);
    spokes(assembly, materials);
    nuts(assembly, materials);
    assembly.add(
        materials.iron,
        &cylinder(0.155, 0.02, round).placed(Pose::at(0.0, -0.03, 0.0)),
    );
    assembly.add(
        materials.dark,
        &cylinder(0.185, 0.02, round).placed(Pose::at(0.0, -0.07, 0.0)),
    );
}

/// Five pairs of spokes.
fn spokes(assembly: &mut Assembly, materials: &GarageMaterials) {
    for i in 0..10 {
        let aside = if i % 2 == 0 { 0.14 } else { -0.14 };
        let angle = TAU * (f64::from(i / 2) + aside) / 5.0;
        let turn = DMat3::from_rotation_y(angle);
        let ring = |r: f64, y: f64, half: f64, thick: f64| {
            [
                (-half, -thick),
                (half, -thick),
                (half * 0.6, thick),
                (-half * 0.6, thick),
            ]
            .map(|(z, dy)| turn * DVec3::new(r, y + dy, z))
            .to_vec()
        };
        let spoke = [
            ring(0.04, 0.022, 0.016, 0.014),
            ring(0.1, 0.036, 0.013, 0.011),
            ring(0.16, 0.038, 0.013, 0.01),
            ring(0.193, 0.03, 0.017, 0.012),
        ];
        assembly.add(materials.rim, &loft(&spoke, 50.0));
    }
}

/// Five wheel nuts.
fn nuts(assembly: &mut Assembly, materials: &GarageMaterials) {
    for i in 0..5 {
        let angle = TAU * (f64::from(i) + 0.5) / 5.0;
        let nut = bevelled_cylinder(0.009, 0.016, 0.002, 6);
        assembly.add(
            materials.chrome,
            &nut.placed(Pose::at(0.04 * angle.cos(), 0.03, 0.04 * angle.sin())),
        );
    }
}
