//! Emitters at infinity: parallel light, constant radiance, pictures of the surroundings.

use super::environment::{EnvironmentSample, EnvironmentSampler};
use super::environment_tiles::Place;
use super::guide::{Guide, Lesson};
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
}

/// Where photons are useful: for each emitter at infinity, what a pilot has found out.
#[derive(Clone, Debug)]
pub(super) struct Guides(Vec<Option<LocalGuide>>);

/// A guide over directions and a disc of its own, across the sphere that holds what the pilot found lit.
#[derive(Clone, Debug)]
struct LocalGuide {
    guide: Guide,
    center: Vec3,
    radius: f32,
    /// Geometric mean of the density at what the pilot found, over that without a guide.
    gain: f32,
}

/// Light that the pilot saw arrive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    source: usize,
    u_direction: Vec2,
    wi: Vec3,
    p: Vec3,
    weight: f32,
}

/// How often photons are emitted without a guide: bounds the weight of those that the pilot has not foreseen.
const UNGUIDED_SHARE: f32 = 0.2;

/// The pilot looks in so many directions for light that comes from everywhere; most of them are blocked.
const DIRECTIONS_PER_POINT: usize = 8;

/// All emitters at infinity.
#[derive(Clone, Debug)]
pub(super) struct Distant {
    sources: Vec<Source>,
    sphere: BoundingSphere,
}

/// What the numbers of a direct sample decide about distant emitters.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLightPlan {
    source: usize,
    u_left: f32,
    aim: Aim,
}

/// Where in an emitter the numbers lead, as far as this is known.
#[derive(Clone, Copy, Debug)]
enum Aim {
    /// Still the numbers themselves.
    Numbers(Vec2),
    /// A row of tiles of a picture, and what is left of the numbers.
    Row(usize, Vec2),
    /// A tile.
    Tile(usize, Vec2),
    /// A cell, and a uniform point in it.
    Cell(Place),
    /// All that there is to know.
    Found(EnvironmentSample),
}

/// A direction to a distant emitter.
pub(super) struct DistantSample {
    pub(super) wi: Vec3,
    pub(super) emitter: EmitterId,
    /// Irradiance across `wi` over the probability of the choice, for parallel light; `None` for the others.
    pub(super) parallel: Option<Rgb>,
    /// Where one emitter is all that there is: what [`Distant::look_up`] gives.
    pub(super) known: Option<(Rgb, f32)>,
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

    /// The emitter that `u_choice` names, and what else the numbers decide before the receiver is known.
    #[inline]
    pub(super) fn plan(&self, u_choice: f32, u: Vec2) -> InfiniteLightPlan {
        let (source, u_left) = self.choose(u_choice);
        let aim = match &self.sources[source].kind {
            Kind::Environment(sampler) => Aim::Numbers(u).refined(sampler),
            _ => Aim::Numbers(u),
        };
        InfiniteLightPlan {
            source,
            u_left,
            aim,
        }
    }

    /// Takes a plan one step on, with memory that the step before has asked for.
    #[inline]
    pub(super) fn refine(&self, plan: &mut InfiniteLightPlan) {
        if let Kind::Environment(sampler) = &self.sources[plan.source].kind {
            plan.aim = plan.aim.refined(sampler);
        }
    }

    /// A direction for direct light at a receiver with normal `n`.
    pub(super) fn sample(&self, n: Option<Vec3>, plan: &InfiniteLightPlan) -> DistantSample {
        let source = &self.sources[plan.source];
        let emitter = source.emitter;
        let wi = match &source.kind {
            Kind::Directional { wi, irradiance } => {
                return DistantSample {
                    wi: *wi,
                    emitter,
                    parallel: Some(*irradiance / source.pmf),
                    known: None,
                };
            }
            Kind::Constant { .. } => match (n, plan.aim.numbers()) {
                (Some(n), u) if !split(plan.u_left, UNIFORM_SHARE).0 => Frame::from_normal(n)
                    .to_world(warp::cosine_hemisphere(u))
                    .normalize(),
                (_, u) => warp::sphere(u),
            },
            Kind::Environment(sampler) => {
                let sample = plan.aim.found(sampler);
                let alone = self.sources.len() == 1;
                return DistantSample {
                    wi: sample.wi,
                    emitter,
                    parallel: None,
                    known: alone.then_some((sample.radiance, sample.pdf)),
                };
            }
        };
        DistantSample {
            wi,
            emitter,
            parallel: None,
            known: None,
        }
    }

