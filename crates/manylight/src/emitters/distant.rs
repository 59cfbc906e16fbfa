//! Emitters at infinity: parallel light, constant radiance, pictures of the surroundings.

use super::environment::EnvironmentSampler;
use super::guide::{Guide, Lesson, Point4};
use super::warp_within::split;
use super::{Emitter, Strength};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::ids::EmitterId;
use crate::math::{Aabb, Frame, Vec2, Vec3};
use crate::sampling::warp;
use std::f32::consts::{FRAC_PI_4, PI};

/// A sphere around everything that light from infinity can meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingSphere {
    pub(super) center: Vec3,
    /// Never 0, so that distant emitters keep a defined power over empty scenes and single points.
    pub(super) radius: f32,
}

impl BoundingSphere {
    /// Larger than the half-diagonal by this factor, against rounding.
    const SLACK: f32 = 1.001;

    pub(super) fn new(bounds: Aabb) -> Self {
        if bounds.is_empty() {
            return BoundingSphere {
                center: Vec3::ZERO,
                radius: 1.0,
            };
        }
        let center = bounds.center();
        // Below this radius the coordinates have no digits left to tell rays apart.
        let smallest = (center.length() * 1e-4).max(1e-6);
        BoundingSphere {
            center,
            radius: (bounds.diagonal() * 0.5 * Self::SLACK).max(smallest),
        }
    }

    pub(super) fn cross_section(&self) -> f32 {
        PI * self.radius * self.radius
    }
}

#[derive(Clone, Debug)]
enum Kind {
    Directional { wi: Vec3, irradiance: Rgb },
    Constant { radiance: Rgb },
    Environment(EnvironmentSampler),
}

#[derive(Clone, Debug)]
struct Source {
    emitter: EmitterId,
    kind: Kind,
    /// Probability of being chosen for direct light.
    pmf: f32,
    /// Where photons are useful, once a pilot has found out.
    guide: Option<Guide>,
}

/// All emitters at infinity.
#[derive(Clone, Debug)]
pub(super) struct Distant {
    sources: Vec<Source>,
    sphere: BoundingSphere,
}

/// A direction to a distant emitter.
pub(super) struct DistantSample {
    pub(super) wi: Vec3,
    pub(super) emitter: EmitterId,
    /// Irradiance across `wi` over the probability of the choice, for parallel light; `None` for the others.
    pub(super) parallel: Option<Rgb>,
}

/// How often directions to constant surroundings ignore the receiver's normal: shading normals may look elsewhere.
const UNIFORM_SHARE: f32 = 0.1;

impl Distant {
    pub(super) fn new(emitters: &[Emitter], sphere: BoundingSphere) -> Self {
        let mut sources = Vec::new();
        for (i, emitter) in emitters.iter().enumerate() {
            let kind = match emitter {
                Emitter::Directional {
                    direction,
                    irradiance,
                } => Kind::Directional {
                    wi: -direction.normalize_or_zero(),
                    irradiance: *irradiance,
                },
                Emitter::Constant { radiance } => Kind::Constant {
                    radiance: *radiance,
                },
                Emitter::Environment(environment) => match EnvironmentSampler::new(environment) {
                    Some(sampler) => Kind::Environment(sampler),
                    None => continue,
                },
                Emitter::Area { .. } | Emitter::Point { .. } | Emitter::Spot { .. } => continue,
            };
            let strength = kind.total().strength();
            if strength > 0.0 {
                sources.push(Source {
                    emitter: EmitterId::from(i),
                    kind,
                    pmf: strength,
                    guide: None,
                });
            }
        }
        let sum: f32 = sources.iter().map(|s| s.pmf).sum();
        for source in &mut sources {
            source.pmf /= sum;
        }
        Distant { sources, sphere }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    pub(super) fn sphere(&self) -> &BoundingSphere {
        &self.sphere
    }

    /// Emitters and their flux through the bounding sphere.
    pub(super) fn powers(&self) -> impl Iterator<Item = (EmitterId, Rgb)> + '_ {
        self.sources
            .iter()
            .map(|s| (s.emitter, s.kind.total() * self.sphere.cross_section()))
    }

