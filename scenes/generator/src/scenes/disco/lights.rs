//! The truss with its spot lights, the mirror ball, and strips of light along the side walls.

use super::floor::BANDS;
use super::{BACK, CENTER, DAIS, DiscoMaterials, HALF_WIDTH, HEIGHT};
use crate::build::{Edges, ball, bevelled_box, grid, torus, tube};
use crate::material::LinearRgb;
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, MeshId, Scene, ShapeKind, SpotLight};
use crate::scenes::{Detail, props};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Radius of the truss.
const TRUSS: f64 = 2.5;
/// Height of the lower ring of the truss.
const TRUSS_HEIGHT: f64 = 3.45;
/// Center of the mirror ball.
const BALL: DVec3 = DVec3::new(CENTER.x, 2.48, CENTER.z);
/// Radius of the mirror ball.
const BALL_RADIUS: f64 = 0.42;

pub(super) fn add(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    truss(scene, materials, detail);
    mirror_ball(scene, materials, detail);
    let housing = housing(scene, materials, detail);
    let mut lamps = Vec::new();
    on_bands(&mut lamps, detail);
    on_ball(&mut lamps);
    on_walls(&mut lamps, detail);
    for (i, lamp) in lamps.iter().enumerate() {
        hang(scene, &housing, i, lamp);
    }
    strips(scene, materials);
}

/// A spot light on the truss.
struct SpotLamp {
    at: DVec3,
    /// Point on the axis of its cone.
    aim: DVec3,
    /// Radiant intensity on the axis.
    intensity: LinearRgb,
    /// Half angle of the cone in degrees.
    cutoff: f64,
}

/// Position of a lamp below the truss, at `degrees` from +x towards +z.
fn on_ring(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(
        CENTER.x + TRUSS * cos,
        TRUSS_HEIGHT - 0.2,
        CENTER.z + TRUSS * sin,
    )
}

fn times(color: LinearRgb, factor: f64) -> LinearRgb {
    color.map(|c| c * factor)
}

/// Lamps of three colors aimed at each band through its open side. Finer scenes have more lamps
/// with the same total intensity.
fn on_bands(lamps: &mut Vec<SpotLamp>, detail: Detail) {
    let each = detail.count(1);
    for band in &BANDS {
        for (i, color) in band.colors.into_iter().enumerate() {
            for k in 0..each {
                let spread = (k as f64 + 0.5) / each as f64 - 0.5;
                let at = on_ring(band.opening + 26.0 * (i as f64 - 1.0 + spread));
                let aim = CENTER + DVec3::new(band.middle.x, DAIS + 0.1, band.middle.y);
                let intensity = times(color, 34.0 / each as f64);
                lamps.push(SpotLamp {
                    at,
                    aim,
                    intensity,
                    cutoff: 13.0,
                });
            }
        }
    }
}

/// Narrow beams aimed at the mirror ball.
fn on_ball(lamps: &mut Vec<SpotLamp>) {
    for (degrees, color) in [
        (20.0, [1.0, 0.5, 0.15]),
        (140.0, [0.25, 0.4, 1.0]),
        (200.0, [1.0, 0.2, 0.55]),
        (320.0, [0.3, 0.9, 0.6]),
    ] {
        let intensity = times(color, 240.0);
        lamps.push(SpotLamp {
            at: on_ring(degrees),
            aim: BALL,
            intensity,
            cutoff: 11.5,
        });
    }
}

/// Wide beams aimed at the back wall and the left wall.
fn on_walls(lamps: &mut Vec<SpotLamp>, detail: Detail) {
    let each = detail.count(1);
    for (degrees, aim, color) in [
        (228.0, DVec3::new(-3.6, 1.2, BACK), [0.5, 0.12, 1.0]),
        (255.0, DVec3::new(-1.6, 1.3, BACK), [0.1, 0.35, 1.0]),
        (285.0, DVec3::new(1.2, 1.3, BACK), [1.0, 0.15, 0.5]),
        (306.0, DVec3::new(3.2, 1.2, BACK), [1.0, 0.42, 0.1]),
        (180.0, DVec3::new(-HALF_WIDTH, 1.4, -0.8), [0.1, 0.6, 0.8]),
        (165.0, DVec3::new(-HALF_WIDTH, 1.4, 1.6), [0.9, 0.2, 0.6]),
    ] {
        for k in 0..each {
            let spread = (k as f64 + 0.5) / each as f64 - 0.5;
            let at = on_ring(degrees + 9.0 * spread);
            let intensity = times(color, 85.0 / each as f64);
            lamps.push(SpotLamp {
                at,
                aim,
                intensity,
                cutoff: 24.0,
            });
        }
    }
}

/// Meshes of the housing of a lamp, which opens at y = 0 towards +y.
fn housing(
    scene: &mut Scene,
    materials: &DiscoMaterials,
    detail: Detail,
) -> Vec<(MaterialId, MeshId)> {
    let mut assembly = Assembly::default();
    let can = [
        (0.0, -0.24),
        (0.055, -0.235),
        (0.075, -0.2),
        (0.075, -0.2),
        (0.075, 0.0),
        (0.075, 0.0),
        (0.068, 0.0),
        (0.068, 0.0),
        (0.066, -0.05),
        (0.066, -0.05),
        (0.0, -0.06),
    ];
    assembly.add(materials.dark, &props::turned(&can, 2, detail.segments(20)));
    scene.add_meshes("spot", assembly)
}

