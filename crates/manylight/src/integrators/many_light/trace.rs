//! Stage 1: photons from the emitters, importons from the camera.

use super::schedule::PassGroup;
use crate::bsdf::Lobes;
use crate::integrators::context::PassContext;
use crate::maps::{IncidentMap, KdTree};
use crate::particles::{Importon, Photon, for_lights, trace_importons, trace_photons};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;

/// The photons of a group: on every surface with non-specular lobes, in path order.
pub(super) fn photons(
    scene: &Scene,
    limits: PathLimits,
    group: &PassGroup,
    run: &PassContext,
) -> Vec<Photon> {
    let stats = run.stats;
    let photons = stats.time("photons", || {
        trace_photons(scene, limits, group.photon_paths, run.pass, for_lights)
    });
    Stats::count(&stats.photon_paths, u64::from(group.photon_paths));
    Stats::count(&stats.photons, photons.len() as u64);
    photons
}

/// The importons of a group, ready for density estimates of importance.
pub(super) fn importons(
    scene: &Scene,
    limits: PathLimits,
    group: &PassGroup,
    run: &PassContext,
) -> KdTree<Importon> {
    let stats = run.stats;
    let importons = stats.time("importons", || {
        trace_importons(scene, limits, group.importon_paths, run.pass)
    });
    Stats::count(&stats.importons, importons.len() as u64);
    stats.time("maps", || KdTree::build_ordered(importons))
}

/// Maps of photons that serve by themselves: those straight from the environment, and those with a specular last event.
pub(super) fn maps(
    scene: &Scene,
    photons: &[Photon],
    run: &PassContext,
) -> (IncidentMap, KdTree<Photon>) {
    run.stats.time("maps", || {
        let caustics = photons.iter().filter(|p| p.event.has(Lobes::SPECULAR));
        (
            IncidentMap::from_afar(scene, photons),
            KdTree::build_ordered(caustics.copied().collect()),
        )
    })
}
