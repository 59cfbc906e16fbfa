//! All infinite lights together: sampling from a point, lookup along a ray, emission of photons.

use super::BoundingSphere;
use super::environment::{EnvironmentSampler, EnvironmentSamples};
use super::guides::{InfiniteLightGuides, UNGUIDED_PROBABILITY};
use super::light::{InfiniteLight, InfiniteLightKind, constant_pdf, sample_constant};
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::emitters::receivers::Receivers;
use crate::geometry::Ray;
use crate::ids::EmitterId;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, Word};
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;

/// All infinite lights of a scene.
#[derive(Clone, Debug)]
pub(in crate::emitters) struct InfiniteLights {
    lights: Vec<InfiniteLight>,
    sphere: BoundingSphere,
}

/// Directions towards infinite lights.
#[derive(Clone, Copy)]
pub(in crate::emitters) struct InfiniteLightSamples<S: Width> {
    pub(in crate::emitters) wi: Vector<S>,
    /// Radiance; of parallel light the irradiance on a perpendicular plane over the probability of
    /// choosing the light.
    pub(in crate::emitters) radiance: Color<S>,
    /// Density per solid angle; 1 of parallel light.
    pub(in crate::emitters) pdf: Float<S>,
    /// The lanes with parallel light.
    pub(in crate::emitters) is_parallel: Mask<S>,
    /// Index of the light, where it is parallel; else [`ENVIRONMENT`].
    pub(in crate::emitters) light: Word<S>,
}