    /// Radiance from `wi` of all emitters that fill a solid angle, and the density of [`Distant::sample`] over them.
    #[inline]
    pub(super) fn look_up(&self, n: Option<Vec3>, wi: Vec3) -> (Rgb, f32) {
        let (mut radiance, mut pdf) = (Rgb::BLACK, 0.0);
        for source in &self.sources {
            let (l, density) = match &source.kind {
                Kind::Directional { .. } => continue,
                Kind::Constant { radiance } => (*radiance, constant_pdf(n, wi)),
                Kind::Environment(sampler) => {
                    let seen = sampler.look_up(wi);
                    (seen.radiance, seen.pdf)
                }
            };
            radiance += l;
            pdf += source.pmf * density;
        }
        (radiance, pdf)
    }

    /// Whether any emitter fills a solid angle.
    pub(super) fn fills_directions(&self) -> bool {
        self.sources.iter().any(Source::fills_directions)
    }

    /// A ray of light from `emitter` into the bounding sphere, and its flux.
    pub(super) fn emit(
        &self,
        emitter: EmitterId,
        guides: Option<&Guides>,
        u: EmissionPoint,
    ) -> Option<(Ray, Rgb)> {
        let index = self.sources.iter().position(|s| s.emitter == emitter)?;
        let source = &self.sources[index];
        let mut point = [u.direction.x, u.direction.y, u.position.x, u.position.y];
        let guide = guides.and_then(|guides| guides.0[index].as_ref());
        let guided = guide.filter(|_| !split(u.guide, UNGUIDED_SHARE).0);
        if let Some(local) = guided {
            point = local.guide.warp(point);
        }
        let [x, y, across_x, across_y] = point;
        let (wi, irradiance) = source.direction(Vec2::new(x, y))?;
        let frame = Frame::from_normal(wi);
        let disc = warp::disc(Vec2::new(across_x, across_y));
        let across = match guided {
            Some(local) => self.place_in(local, &frame) + disc * local.radius,
            None => disc * self.sphere.radius,
        };
        let density = guide.map_or(1.0, |local| {
            self.density(local, Vec2::new(x, y), &frame, across)
        });
        let o = self.sphere.center + frame.to_world(across.extend(self.sphere.radius));
        Some((
            Ray::new(o, -wi),
            irradiance * (self.sphere.cross_section() / density),
        ))
    }

    /// Density of emission with a guide over that without, at a place on the disc around the scene.
    fn density(&self, local: &LocalGuide, u_direction: Vec2, frame: &Frame, across: Vec2) -> f32 {
        let unguided = if across.length() <= self.sphere.radius {
            UNGUIDED_SHARE
        } else {
            0.0
        };
        let q = (across - self.place_in(local, frame)) / local.radius;
        // Rounding must not lose what the guide itself has placed on its rim.
        if q.length() > 1.0 + 1e-4 {
            return unguided;
        }
        let q = square_from_disc(q);
        let concentration = (self.sphere.radius / local.radius).powi(2);
        let guided = concentration
            * local
                .guide
                .density([u_direction.x, u_direction.y, q.x, q.y]);
        unguided + (1.0 - UNGUIDED_SHARE) * guided
    }

    /// Where the guide's sphere lies on the disc across the scene.
    fn place_in(&self, local: &LocalGuide, frame: &Frame) -> Vec2 {
        frame.to_local(local.center - self.sphere.center).truncate()
    }

    /// For each source, some directions: what light arrives at `p` across the normal `n`, if the way is free.
    pub(super) fn arrivals(
        &self,
        (p, n): (Vec3, Vec3),
        mut u: impl FnMut() -> Vec2,
        is_free: impl Fn(Vec3) -> bool,
    ) -> Vec<Arrival> {
        let mut arrivals = Vec::new();
        for (source, description) in self.sources.iter().enumerate() {
            let count = if matches!(description.kind, Kind::Directional { .. }) {
                1
            } else {
                DIRECTIONS_PER_POINT
            };
            for u_direction in (0..count).map(|_| u()) {
                let Some((wi, irradiance)) = description.direction(u_direction) else {
                    continue;
                };
                let weight = irradiance.strength() * n.dot(wi);
                if weight > 0.0 && is_free(wi) {
                    arrivals.push(Arrival {
                        source,
                        u_direction,
                        wi,
                        p,
                        weight,
                    });
                }
            }
        }
        arrivals
    }

    /// Where photons of each emitter are useful.
    pub(super) fn guides(&self, arrivals: &[Arrival]) -> Guides {
        let guide = |source: usize| {
            let own: Vec<&Arrival> = arrivals.iter().filter(|a| a.source == source).collect();
            self.learn(&own)
        };
        Guides((0..self.sources.len()).map(guide).collect())
    }

