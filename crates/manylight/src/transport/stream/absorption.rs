//! Absorption along the segments of walks inside of bodies.

use super::{Arrivals, Walks};
use crate::geometry::Segment;
use crate::ids::MaterialId;
use crate::scene::{Scene, transmittance};

/// Multiplies the throughput of the walks that arrive by what the media along their segments
/// transmit, `exp(-σ t)` (Beer and Lambert). A segment is inside of a body if it ends at the back
/// of a surface around a medium, or starts there; between two surfaces within a body, neither of
/// which is its own, if that is the surface that its line leaves first.
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
            let end = || scene.geometry.surface_point(hit.at);
            let is_within = || {
                let (from, to) = (ray.o, end().p);
                scene.media.may_contain(&Segment { from, to })
            };
            let at_start = walks.state(i).previous.inside;
            let absorption = match at_end {
                Some(absorption) if end().ng.dot(ray.d) > 0.0 => Some(absorption),
                _ => match at_start {
                    Some(inside) => scene.media.absorption(inside),
                    None if is_within() => scene.medium_before(Some(hit), ray.d),
                    None => None,
                },
            };
            if let Some(absorption) = absorption {
                walks.scale_throughput(i, transmittance(absorption, hit.t));
            }
        }
    }
}

/// The material around the body in which a walk goes on, if it leaves a surface of `material` to
/// the side of its back.
pub(super) fn inside(scene: &Scene, material: MaterialId) -> Option<MaterialId> {
    scene.media.absorption(material).map(|_| material)
}