    /// A direction for direct light at a receiver with normal `n`.
    pub(super) fn sample(
        &self,
        emitters: &[Emitter],
        n: Option<Vec3>,
        u_choice: f32,
        u: Vec2,
    ) -> DistantSample {
        let (source, u_left) = self.choose(u_choice);
        let emitter = source.emitter;
        let wi = match &source.kind {
            Kind::Directional { wi, irradiance } => {
                return DistantSample {
                    wi: *wi,
                    emitter,
                    parallel: Some(*irradiance / source.pmf),
                };
            }
            Kind::Constant { .. } => match n {
                Some(n) if !split(u_left, UNIFORM_SHARE).0 => Frame::from_normal(n)
                    .to_world(warp::cosine_hemisphere(u))
                    .normalize(),
                _ => warp::sphere(u),
            },
            Kind::Environment(sampler) => sampler.sample(environment(emitters, emitter), u),
        };
        DistantSample {
            wi,
            emitter,
            parallel: None,
        }
    }

    /// Density of [`Distant::sample`] over all emitters that fill a solid angle.
    pub(super) fn pdf(&self, emitters: &[Emitter], n: Option<Vec3>, wi: Vec3) -> f32 {
        let density = |source: &Source| match &source.kind {
            Kind::Directional { .. } => 0.0,
            Kind::Constant { .. } => match n {
                Some(n) => {
                    let cosine = warp::cosine_hemisphere_pdf(n.dot(wi));
                    UNIFORM_SHARE * warp::SPHERE_PDF + (1.0 - UNIFORM_SHARE) * cosine
                }
                None => warp::SPHERE_PDF,
            },
            Kind::Environment(sampler) => sampler.pdf(environment(emitters, source.emitter), wi),
        };
        self.sources.iter().map(|s| s.pmf * density(s)).sum()
    }

    /// Radiance of all emitters that fill a solid angle.
    pub(super) fn radiance(&self, emitters: &[Emitter], wi: Vec3) -> Rgb {
        let radiance = |source: &Source| match &source.kind {
            Kind::Directional { .. } => Rgb::BLACK,
            Kind::Constant { radiance } => *radiance,
            Kind::Environment(_) => environment(emitters, source.emitter).radiance(wi),
        };
        self.sources.iter().map(radiance).sum()
    }

    /// Whether any emitter fills a solid angle.
    pub(super) fn fills_directions(&self) -> bool {
        self.sources
            .iter()
            .any(|s| !matches!(s.kind, Kind::Directional { .. }))
    }

    /// A ray of light from `emitter` into the bounding sphere, and its flux.
    pub(super) fn emit(
        &self,
        emitters: &[Emitter],
        emitter: EmitterId,
        u: EmissionPoint,
    ) -> Option<(Ray, Rgb)> {
        let source = self.sources.iter().find(|s| s.emitter == emitter)?;
        let point = [u.direction.x, u.direction.y, u.position.x, u.position.y];
        let (point, density) = match &source.guide {
            Some(guide) => guide.sample(u.guide, point),
            None => (point, 1.0),
        };
        let [x, y, across_x, across_y] = point;
        let (wi, irradiance) = source.direction(emitters, Vec2::new(x, y))?;
        let BoundingSphere { center, radius } = self.sphere;
        let across = warp::disc(Vec2::new(across_x, across_y)).extend(1.0) * radius;
        let o = center + Frame::from_normal(wi).to_world(across);
        Some((
            Ray::new(o, -wi),
            irradiance * (self.sphere.cross_section() / density),
        ))
    }

    /// For each source: what light arrives at `p` across the normal `n` from the direction that `u` names, if the ray to it
    /// is free. Numbered as the guides of [`Distant::set_guides`].
    pub(super) fn lessons(
        &self,
        emitters: &[Emitter],
        (p, n): (Vec3, Vec3),
        mut u: impl FnMut() -> Vec2,
        is_free: impl Fn(Vec3) -> bool,
    ) -> Vec<(usize, Lesson)> {
        let lesson = |(index, source): (usize, &Source)| {
            let u_direction = u();
            let (wi, irradiance) = source.direction(emitters, u_direction)?;
            let weight = irradiance.strength() * n.dot(wi);
            if weight <= 0.0 || !is_free(wi) {
                return None;
            }
            let across =
                Frame::from_normal(wi).to_local(p - self.sphere.center) / self.sphere.radius;
            let across = square_from_disc(across.truncate());
            let at: Point4 = [u_direction.x, u_direction.y, across.x, across.y];
            Some((index, Lesson { at, weight }))
        };
        self.sources.iter().enumerate().filter_map(lesson).collect()
    }