/// Places a spot light and its housing.
fn hang(scene: &mut Scene, housing: &[(MaterialId, MeshId)], i: usize, lamp: &SpotLamp) {
    let d = (lamp.aim - lamp.at).normalize();
    let pose = Pose::at(lamp.at.x, lamp.at.y, lamp.at.z)
        .tilted(d.y.acos().to_degrees())
        .turned(d.x.atan2(d.z).to_degrees());
    for &(material, mesh) in housing {
        scene.place(&format!("can_{i}"), ShapeKind::Mesh(mesh), pose, material);
    }
    scene.spots.push(SpotLight {
        origin: lamp.at + d * 0.004,
        target: lamp.aim,
        intensity: lamp.intensity,
        cutoff: lamp.cutoff,
        beam: lamp.cutoff * 0.7,
    });
}

/// A truss of three rings with bracing, hung from the ceiling.
fn truss(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let round = detail.segments(64);
    for (radius, y) in [
        (TRUSS, TRUSS_HEIGHT),
        (TRUSS, TRUSS_HEIGHT + 0.28),
        (TRUSS + 0.24, TRUSS_HEIGHT + 0.14),
    ] {
        let ring = torus(radius, 0.024, round, detail.segments(8));
        assembly.add(
            materials.satin,
            &ring.placed(Pose::at(CENTER.x, y, CENTER.z)),
        );
    }
    let at = |angle: f64, radius: f64, y: f64| {
        DVec3::new(
            CENTER.x + radius * angle.cos(),
            y,
            CENTER.z + radius * angle.sin(),
        )
    };
    let bays = 36;
    let step = 360.0 / f64::from(bays);
    let about = |degrees: f64, radius: f64, y: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(radius * cos, y, -radius * sin)
    };
    let low = about(0.0, TRUSS, 0.0);
    let outer = about(step / 2.0, TRUSS + 0.24, 0.14);
    let high = about(0.0, TRUSS, 0.28);
    let mut bay = Assembly::default();
    for path in [
        [low, outer],
        [outer, high],
        [outer, about(step, TRUSS, 0.0)],
        [low, high],
    ] {
        bay.add(materials.satin, &tube(&path, detail.segments(6), |_| 0.009));
    }
    let poses: Vec<Pose> = (0..bays)
        .map(|i| Pose::at(CENTER.x, TRUSS_HEIGHT, CENTER.z).turned(step * f64::from(i)))
        .collect();
    scene.place_copies("bay", bay, &poses);
    for i in 0..6 {
        let foot = at(TAU * f64::from(i) / 6.0, TRUSS, TRUSS_HEIGHT + 0.28);
        assembly.add(
            materials.dark,
            &tube(&[foot, foot + DVec3::Y * (HEIGHT - foot.y)], 6, |_| 0.008),
        );
    }
    scene.place_assembly("truss", assembly);
}

/// A ball of flat facets of rough metal, tilted slightly at random.
fn mirror_ball(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut rng = Pcg32::new(70);
    let rows = detail.segments(26);
    let size = PI * BALL_RADIUS / rows as f64;
    let half = size / 2.0 - 0.0012;
    let corners = [(-1.0, 1.0), (1.0, 1.0)].map(|(x, z)| DVec3::new(x * half, 0.0, z * half));
    let facet = grid(
        &[
            corners.to_vec(),
            corners.map(|p| p * DVec3::new(1.0, 1.0, -1.0)).to_vec(),
        ],
        Edges::Open,
        30.0,
    );
    let mut facets = Mesh::default();
    for row in 0..rows {
        let polar = PI * (row as f64 + 0.5) / rows as f64;
        let count = (TAU * BALL_RADIUS * polar.sin() / size).floor().max(3.0) as usize;
        for i in 0..count {
            let azimuth = TAU * (i as f64 + 0.5 * (row % 2) as f64) / count as f64;
            let pose = Pose::identity()
                .tilted(polar.to_degrees() + rng.jitter(0.7))
                .turned(azimuth.to_degrees() + rng.jitter(0.7));
            let out = pose.matrix().transform_vector3(DVec3::Y) * (BALL_RADIUS + 0.003);
            facets.append(&facet.placed(Pose {
                position: BALL + out,
                ..pose
            }));
        }
    }
    scene.place_mesh("ball_facets", facets, materials.facet);
    let mut assembly = Assembly::default();
    assembly.add(
        materials.dark,
        &ball(BALL_RADIUS - 0.004, detail.segments(32)).placed(Pose::at(BALL.x, BALL.y, BALL.z)),
    );
    let chain = [
        BALL + DVec3::Y * (BALL_RADIUS - 0.02),
        DVec3::new(BALL.x, HEIGHT, BALL.z),
    ];
    assembly.add(materials.dark, &tube(&chain, 8, |_| 0.012));
    scene.place_assembly("ball", assembly);
}

/// Upward-facing strips of light behind a ledge on each side wall.
fn strips(scene: &mut Scene, materials: &DiscoMaterials) {
    let mut ledge = Mesh::default();
    for side in [-1.0, 1.0] {
        let x = side * (HALF_WIDTH - 0.1);
        ledge.append(&bevelled_box(
            [x - 0.1, 2.55, BACK],
            [x + 0.1, 2.6, 5.2],
            0.008,
        ));
        ledge.append(&bevelled_box(
            [x - 0.1 * side - 0.012, 2.55, BACK],
            [x - 0.1 * side + 0.012, 2.7, 5.2],
            0.006,
        ));
    }
    scene.place_mesh("ledge", ledge, materials.black);
    for (i, (x, color)) in [
        (-HALF_WIDTH + 0.08, [2.2, 0.5, 3.4]),
        (HALF_WIDTH - 0.08, [3.6, 1.3, 0.5]),
    ]
    .into_iter()
    .enumerate()
    {
        scene.place_emitter(
            &format!("strip_{i}"),
            ShapeKind::Rectangle,
            Pose::at(x, 2.605, 0.1)
                .tilted(-90.0)
                .stretched(0.03, 4.8, 1.0),
            materials.lamp,
            times(color, 5.0),
        );
    }
}