    fn learn(&self, arrivals: &[&Arrival]) -> Option<LocalGuide> {
        let center = Aabb::from_points(arrivals.iter().map(|a| a.p)).center();
        let farthest = arrivals
            .iter()
            .map(|a| (a.p - center).length())
            .fold(0.0, f32::max);
        // Places next to the outermost ones are useful as well.
        let radius = (1.1 * farthest).max(1e-3 * self.sphere.radius);
        let lesson = |a: &&Arrival| {
            let across = Frame::from_normal(a.wi).to_local(a.p - center) / radius;
            let across = square_from_disc(across.truncate());
            Lesson {
                at: [a.u_direction.x, a.u_direction.y, across.x, across.y],
                weight: a.weight,
            }
        };
        let mut lessons: Vec<Lesson> = arrivals.iter().map(lesson).collect();
        let mut local = LocalGuide {
            guide: Guide::learn(&mut lessons)?,
            center,
            radius,
            gain: 1.0,
        };
        let (mut log, mut total) = (0.0f64, 0.0f64);
        for a in arrivals {
            let frame = Frame::from_normal(a.wi);
            let across = frame.to_local(a.p - self.sphere.center).truncate();
            let density = self.density(&local, a.u_direction, &frame, across);
            log += f64::from(a.weight * density.ln());
            total += f64::from(a.weight);
        }
        local.gain = (log / total).exp() as f32;
        Some(local)
    }

    /// Emitters and by how much the guides concentrate their photons.
    pub(super) fn gains(&self, guides: &Guides) -> impl Iterator<Item = (EmitterId, f32)> {
        let gains = guides.0.iter().map(|g| g.as_ref().map_or(1.0, |g| g.gain));
        self.sources.iter().map(|s| s.emitter).zip(gains)
    }

    /// Index of a source, and what is left of `u`.
    #[inline]
    fn choose(&self, u: f32) -> (usize, f32) {
        let mut below = 0.0;
        for (i, source) in self.sources.iter().enumerate() {
            if u < below + source.pmf {
                return (i, ((u - below) / source.pmf).clamp(0.0, 1.0 - f32::EPSILON));
            }
            below += source.pmf;
        }
        // Rounding alone leads here.
        (self.sources.len() - 1, 0.5)
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
    fn fills_directions(&self) -> bool {
        !matches!(self.kind, Kind::Directional { .. })
    }

    /// The direction that `u` names, distributed like the light, and the irradiance across it: radiance over pdf.
    fn direction(&self, u: Vec2) -> Option<(Vec3, Rgb)> {
        match &self.kind {
            Kind::Directional { wi, irradiance } => Some((*wi, *irradiance)),
            Kind::Constant { radiance } => Some((warp::sphere(u), *radiance / warp::SPHERE_PDF)),
            Kind::Environment(sampler) => {
                let sample = sampler.sample(u);
                (sample.pdf > 0.0).then(|| (sample.wi, sample.radiance / sample.pdf))
            }
        }
    }
}

impl Aim {
    #[inline]
    fn refined(self, sampler: &EnvironmentSampler) -> Self {
        match self {
            Aim::Numbers(u) => {
                let (row, u) = sampler.tiles().choose_row(u);
                Aim::Row(row, u)
            }
            Aim::Row(row, u) => {
                let (tile, u) = sampler.tiles().choose_tile(row, u);
                Aim::Tile(tile, u)
            }
            Aim::Tile(tile, u) => Aim::Cell(sampler.tiles().choose_cell(tile, u)),
            Aim::Cell(place) => Aim::Found(sampler.sample_within(place)),
            Aim::Found(_) => self,
        }
    }

    /// The direction, whatever steps are left.
    #[inline]
    fn found(mut self, sampler: &EnvironmentSampler) -> EnvironmentSample {
        loop {
            match self {
                Aim::Found(sample) => return sample,
                _ => self = self.refined(sampler),
            }
        }
    }

    /// The numbers, for what is no picture.
    #[inline]
    fn numbers(self) -> Vec2 {
        match self {
            Aim::Numbers(u) => u,
            _ => unreachable!("invariant: only plans for pictures are refined"),
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

/// Density of directions to constant surroundings.
#[inline]
fn constant_pdf(n: Option<Vec3>, wi: Vec3) -> f32 {
    match n {
        Some(n) => {
            let cosine = warp::cosine_hemisphere_pdf(n.dot(wi));
            UNIFORM_SHARE * warp::SPHERE_PDF + (1.0 - UNIFORM_SHARE) * cosine
        }
        None => warp::SPHERE_PDF,
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