    /// Teaches the emission of photons. `lessons` are numbered by source.
    pub(super) fn set_guides(&mut self, lessons: &[(usize, Lesson)]) {
        for (index, source) in self.sources.iter_mut().enumerate() {
            let mut own: Vec<Lesson> = lessons
                .iter()
                .filter(|l| l.0 == index)
                .map(|l| l.1)
                .collect();
            source.guide = Guide::learn(&mut own);
        }
    }

    /// Emitters and by how much the guide concentrates their photons.
    pub(super) fn gains(&self) -> impl Iterator<Item = (EmitterId, f32)> + '_ {
        self.sources
            .iter()
            .map(|s| (s.emitter, s.guide.as_ref().map_or(1.0, Guide::gain)))
    }

    fn choose(&self, u: f32) -> (&Source, f32) {
        let mut below = 0.0;
        for source in &self.sources {
            if u < below + source.pmf {
                return (
                    source,
                    ((u - below) / source.pmf).clamp(0.0, 1.0 - f32::EPSILON),
                );
            }
            below += source.pmf;
        }
        // Rounding alone leads here.
        (&self.sources[self.sources.len() - 1], 0.5)
    }
}

/// The numbers that place a ray of distant light.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmissionPoint {
    pub(super) position: Vec2,
    pub(super) direction: Vec2,
    /// Decides whether the guide is asked.
    pub(super) guide: f32,
}

impl Source {
    /// The direction that `u` names, distributed like the light, and the irradiance across it: radiance over pdf.
    fn direction(&self, emitters: &[Emitter], u: Vec2) -> Option<(Vec3, Rgb)> {
        match &self.kind {
            Kind::Directional { wi, irradiance } => Some((*wi, *irradiance)),
            Kind::Constant { radiance } => Some((warp::sphere(u), *radiance / warp::SPHERE_PDF)),
            Kind::Environment(sampler) => {
                let environment = environment(emitters, self.emitter);
                let wi = sampler.sample(environment, u);
                let pdf = sampler.pdf(environment, wi);
                (pdf > 0.0).then(|| (wi, environment.radiance(wi) / pdf))
            }
        }
    }
}

/// The inverse of [`warp::disc`]; points outside the disc go to the border of the square.
fn square_from_disc(d: Vec2) -> Vec2 {
    let r = d.length().min(1.0);
    let p = if d.x.abs() > d.y.abs() {
        let x = r.copysign(d.x);
        Vec2::new(x, x * (d.y / d.x).atan() / FRAC_PI_4)
    } else if d.y != 0.0 {
        let y = r.copysign(d.y);
        Vec2::new(y * (d.x / d.y).atan() / FRAC_PI_4, y)
    } else {
        Vec2::ZERO
    };
    ((p + Vec2::ONE) * 0.5).clamp(Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON))
}

impl Kind {
    /// Irradiance of parallel light; radiance over all directions of the others.
    fn total(&self) -> Rgb {
        match self {
            Kind::Directional { irradiance, .. } => *irradiance,
            Kind::Constant { radiance } => *radiance * (4.0 * PI),
            Kind::Environment(sampler) => sampler.total(),
        }
    }
}

fn environment(emitters: &[Emitter], id: EmitterId) -> &super::Environment {
    match &emitters[id.index()] {
        Emitter::Environment(environment) => environment,
        other => unreachable!("invariant: samplers are made for environments, not for {other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_to_the_disc_inverts() {
        for i in 0..400 {
            let u = Vec2::new((i % 20) as f32 + 0.3, (i / 20) as f32 + 0.6) / 20.0;
            assert!((square_from_disc(warp::disc(u)) - u).length() < 1e-5, "{u}");
        }
        assert_eq!(square_from_disc(Vec2::ZERO), Vec2::splat(0.5));
    }
}
