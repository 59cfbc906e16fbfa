//! All infinite lights together: sampling from a point, lookup along a ray, emission of photons.

use super::BoundingSphere;
use super::guides::{InfiniteLightGuides, UNGUIDED_PROBABILITY};
use super::light::{InfiniteLight, InfiniteLightKind, constant_pdf, sample_constant};
use super::plan::{InfiniteLightPlan, PlannedDirection};
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::emitters::selection_weight::SelectionWeight;
use crate::emitters::unit_interval::split;
use crate::geometry::Ray;
use crate::ids::EmitterId;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;

/// All infinite lights of a scene.
#[derive(Clone, Debug)]
pub(in crate::emitters) struct InfiniteLights {
    lights: Vec<InfiniteLight>,
    sphere: BoundingSphere,
}

/// A direction towards an infinite light.
pub(in crate::emitters) struct InfiniteLightSample {
    pub(in crate::emitters) wi: Vec3,
    pub(in crate::emitters) radiance: SampledRadiance,
}

/// Light from a sampled direction.
pub(in crate::emitters) enum SampledRadiance {
    /// Parallel light: irradiance on a perpendicular plane over the probability of choosing the light.
    Parallel(Rgb),
    /// Radiance and density as [`InfiniteLights::look_up`] gives them; sampling has computed them, because the light is the only
    /// one.
    Known(Rgb, f32),
    /// Radiance and density are those of [`InfiniteLights::look_up`].
    LookUp,
}

/// The random numbers that place a photon of an infinite light.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct InfiniteEmissionNumbers {
    /// Position on the disc perpendicular to the direction.
    pub(in crate::emitters) position: Vec2,
    /// Direction.
    pub(in crate::emitters) direction: Vec2,
    /// Choice between guided and unguided emission.
    pub(in crate::emitters) guide: f32,
}

impl InfiniteLights {
    pub(in crate::emitters) fn new(emitters: &[Emitter], sphere: BoundingSphere) -> Self {
        let mut lights = Vec::new();
        for (i, emitter) in emitters.iter().enumerate() {
            let Some(kind) = InfiniteLightKind::new(emitter) else {
                continue;
            };
            let weight = kind.total().selection_weight();
            if weight > 0.0 {
                lights.push(InfiniteLight {
                    emitter: EmitterId::from(i),
                    kind,
                    pmf: weight,
                });
            }
        }
        let sum: f32 = lights.iter().map(|l| l.pmf).sum();
        for light in &mut lights {
            light.pmf /= sum;
        }
        InfiniteLights { lights, sphere }
    }

    pub(in crate::emitters) fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.lights.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &InfiniteLight> {
        self.lights.iter()
    }

    /// The bounding sphere of the scene.
    pub(in crate::emitters) fn sphere(&self) -> &BoundingSphere {
        &self.sphere
    }

    /// Whether some light fills a solid angle.
    pub(in crate::emitters) fn fills_directions(&self) -> bool {
        self.lights.iter().any(InfiniteLight::fills_directions)
    }

