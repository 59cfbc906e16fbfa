//! The dance floor and the curved bands of metal on it.

use super::{CENTER, DAIS, DiscoMaterials, RADIUS};
use crate::build::{arc, bevelled_cylinder, extrude, moulding, torus};
use crate::material::LinearRgb;
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene};
use crate::scenes::Detail;
use glam::{DVec2, DVec3};

/// A curved band of metal that stands on the dance floor and throws a caustic on it. Its open side
/// faces three lamps.
pub(super) struct Band {
    /// Center (x, z) of its arc, relative to the center of the floor.
    pub(super) middle: DVec2,
    /// Radius of its arc.
    pub(super) radius: f64,
    /// Height of its upper edge.
    pub(super) height: f64,
    /// Direction of the middle of its open side: degrees from +x towards +z.
    pub(super) opening: f64,
    /// Colors of the three lamps aimed at it.
    pub(super) colors: [LinearRgb; 3],
}

const RED: LinearRgb = [1.0, 0.1, 0.06];
const GREEN: LinearRgb = [0.12, 0.9, 0.16];
const BLUE: LinearRgb = [0.1, 0.2, 1.0];
const AMBER: LinearRgb = [1.0, 0.5, 0.12];
const MAGENTA: LinearRgb = [1.0, 0.1, 0.7];
const CYAN: LinearRgb = [0.1, 0.75, 0.9];

/// All bands.
pub(super) const BANDS: [Band; 4] = [
    Band {
        middle: DVec2::new(-1.25, 0.55),
        radius: 0.72,
        height: 0.46,
        opening: 60.0,
        colors: [RED, GREEN, BLUE],
    },
    Band {
        middle: DVec2::new(0.75, 1.05),
        radius: 0.6,
        height: 0.36,
        opening: 100.0,
        colors: [AMBER, MAGENTA, CYAN],
    },
    Band {
        middle: DVec2::new(0.1, -1.3),
        radius: 0.95,
        height: 0.62,
        opening: 85.0,
        colors: [CYAN, RED, AMBER],
    },
    Band {
        middle: DVec2::new(1.75, -0.4),
        radius: 0.55,
        height: 0.5,
        opening: 150.0,
        colors: [BLUE, GREEN, MAGENTA],
    },
];

pub(super) fn add(scene: &mut Scene, materials: &DiscoMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    dais(&mut assembly, materials, detail);
    let metals = [
        materials.brass,
        materials.copper,
        materials.steel,
        materials.brass,
    ];
    for (band, material) in BANDS.iter().zip(metals) {
        stand(&mut assembly, materials, detail, band, material);
    }
    scene.place_assembly("dance_floor", assembly);
}

/// A round platform of lacquered wedges with a steel rim.
fn dais(assembly: &mut Assembly, materials: &DiscoMaterials, detail: Detail) {
    let round = detail.segments(72);
    let base = bevelled_cylinder(RADIUS, DAIS - 0.012, 0.01, round);
    assembly.add(
        materials.black,
        &base.placed(Pose::at(CENTER.x, 0.0, CENTER.z)),
    );
    let rim = torus(RADIUS - 0.02, 0.03, round, 8);
    assembly.add(
        materials.steel,
        &rim.placed(Pose::at(CENTER.x, DAIS - 0.012, CENTER.z)),
    );
    // Outer rings have more wedges, which keeps the wedges narrow.
    let step = (RADIUS - 0.09) / 6.0;
    for ring in 0..6_usize {
        let (inner, outer) = (step * ring as f64, step * (ring + 1) as f64 - 0.003);
        let count = [6, 12, 24, 24, 24, 48][ring];
        for i in 0..count {
            let wedge = wedge(inner, outer, 360.0 / count as f64, detail);
            let pose = Pose::at(CENTER.x, DAIS, CENTER.z).turned(360.0 * i as f64 / count as f64);
            assembly.add(materials.pale[(ring + i) % 2], &wedge.placed(pose));
        }
    }
}

/// A sector of a ring about the y axis, `degrees` wide, with its upper side at y = 0.
fn wedge(inner: f64, outer: f64, degrees: f64, detail: Detail) -> Mesh {
    let gap = |radius: f64| (0.0015 / radius.max(0.05)).to_degrees();
    let segments = detail.segments(((degrees / 7.0).round() as usize).max(2));
    let mut outline = arc(
        DVec2::ZERO,
        outer,
        gap(outer),
        degrees - gap(outer),
        segments,
    );
    if inner > 0.0 {
        outline.extend(arc(
            DVec2::ZERO,
            inner,
            degrees - gap(inner),
            gap(inner),
            segments,
        ));
    } else {
        outline.push(DVec2::from_angle((degrees / 2.0).to_radians()) * 0.003);
    }
    // The y axis of the outline points to -z.
    let lying = Pose::at(0.0, -0.0075, 0.0).tilted(-90.0);
    extrude(&outline, 0.015, 25.0).placed(lying)
}

/// A band of sheet metal with a tube along its upper edge.
fn stand(
    assembly: &mut Assembly,
    materials: &DiscoMaterials,
    detail: Detail,
    band: &Band,
    material: MaterialId,
) {
    let segments = detail.segments(44);
    // Half the angle of the open side, in degrees.
    let gap = 62.0;
    let around: Vec<DVec3> = arc(
        band.middle,
        band.radius,
        band.opening + gap,
        band.opening + 360.0 - gap,
        segments,
    )
    .iter()
    .map(|p| CENTER + DVec3::new(p.x, DAIS, p.y))
    .collect();
    let sheet = [
        (-0.005, 0.0),
        (0.005, 0.0),
        (0.005, band.height),
        (-0.005, band.height),
    ]
    .map(DVec2::from);
    assembly.add(material, &moulding(&sheet, &around, 35.0));
    let lifted: Vec<DVec3> = around.iter().map(|p| *p + DVec3::Y * band.height).collect();
    let rail: Mesh = crate::build::tube(&lifted, detail.segments(8), |_| 0.014);
    assembly.add(materials.steel, &rail);
}
