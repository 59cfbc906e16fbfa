//! Absorption along the segments of walks inside of bodies.

use super::{Arrivals, Walks};
use crate::color::Rgb;
use crate::ids::MaterialId;
use crate::math::float::exp;
use crate::scene::Scene;

/// Multiplies the throughput of the walks that arrive by what the media along their segments
/// transmit, `exp(-σ t)` (Beer and Lambert). A segment is inside of a body if it ends at the back of
/// a surface around a medium, or starts there. Segments between two surfaces within a body, neither
/// of which is its own, are not attenuated.
pub(super) fn absorb<T>(scene: &Scene, walks: &mut Walks<T>, arrivals: &Arrivals) {
    if scene.media.is_empty() {
        return;
    }
    for (material, indices) in arrivals.runs() {
        let at_end = scene.media.absorption(material);
        for &i in indices {
            let Some((hit, ray)) = arrivals.hits[i as usize].zip(walks.rays.get(i as usize)) else {
                continue;
            };
            let is_behind = || {
                let x = scene.geometry.surface_point(hit.at);
                x.ng.dot(ray.d) > 0.0
            };
            let at_start = walks.previous[i as usize].inside;
            let absorption = match at_end {
                Some(absorption) if is_behind() => Some(absorption),
                _ => at_start.and_then(|inside| scene.media.absorption(inside)),
            };
            if let Some(absorption) = absorption {
                walks.scale_throughput(i, transmittance(absorption, hit.t));
            }
        }
    }
}

/// The fraction of light that a medium transmits over a distance in m.
fn transmittance(absorption: Rgb, distance: f32) -> Rgb {
    absorption.map(|sigma| exp(-sigma * distance))
}

/// The material around the body in which a walk goes on, if it leaves a surface of `material` to
/// the side of its back.
pub(super) fn inside(scene: &Scene, material: MaterialId) -> Option<MaterialId> {
    scene.media.absorption(material).map(|_| material)
}