    /// Each light's flux through the bounding sphere in W.
    pub(in crate::emitters) fn powers(&self) -> impl Iterator<Item = (EmitterId, Rgb)> + '_ {
        self.lights
            .iter()
            .map(|l| (l.emitter, l.kind.total() * self.sphere.cross_section()))
    }

    /// Chooses a light by `u_choice`. For an environment map it also chooses the row of tiles.
    #[inline]
    pub(in crate::emitters) fn plan(&self, u_choice: f32, u: Vec2) -> InfiniteLightPlan {
        let (light, u_left) = self.choose(u_choice);
        let direction = match &self.lights[light].kind {
            InfiniteLightKind::Environment(sampler) => PlannedDirection::Numbers(u).next(sampler),
            _ => PlannedDirection::Numbers(u),
        };
        InfiniteLightPlan {
            light,
            u_left,
            direction,
        }
    }

    /// Takes the direction of a plan to its next stage; see [`PlannedDirection`].
    #[inline]
    pub(in crate::emitters) fn prefetch_step(&self, plan: &mut InfiniteLightPlan) {
        if let InfiniteLightKind::Environment(sampler) = &self.lights[plan.light].kind {
            plan.direction = plan.direction.next(sampler);
        }
    }

    /// A direction for direct light at a receiver with normal `n`.
    pub(in crate::emitters) fn sample(
        &self,
        n: Option<Vec3>,
        plan: &InfiniteLightPlan,
    ) -> InfiniteLightSample {
        let light = &self.lights[plan.light];
        let (wi, radiance) = match &light.kind {
            InfiniteLightKind::Directional { wi, irradiance } => {
                (*wi, SampledRadiance::Parallel(*irradiance / light.pmf))
            }
            InfiniteLightKind::Constant { .. } => (
                sample_constant(n, plan.u_left, plan.direction.numbers()),
                SampledRadiance::LookUp,
            ),
            InfiniteLightKind::Environment(sampler) => {
                let sample = plan.direction.finish(sampler);
                let radiance = if self.lights.len() == 1 {
                    SampledRadiance::Known(sample.radiance, sample.pdf)
                } else {
                    SampledRadiance::LookUp
                };
                (sample.wi, radiance)
            }
        };
        InfiniteLightSample { wi, radiance }
    }

    /// Radiance from the unit direction `wi`, summed over all lights that fill a solid angle, and the density of
    /// [`InfiniteLights::sample`] for these lights.
    #[inline]
    pub(in crate::emitters) fn look_up(&self, n: Option<Vec3>, wi: Vec3) -> (Rgb, f32) {
        let (mut radiance, mut pdf) = (Rgb::BLACK, 0.0);
        for light in &self.lights {
            let (l, density) = match &light.kind {
                InfiniteLightKind::Directional { .. } => continue,
                InfiniteLightKind::Constant { radiance } => (*radiance, constant_pdf(n, wi)),
                InfiniteLightKind::Environment(sampler) => {
                    let seen = sampler.look_up(wi);
                    (seen.radiance, seen.pdf)
                }
            };
            radiance += l;
            pdf += light.pmf * density;
        }
        (radiance, pdf)
    }

    /// The ray of a photon of `emitter` into the bounding sphere, and its flux.
    pub(in crate::emitters) fn emit(
        &self,
        emitter: EmitterId,
        guides: Option<&InfiniteLightGuides>,
        u: InfiniteEmissionNumbers,
    ) -> Option<(Ray, Rgb)> {
        let index = self.lights.iter().position(|l| l.emitter == emitter)?;
        let light = &self.lights[index];
        let mut numbers = [u.direction.x, u.direction.y, u.position.x, u.position.y];
        let guide = guides.and_then(|guides| guides.of_light(index));
        let guided = guide.filter(|_| !split(u.guide, UNGUIDED_PROBABILITY).0);
        if let Some(guide) = guided {
            numbers = guide.warp(numbers);
        }
        let [x, y, across_x, across_y] = numbers;
        let (wi, irradiance) = light.sample_emission(Vec2::new(x, y))?;
        let frame = Frame::from_normal(wi);
        let disc = warp::disc(Vec2::new(across_x, across_y));
        let across = match guided {
            Some(guide) => guide.disc_center(&self.sphere, &frame) + disc * guide.radius(),
            None => disc * self.sphere.radius,
        };
        let relative_density = guide.map_or(1.0, |guide| {
            guide.relative_density(&self.sphere, Vec2::new(x, y), &frame, across)
        });
        let o = self.sphere.center + frame.to_world(across.extend(self.sphere.radius));
        Some((
            Ray::new(o, -wi),
            irradiance * (self.sphere.cross_section() / relative_density),
        ))
    }

    /// The gain of each light's guide: by this factor a guided photon has less flux than an unguided one, in the geometric mean.
    pub(in crate::emitters) fn gains(
        &self,
        guides: &InfiniteLightGuides,
    ) -> impl Iterator<Item = (EmitterId, f32)> {
        self.lights.iter().map(|l| l.emitter).zip(guides.gains())
    }

    /// Index of a light in proportion to its `pmf`, and a number that is uniform in [0, 1) given the choice.
    #[inline]
    fn choose(&self, u: f32) -> (usize, f32) {
        let mut below = 0.0;
        for (i, light) in self.lights.iter().enumerate() {
            if u < below + light.pmf {
                return (i, ((u - below) / light.pmf).clamp(0.0, 1.0 - f32::EPSILON));
            }
            below += light.pmf;
        }
        // Reached only by rounding of the sum.
        (self.lights.len() - 1, 0.5)
    }
}
