//! Light from emitters at a point: next-event estimation, and the weight of emitters that a walk runs into.

use super::walk::Previous;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters;
use crate::geometry::{Segment, SurfacePoint};
use crate::math::{Vec2, Vec3};
use crate::sampling::{Sampler, mis};
use crate::scene::Scene;

/// What random numbers decide about a direction towards an emitter before the receiver is known. Made early, so that the memory
/// that it leads to is near when it is needed.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPlan(emitters::EmitterPlan);

impl EmitterPlan {
    /// Draws the numbers.
    #[inline]
    pub fn draw(scene: &Scene, sampler: &mut Sampler) -> Self {
        EmitterPlan::new(scene, sampler.next_1d(), sampler.next_2d())
    }

    /// From numbers in [0, 1).
    #[inline]
    pub fn new(scene: &Scene, u_choice: f32, u: Vec2) -> Self {
        EmitterPlan(scene.emitters.plan(u_choice, u))
    }

    /// Takes the plan one of three optional steps on, each of which reads memory that the one before has asked for.
    #[inline]
    pub fn refine(&mut self, scene: &Scene) {
        scene.emitters.prefetch_step(&mut self.0);
    }
}

/// A direction towards an emitter, before visibility.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// Unit direction to the emitter.
    pub wi: Vec3,
    /// Radiance over pdf; times `f |cos|` this is reflected radiance.
    pub weight: Rgb,
    /// Per solid angle; 0 for emitters that only next-event estimation finds.
    pub pdf: f32,
    segment: Segment,
}

impl EmitterSample {
    /// A direction from `x` to an emitter; `n` as in [`crate::bsdf::Bsdf::receiving_normal`].
    pub fn planned(
        scene: &Scene,
        x: &SurfacePoint,
        n: Option<Vec3>,
        plan: &EmitterPlan,
    ) -> Option<Self> {
        let s = scene
            .emitters
            .sample(&scene.geometry, &scene.textures, x.p, n, &plan.0)?;
        let segment = Segment {
            from: x.offset_towards(s.wi),
            to: s.target,
        };
        Some(EmitterSample {
            wi: s.wi,
            weight: s.weight,
            pdf: s.pdf,
            segment,
        })
    }

    /// MIS weight against a walk that finds the same direction with density `pdf_walk`.
    #[inline]
    pub fn mis_weight(&self, pdf_walk: f32) -> f32 {
        if self.pdf > 0.0 {
            mis::power(self.pdf, pdf_walk)
        } else {
            1.0
        }
    }

    /// Fraction of light that arrives; black if more than `max_crossings` transparent surfaces lie between.
    pub fn transmittance(&self, scene: &Scene, max_crossings: u32) -> Rgb {
        let (transmittance, crossings) = scene.transmittance_and_crossings(&self.segment);
        if crossings <= max_crossings {
            transmittance
        } else {
            Rgb::BLACK
        }
    }
}

/// Radiance that a walk finds on the emitter at `y`, weighted against next-event estimation at the walk's last event.
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

/// The same for the surroundings along `wi`.
#[inline]
pub fn environment_with_mis(scene: &Scene, previous: &Previous, wi: Vec3) -> Rgb {
    let (radiance, pdf) = scene.emitters.environment(previous.n, wi);
    if radiance.is_black() {
        return Rgb::BLACK;
    }
    radiance * walk_weight(previous, || pdf)
}

/// Next-event estimation cannot form the edges after delta events and from the camera itself.
#[inline]
fn walk_weight(previous: &Previous, pdf_direct: impl FnOnce() -> f32) -> f32 {
    if previous.event == Lobes::NONE || previous.event == Lobes::DELTA {
        1.0
    } else {
        mis::power(previous.pdf, pdf_direct())
    }
}
