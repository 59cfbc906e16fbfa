//! Next-event estimation, and the MIS weight of emitters that a walk runs into.

use super::walk::Previous;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::geometry::{Segment, SurfacePoint};
use crate::math::{Vec2, Vec3};
use crate::sampling::mis;
use crate::scene::Scene;

/// A direction from a point to an emitter, visibility not yet tested.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// Unit direction to the emitter.
    pub wi: Vec3,
    /// Radiance over pdf, in W/m²: times `f |cos|` this is reflected radiance.
    pub weight: Rgb,
    /// Density per solid angle, in 1/sr; 0 for emitters that only next-event estimation finds.
    pub pdf: f32,
    segment: Segment,
}

impl EmitterSample {
    /// A direction from `x` to an emitter; `n` as in [`crate::bsdf::Bsdf::receiving_normal`]; `numbers` are uniform in [0, 1).
    pub fn new(
        scene: &Scene,
        x: &SurfacePoint,
        n: Option<Vec3>,
        numbers: (f32, Vec2),
    ) -> Option<Self> {
        let (geometry, textures) = (&scene.geometry, &scene.textures);
        let sample = (scene.emitters).sample(geometry, textures, (x.p, n), numbers, None)?;
        Some(EmitterSample {
            wi: sample.wi,
            weight: sample.weight,
            pdf: sample.pdf,
            segment: Segment {
                from: x.offset_towards(sample.wi),
                to: sample.target,
            },
        })
    }

    /// MIS weight (power heuristic) against a walk that samples the same direction with density `pdf_walk`, in 1/sr.
    #[inline]
    pub fn mis_weight(&self, pdf_walk: f32) -> f32 {
        if self.pdf > 0.0 {
            mis::power(self.pdf, pdf_walk)
        } else {
            1.0
        }
    }

    /// Transmittance of the shadow ray; black if it crosses more than `max_crossings` transparent surfaces.
    pub fn transmittance(&self, scene: &Scene, max_crossings: u32) -> Rgb {
        let (transmittance, crossings) = scene.transmittance_and_crossings(&self.segment);
        if crossings <= max_crossings {
            transmittance
        } else {
            Rgb::BLACK
        }
    }
}

/// Radiance that the surface point `y` emits along `wo` to the end of a walk, times its MIS weight against next-event
/// estimation at the walk's last event, in W/(m² sr).
#[inline]
pub fn emitted_with_mis(scene: &Scene, previous: &Previous, y: &SurfacePoint, wo: Vec3) -> Rgb {
    let radiance = scene
        .emitters
        .radiance(&scene.geometry, &scene.textures, y, wo);
    if radiance.is_black() {
        return Rgb::BLACK;
    }
    radiance
        * walk_weight(previous, || {
            scene.emitters.pdf_direct(previous.p, previous.n, y)
        })
}

/// Radiance of the environment along `wi`, times its MIS weight as in [`emitted_with_mis`]; with `lobes` if next-event estimation
/// uses them.
#[inline]
pub fn environment_with_mis(
    scene: &Scene,
    previous: &Previous,
    wi: Vec3,
    lobes: Option<&EnvironmentLobes>,
) -> Rgb {
    let (radiance, pdf) = scene.emitters.environment(previous.n, wi, lobes);
    if radiance.is_black() {
        return Rgb::BLACK;
    }
    radiance * walk_weight(previous, || pdf)
}

/// MIS weight of a walk. Next-event estimation cannot sample directions after delta events and from the camera.
#[inline]
fn walk_weight(previous: &Previous, pdf_direct: impl FnOnce() -> f32) -> f32 {
    if previous.event == Lobes::NONE || previous.event == Lobes::DELTA {
        1.0
    } else {
        mis::power(previous.pdf, pdf_direct())
    }
}