/// Stands for all lights that fill a solid angle together.
pub(in crate::emitters) const ENVIRONMENT: u32 = u32::MAX >> 1;

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

    /// The lights that fill a solid angle.
    pub(in crate::emitters) fn environments(&self) -> impl Iterator<Item = EmitterId> + '_ {
        let lights = self.lights.iter().filter(|light| light.fills_directions());
        lights.map(|light| light.emitter)
    }

    /// Radiance of each of them from the unit direction `wi`.
    pub(in crate::emitters) fn terms(
        &self,
        wi: Vec3,
    ) -> impl Iterator<Item = (EmitterId, Rgb)> + '_ {
        let lights = self.lights.iter();
        lights.filter_map(move |light| Some((light.emitter, light.radiance(wi)?)))
    }

    /// The emitter of the light with this index; `None` for [`ENVIRONMENT`].
    pub(in crate::emitters) fn emitter(&self, index: usize) -> Option<EmitterId> {
        self.lights.get(index).map(|light| light.emitter)
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

    /// Directions for direct light in the lanes of `lanes`: a light is chosen by `u_choice`, a
    /// direction by `u`.
    #[inline(always)]
    pub(in crate::emitters) fn sample<S: Width>(
        &self,
        receivers: &Receivers<S>,
        (u_choice, u): (Float<S>, Pair<S>),
        lanes: Mask<S>,
    ) -> InfiniteLightSamples<S> {
        let s = lanes.width();
        let (light, u_left) = self.choose_each(u_choice, lanes);
        let mut all = InfiniteLightSamples::none(s);
        for (i, lanes) in light.groups(lanes) {
            let light = &self.lights[i as usize];
            let parallel = Word::splat(s, i);
            let samples = match &light.kind {
                InfiniteLightKind::Environment(sampler) => InfiniteLightSamples::of_environment(
                    EnvironmentSampler::sample(sampler, u, lanes),
                ),
                _ => light.sample(receivers, parallel, (u_left, u)),
            };
            all = InfiniteLightSamples::select(lanes, samples, all);
        }
        self.complete(receivers, all)
    }

    /// Sets radiance and density where they are those of all lights together.
    #[inline(always)]
    fn complete<S: Width>(
        &self,
        receivers: &Receivers<S>,
        samples: InfiniteLightSamples<S>,
    ) -> InfiniteLightSamples<S> {
        let is_known = match &self.lights[..] {
            [one] => !matches!(one.kind, InfiniteLightKind::Constant { .. }),
            _ => false,
        };
        if is_known || samples.is_parallel.all() {
            return samples;
        }
        let (radiance, pdf) = self.look_up(receivers, samples.wi);
        InfiniteLightSamples {
            radiance: Color::select(samples.is_parallel, samples.radiance, radiance),
            pdf: samples.is_parallel.select(samples.pdf, pdf),
            ..samples
        }
    }

    /// Radiance from the unit directions `wi`, summed over all lights that fill a solid angle, and
    /// the density of [`InfiniteLights::sample`] for these lights.
    #[inline(always)]
    pub(in crate::emitters) fn look_up<S: Width>(
        &self,
        receivers: &Receivers<S>,
        wi: Vector<S>,
    ) -> (Color<S>, Float<S>) {
        let s = wi.x.width();
        let (mut radiance, mut pdf) = (Color::black(s), Float::splat(s, 0.0));
        for light in &self.lights {
            let (l, density) = match &light.kind {
                InfiniteLightKind::Directional { .. } => continue,
                InfiniteLightKind::Constant { radiance } => {
                    (Color::splat(s, *radiance), constant_pdf(receivers, wi))
                }
                InfiniteLightKind::Environment(sampler) => {
                    let seen = EnvironmentSampler::look_up(sampler, wi);
                    (seen.radiance, seen.pdf)
                }
            };
            radiance += l;
            pdf += density * light.pmf;
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
        let guided = guide.filter(|_| u.guide >= UNGUIDED_PROBABILITY);
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

    /// The gain of each light's guide: by this factor a guided photon has less flux than an
    /// unguided one, in the geometric mean.
    pub(in crate::emitters) fn gains(
        &self,
        guides: &InfiniteLightGuides,
    ) -> impl Iterator<Item = (EmitterId, f32)> {
        self.lights.iter().map(|l| l.emitter).zip(guides.gains())
    }

    /// [`InfiniteLights::choose`] in the lanes of `lanes`; elsewhere any light.
    #[inline(always)]
    fn choose_each<S: Width>(&self, u: Float<S>, lanes: Mask<S>) -> (Word<S>, Float<S>) {
        let s = lanes.width();
        let mut light = Word::splat(s, self.lights.len() as u32 - 1);
        let mut rest = u.same(0.5);
        let (mut below, mut is_open) = (0.0, lanes);
        for (i, of) in self.lights.iter().enumerate() {
            let end = below + of.pmf;
            let is_here = is_open & u.lt(end);
            light = is_here.select_words(Word::splat(s, i as u32), light);
            let within = ((u - below) / of.pmf).clamp(0.0, 1.0 - f32::EPSILON);
            rest = is_here.select(within, rest);
            is_open = is_open & !is_here;
            below = end;
        }
        // Some are still open only by rounding of the sum.
        (light, rest)
    }
}

impl InfiniteLight {
    /// Directions towards this light, of this index. For parallel light also what arrives; for others
    /// [`InfiniteLights::look_up`] tells it.
    #[inline(always)]
    fn sample<S: Width>(
        &self,
        receivers: &Receivers<S>,
        index: Word<S>,
        (u_left, u): (Float<S>, Pair<S>),
    ) -> InfiniteLightSamples<S> {
        let s = u_left.width();
        let none = InfiniteLightSamples::none(s);
        match &self.kind {
            InfiniteLightKind::Directional { wi, irradiance } => InfiniteLightSamples {
                wi: Vector::splat(s, *wi),
                radiance: Color::splat(s, *irradiance / self.pmf),
                is_parallel: Mask::splat(s, true),
                light: index,
                ..none
            },
            InfiniteLightKind::Constant { .. } => InfiniteLightSamples {
                wi: sample_constant(receivers, u_left, u),
                ..none
            },
            InfiniteLightKind::Environment(sampler) => {
                let lanes = Mask::splat(s, true);
                InfiniteLightSamples::of_environment(EnvironmentSampler::sample(sampler, u, lanes))
            }
        }
    }
}

impl<S: Width> InfiniteLightSamples<S> {
    #[inline(always)]
    fn of_environment(samples: EnvironmentSamples<S>) -> Self {
        InfiniteLightSamples {
            wi: samples.wi,
            radiance: samples.radiance,
            pdf: samples.pdf,
            ..InfiniteLightSamples::none(samples.pdf.width())
        }
    }

    #[inline(always)]
    fn none(s: S) -> Self {
        InfiniteLightSamples {
            wi: Vector::splat(s, Vec3::Z),
            radiance: Color::black(s),
            pdf: Float::splat(s, 1.0),
            is_parallel: Mask::splat(s, false),
            light: Word::splat(s, ENVIRONMENT),
        }
    }

    #[inline(always)]
    fn select(m: Mask<S>, a: Self, b: Self) -> Self {
        InfiniteLightSamples {
            wi: Vector::select(m, a.wi, b.wi),
            radiance: Color::select(m, a.radiance, b.radiance),
            pdf: m.select(a.pdf, b.pdf),
            is_parallel: (m & a.is_parallel) | (!m & b.is_parallel),
            light: m.select_words(a.light, b.light),
        }
    }
}
