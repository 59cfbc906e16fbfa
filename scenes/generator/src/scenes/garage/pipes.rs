//! Water pipes, an air duct and a valve.

use super::{BACK, FRONT, GarageMaterials, HEIGHT, LEFT, RIGHT};
use crate::build::{bevelled_box, bevelled_cylinder, torus, tube};
use crate::pose::Pose;
use crate::scene::{Assembly, MaterialId, Scene};
use crate::scenes::Detail;
use glam::DVec3;

/// Height of the pipes under the ceiling.
const PIPES: f64 = HEIGHT - 0.42;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    water_pipes(&mut assembly, materials, detail);
    duct(&mut assembly, materials, detail);
    hangers(&mut assembly, materials);
    valve(&mut assembly, materials, detail);
    scene.place_assembly("pipe", assembly);
}

/// A sprinkler pipe, two copper pipes and a conduit.
fn water_pipes(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    pipe(
        assembly,
        materials.red,
        detail,
        0.045,
        &[[LEFT, PIPES, -1.6], [RIGHT, PIPES, -1.6]],
    );
    pipe(
        assembly,
        materials.copper,
        detail,
        0.022,
        &[
            [LEFT, PIPES, -1.42],
            [1.4, PIPES, -1.42],
            [1.4, PIPES, BACK + 0.1],
            [1.4, 0.3, BACK + 0.1],
        ],
    );
    pipe(
        assembly,
        materials.copper,
        detail,
        0.022,
        &[
            [LEFT, PIPES, -1.35],
            [1.5, PIPES, -1.35],
            [1.5, PIPES, BACK + 0.1],
            [1.5, 0.3, BACK + 0.1],
        ],
    );
    pipe(
        assembly,
        materials.galvanized,
        detail,
        0.03,
        &[
            [-2.2, 0.0, BACK + 0.06],
            [-2.2, 2.1, BACK + 0.06],
            [LEFT + 0.06, 2.1, BACK + 0.06],
            [LEFT + 0.06, 2.1, FRONT],
        ],
    );
}

/// A pipe along a path with rounded corners.
fn pipe(
    assembly: &mut Assembly,
    material: MaterialId,
    detail: Detail,
    radius: f64,
    path: &[[f64; 3]],
) {
    let path: Vec<DVec3> = path.iter().copied().map(DVec3::from).collect();
    assembly.add(
        material,
        &tube(
            &rounded_corners(&path, radius * 2.5),
            detail.segments(12),
            |_| radius,
        ),
    );
}

/// A path with each corner replaced by a quadratic curve that starts `reach` before it.
fn rounded_corners(path: &[DVec3], reach: f64) -> Vec<DVec3> {
    let last = path.len() - 1;
    let mut smooth = vec![path[0]];
    for i in 1..last {
        let corner = path[i];
        let from = corner + (path[i - 1] - corner).normalize() * reach;
        let to = corner + (path[i + 1] - corner).normalize() * reach;
        smooth.extend((0..=4).map(|k| {
            let t = f64::from(k) / 4.0;
            from.lerp(corner, t).lerp(corner.lerp(to, t), t)
        }));
    }
    smooth.push(path[last]);
    smooth
}

/// An air duct under the ceiling with rings, each on a rod.
fn duct(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let duct = tube(
        &[
            DVec3::new(-1.3, HEIGHT - 0.55, BACK),
            DVec3::new(-1.3, HEIGHT - 0.55, FRONT),
        ],
        detail.segments(28),
        |_| 0.2,
    );
    assembly.add(materials.galvanized, &duct);
    let ring = torus(0.205, 0.012, detail.segments(28), 6);
    for i in 0..8 {
        let z = BACK + 0.6 + 1.2 * f64::from(i);
        assembly.add(
            materials.galvanized,
            &ring.placed(Pose::at(-1.3, HEIGHT - 0.55, z).tilted(90.0)),
        );
        let rod = [
            DVec3::new(-1.3, HEIGHT - 0.34, z),
            DVec3::new(-1.3, HEIGHT, z),
        ];
        assembly.add(materials.iron, &tube(&rod, 6, |_| 0.006));
    }
}

/// Hangers of the sprinkler pipe.
fn hangers(assembly: &mut Assembly, materials: &GarageMaterials) {
    for i in 0..5 {
        let x = -4.6 + 2.2 * f64::from(i);
        assembly.add(
            materials.iron,
            &bevelled_box(
                [x - 0.02, PIPES + 0.03, -1.66],
                [x + 0.02, HEIGHT, -1.54],
                0.004,
            ),
        );
    }
}

/// A valve with a handwheel between the copper pipes.
fn valve(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    let wheel = torus(0.075, 0.011, detail.segments(24), 8);
    assembly.add(
        materials.red,
        &wheel.placed(Pose::at(1.45, 1.35, BACK + 0.19).tilted(90.0)),
    );
    assembly.add(
        materials.brass,
        &bevelled_box([1.37, 1.3, BACK + 0.06], [1.53, 1.4, BACK + 0.14], 0.01),
    );
    let hub = bevelled_cylinder(0.012, 0.07, 0.002, 12);
    assembly.add(
        materials.brass,
        &hub.placed(Pose::at(1.45, 1.35, BACK + 0.13).tilted(90.0)),
    );
    for turn in [0.0, 90.0] {
        let spoke = bevelled_box([-0.07, -0.006, -0.004], [0.07, 0.006, 0.004], 0.002);
        assembly.add(
            materials.red,
            &spoke.placed(Pose::at(1.45, 1.35, BACK + 0.19).rolled(turn)),
        );
    }
}
