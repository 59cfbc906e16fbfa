//! A steel shelf by the left wall with cans, cartons and bottles.

use super::super::{GarageMaterials, LEFT};
use crate::build::{bevelled_box, bevelled_cylinder, boxed, torus};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::{Detail, props};

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    let mut rng = Pcg32::new(44);
    let (x, depth, near, far) = (LEFT + 0.02, 0.42, -0.35, -2.35);
    for level in 0..5 {
        let y = 0.12 + 0.46 * f64::from(level);
        assembly.add(
            materials.galvanized,
            &bevelled_box([x, y - 0.03, far], [x + depth, y, near], 0.004),
        );
        if level < 4 {
            let row = Row {
                x: x + depth / 2.0,
                y,
                start: far + 0.12,
                end: near - 0.12,
            };
            row.fill(&mut assembly, materials, detail, &mut rng);
        }
    }
    for (dx, z) in [(0.0, near), (depth, near), (0.0, far), (depth, far)] {
        assembly.add(
            materials.blue,
            &boxed(
                [x + dx - 0.015, 0.0, z - 0.015],
                [x + dx + 0.015, 2.05, z + 0.015],
            ),
        );
    }
    scene.place_assembly("shelf", assembly);
}

/// A row of objects on a board, along z.
struct Row {
    x: f64,
    /// Height of the board.
    y: f64,
    /// z of the first object.
    start: f64,
    /// Upper limit of z.
    end: f64,
}

impl Row {
    /// Adds random objects next to each other.
    fn fill(
        &self,
        assembly: &mut Assembly,
        materials: &GarageMaterials,
        detail: Detail,
        rng: &mut Pcg32,
    ) {
        let paints = [
            materials.red,
            materials.blue,
            materials.cream,
            materials.galvanized,
            materials.orange,
            materials.iron,
        ];
        let mut z = self.start;
        loop {
            let paint = paints[rng.index(paints.len())];
            let kind = rng.index(3);
            // Half the extent along z.
            let half = rng.range(0.05, [0.085, 0.16, 0.06][kind]);
            z += half;
            if z + half > self.end {
                return;
            }
            let at = Pose::at(self.x + rng.jitter(0.05), self.y, z).turned(rng.jitter(9.0));
            match kind {
                0 => {
                    let height = half * rng.range(2.0, 2.7);
                    let can = bevelled_cylinder(half, height, 0.005, detail.segments(22));
                    assembly.add(paint, &can.placed(at));
                    let rim = torus(half - 0.002, 0.004, detail.segments(18), 4);
                    assembly.add(materials.galvanized, &rim.placed(at.lifted(height - 0.004)));
                }
                1 => assembly.add(materials.card, &carton(half, rng).placed(at)),
                _ => assembly.add(paint, &bottle(half, detail).placed(at)),
            }
            z += half + rng.range(0.01, 0.06);
        }
    }
}

/// A carton of random height.
fn carton(half_depth: f64, rng: &mut Pcg32) -> Mesh {
    let (height, z) = (rng.range(0.12, 0.3), half_depth * 0.95);
    bevelled_box([-0.15, 0.0, -z], [0.15, height, z], 0.004)
}

/// A plastic bottle.
fn bottle(radius: f64, detail: Detail) -> Mesh {
    let profile = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.1),
        (1.0, 2.6),
        (0.75, 3.1),
        (0.3, 3.4),
        (0.3, 3.9),
        (0.3, 3.9),
        (0.0, 3.9),
    ];
    let scaled = profile.map(|(r, y)| (r * radius, y * radius));
    props::turned(&scaled, 2, detail.segments(20))
}
