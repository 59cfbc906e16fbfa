//! A tool chest on casters.

use super::super::GarageMaterials;
use super::wrench;
use crate::build::{bevelled_box, bevelled_cylinder, extrude};
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::Detail;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    assembly.add(
        materials.red,
        &bevelled_box([-0.36, 0.1, -0.22], [0.36, 0.98, 0.2], 0.008),
    );
    drawers(&mut assembly, materials);
    casters(&mut assembly, materials, detail);
    tools(&mut assembly, materials, detail);
    scene.place_assembly(
        "chest",
        assembly.placed(Pose::at(-2.35, 0.0, -3.1).turned(24.0)),
    );
}

/// Six drawers with chrome handles.
fn drawers(assembly: &mut Assembly, materials: &GarageMaterials) {
    let mut y = 0.13;
    for height in [0.22, 0.15, 0.15, 0.1, 0.1, 0.08] {
        assembly.add(
            materials.red,
            &bevelled_box([-0.33, y, 0.19], [0.33, y + height - 0.012, 0.215], 0.005),
        );
        let bar = bevelled_box(
            [-0.3, y + height - 0.036, 0.212],
            [0.3, y + height - 0.018, 0.232],
            0.004,
        );
        assembly.add(materials.chrome, &bar);
        y += height;
    }
}

/// Four casters.
fn casters(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    for (x, z) in [(-0.3, -0.16), (0.3, -0.16), (-0.3, 0.14), (0.3, 0.14)] {
        let caster = bevelled_cylinder(0.05, 0.03, 0.006, detail.segments(18));
        assembly.add(
            materials.rubber,
            &caster.placed(Pose::at(x + 0.015, 0.05, z).rolled(90.0)),
        );
        assembly.add(
            materials.iron,
            &bevelled_box(
                [x - 0.02, 0.05, z - 0.02],
                [x + 0.02, 0.102, z + 0.02],
                0.003,
            ),
        );
    }
}

/// A mat, a jug and wrenches on top.
fn tools(assembly: &mut Assembly, materials: &GarageMaterials, detail: Detail) {
    assembly.add(
        materials.iron,
        &bevelled_box([-0.34, 0.981, -0.2], [0.34, 0.986, 0.18], 0.002),
    );
    let jug = bevelled_cylinder(0.06, 0.16, 0.008, detail.segments(22));
    assembly.add(
        materials.galvanized,
        &jug.placed(Pose::at(-0.2, 0.986, -0.03)),
    );
    for i in 0..3 {
        let tool = extrude(&wrench(0.2 + 0.02 * f64::from(i)), 0.008, 35.0);
        let pose = Pose::at(0.06 * f64::from(i) + 0.02, 0.992, 0.0)
            .tilted(90.0)
            .turned(12.0 * f64::from(i) - 8.0);
        assembly.add(materials.chrome, &tool.placed(pose));
    }
}
