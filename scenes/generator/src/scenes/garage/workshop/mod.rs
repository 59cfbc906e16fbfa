//! The workshop: a bench with tools, a shelf, a tool chest, and objects on the floor.

mod bench;
mod floor;
mod shelf;
mod tool_chest;

use super::GarageMaterials;
use crate::scene::Scene;
use crate::scenes::Detail;
use glam::DVec2;

pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail) {
    bench::add(scene, materials, detail);
    shelf::add(scene, materials, detail);
    tool_chest::add(scene, materials, detail);
    floor::add(scene, materials, detail);
}

/// Outline of an open-ended wrench of a length along y.
fn wrench(length: f64) -> Vec<DVec2> {
    let w = 0.05 * length + 0.004;
    let h = length / 2.0;
    [
        (-w, -h + 1.6 * w),
        (-1.9 * w, -h + 0.5 * w),
        (-1.1 * w, -h - 0.6 * w),
        (-0.9 * w, -h + 0.9 * w),
        (0.9 * w, -h + 0.9 * w),
        (1.1 * w, -h - 0.6 * w),
        (1.9 * w, -h + 0.5 * w),
        (w, -h + 1.6 * w),
        (w, h - 1.6 * w),
        (1.9 * w, h - 0.5 * w),
        (1.1 * w, h + 0.6 * w),
        (0.9 * w, h - 0.9 * w),
        (-0.9 * w, h - 0.9 * w),
        (-1.1 * w, h + 0.6 * w),
        (-1.9 * w, h - 0.5 * w),
        (-w, h - 1.6 * w),
    ]
    .map(DVec2::from)
    .to_vec()
}
