//! What the scene file declares as sources of light ("light" is reserved for virtual lights).
//!
//! An emitter answers three questions: a photon leaves ([`Emitters::sample_emission`]), it is seen from a point
//! ([`Emitters::sample_direct`]), a ray hits it ([`Emitters::radiance`], [`Emitters::environment`]).

mod distant;
pub mod environment;
mod environment_tiles;
mod flat;
mod guide;
mod light_tree;
mod parts;
#[cfg(test)]
mod tests;
mod warp_within;

pub use environment::Environment;

use crate::color::Rgb;
use crate::geometry::{Geometry, Ray, SurfacePoint, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId, TextureId};
use crate::image::Image;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::alias::Alias;
use crate::sampling::{Sampler, Stream, warp};
use crate::texture::{ColorInput, Texture};
pub use distant::DistantPlan;
use distant::{Arrival, BoundingSphere, Distant, EmissionPoint};
use light_tree::LightTree;
use parts::{Form, Part, PartBounds};
use rayon::prelude::*;
use std::f32::consts::PI;
use warp_within::split;

/// A source of light. All directions and positions in world space.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A primitive that shines from the side of its shading normal.
    Area {
        /// W/(m² sr).
        radiance: ColorInput,
    },
    /// An isotropic point.
    Point {
        /// Where.
        position: Vec3,
        /// W/sr.
        intensity: Rgb,
    },
    /// A cone with a smooth rim.
    Spot {
        /// Where.
        position: Vec3,
        /// Unit axis.
        direction: Vec3,
        /// W/sr on the axis.
        intensity: Rgb,
        /// Half-angle of the rim in radians.
        cutoff: f32,
        /// Half-angle of the constant part in radians, <= `cutoff`.
        beam_width: f32,
        /// What colors the light.
        slide: Option<Slide>,
    },
    /// Parallel light through the whole scene.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// W/m² on a plane across it.
        irradiance: Rgb,
    },
    /// The same radiance from every direction.
    Constant {
        /// W/(m² sr).
        radiance: Rgb,
    },
    /// A picture of the surroundings.
    Environment(Environment),
}

/// A picture that a spot throws: its square is the one around the cone's cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// The picture.
    pub texture: TextureId,
    /// Unit directions across the axis along which u and v grow.
    pub axes: [Vec3; 2],
}

/// The numbers that start a photon.
#[derive(Clone, Copy, Debug)]
pub struct EmissionNumbers {
    /// Chooses the emitter.
    pub emitter: f32,
    /// Where on it (or across the scene for distant emitters).
    pub position: Vec2,
    /// Which way.
    pub direction: Vec2,
    /// Chooses among an emitter's parts.
    pub part: f32,
}

/// A photon at its start.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// Already moved off the emitter.
    pub ray: Ray,
    /// Emitted flux over the probability of this sample (choice of the emitter included), in W: the flux of one path
    /// before it is divided by the number of emitted paths.
    pub flux: Rgb,
    /// Which emitter.
    pub emitter: EmitterId,
    /// The point that emits, for surfaces; `None` for points and distant emitters. For splatting what the camera sees directly.
    pub surface: Option<SurfacePoint>,
}

/// A direction towards an emitter from a point.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction to the emitter.
    pub wi: Vec3,
    /// The point on the emitter, moved off its surface; far outside the scene for distant emitters. End of the shadow ray.
    pub target: Vec3,
    /// Radiance over pdf per solid angle (choice of the emitter included); for delta emitters the same limit: irradiance across `wi`.
    pub weight: Rgb,
    /// Per solid angle, choice of the emitter included; 0 for delta emitters, which BSDF sampling cannot find.
    pub pdf: f32,
    /// Which emitter.
    pub emitter: EmitterId,
}

/// A direct sample as far as its numbers alone decide about it.
#[derive(Clone, Copy, Debug)]
pub enum DirectPlan {
    /// An emitter at some place in the scene.
    Local {
        /// Chooses it.
        u_choice: f32,
        /// Chooses a point on it.
        u: Vec2,
    },
    /// An emitter at infinity.
    Distant(DistantPlan),
}

/// All emitters of a scene, with what is needed to choose among 10^5 of them.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    powers: Vec<Rgb>,
    /// Chooses an emitter for a photon, by power.
    emission: Option<Alias>,
    parts: Vec<Part>,
    /// Per emitter: its pieces.
    parts_of: Vec<Pieces>,
    /// Per primitive: where its elements' pieces are listed in `part_of_element`.
    elements_of: Vec<Option<Elements>>,
    part_of_element: Vec<u32>,
    tree: LightTree,
    distant: Distant,
    /// Probability that direct light asks the distant emitters.
    distant_share: f32,
}

/// The pieces of one emitter, for photons.
#[derive(Clone, Debug, Default)]
struct Pieces {
    parts: Vec<u32>,
    by_power: Option<Alias>,
}

/// The entries of one primitive: a single one if it is sampled as a whole.
#[derive(Clone, Copy, Debug)]
struct Elements {
    start: u32,
    count: u32,
}

/// No piece: a triangle without area.
const NO_PART: u32 = u32::MAX;

/// Directions along each axis of the grid from which the flux of a spot with a slide is estimated.
const SLIDE_GRID: usize = 32;

/// Where local and distant emitters compete for direct light, each gets at least this share.
const LEAST_SHARE: f32 = 0.25;

/// How much a color counts when emitters are chosen: positive for every color that is not black.
trait Strength {
    fn strength(self) -> f32;
}

impl Strength for Rgb {
    fn strength(self) -> f32 {
        // Luminance alone would make blue light rare and its samples bright.
        0.5 * (self.luminance() + self.max_channel()).max(0.0)
    }
}

impl Emitters {
    /// Prepares the choice. Area emitters are found through `geometry`'s primitives (one emitter may sit on several primitives;
    /// emitters inside instanced groups are refused by `Scene::build`).
    pub fn new(mut emitters: Vec<Emitter>, geometry: &Geometry, textures: &[Texture]) -> Self {
        let distant = Distant::new(&emitters, BoundingSphere::new(geometry.bounds()));
        for emitter in &mut emitters {
            if let Emitter::Environment(environment) = emitter {
                environment.image = Image::default();
            }
        }
        let pieces = PieceList::collect(&emitters, geometry, textures);
        let mut powers = pieces.powers(emitters.len());
        let local = total_strength(&powers);
        for (id, power) in distant.powers() {
            powers[id.index()] = power;
        }
        let far = total_strength(&powers) - local;
        let tree = LightTree::new(&pieces.bounds);
        let distant_share = match (tree.is_empty(), distant.is_empty()) {
            (_, true) => 0.0,
            (true, false) => 1.0,
            (false, false) => (far / (far + local)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE),
        };
        let strengths: Vec<f32> = powers.iter().map(|p| p.strength()).collect();
        Emitters {
            powers,
            emission: Alias::new(&strengths),
            parts_of: pieces.by_emitter(emitters.len()),
            parts: pieces.parts,
            elements_of: pieces.elements_of,
            part_of_element: pieces.part_of_element,
            tree,
            distant,
            distant_share,
            emitters,
        }
    }

    /// The descriptions; index by [`EmitterId`]. Pictures of surroundings are taken out, because they are kept in another form.
    pub fn descriptions(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Starts a photon: emitter by power, then position and direction. `None` if this sample carries nothing.
    pub fn sample_emission(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        u: EmissionNumbers,
    ) -> Option<EmissionSample> {
        let (index, pmf) = self.emission.as_ref()?.sample(u.emitter);
        let emitter = EmitterId::from(index);
        let (ray, flux, surface) = match &self.emitters[index] {
            Emitter::Area { radiance } => {
                self.emit_from_surface(geometry, textures, emitter, *radiance, u)?
            }
            Emitter::Point {
                position,
                intensity,
            } => (
                Ray::new(*position, warp::sphere(u.direction)),
                *intensity / warp::SPHERE_PDF,
                None,
            ),
            spot @ Emitter::Spot {
                position,
                direction,
                cutoff,
                ..
            } => {
                let w = cone_direction(*direction, *cutoff, u.direction);
                let flux = point_intensity(spot, textures, w) / warp::cone_pdf(cutoff.cos());
                (Ray::new(*position, w), flux, None)
            }
            Emitter::Directional { .. } | Emitter::Constant { .. } | Emitter::Environment(_) => {
                let point = EmissionPoint {
                    position: u.position,
                    direction: u.direction,
                    guide: u.part,
                };
                let (ray, flux) = self.distant.emit(emitter, point)?;
                (ray, flux, None)
            }
        };
        (!flux.is_black()).then_some(EmissionSample {
            ray,
            flux: flux / pmf,
            emitter,
            surface,
        })
    }

    /// Teaches the photons of distant emitters where they are useful: a pilot walks diffusely from `rays` (of the camera) and
    /// asks at each of its points for light from afar. Without it an interior gets few photons through its windows.
    /// `see_through` names surfaces that the pilot ignores: glass in windows.
    ///
    /// Changes only densities, never what is estimated; the same rays give the same guide. Without distant emitters, nothing happens.
    pub fn guide_emission(
        &mut self,
        geometry: &Geometry,
        rays: &[Ray],
        see_through: impl Fn(PrimitiveId) -> bool + Sync,
    ) {
        if self.distant.is_empty() {
            return;
        }
        let pilot = Pilot {
            geometry,
            distant: &self.distant,
            see_through: &see_through,
        };
        let walks = rays
            .par_iter()
            .enumerate()
            .map(|(i, ray)| pilot.walk(*ray, i as u64));
        let arrivals: Vec<Arrival> = walks.collect::<Vec<_>>().into_iter().flatten().collect();
        self.distant.set_guides(&arrivals);
        // A photon of a guided emitter carries less flux, so that fewer of them are as good.
        let mut strengths: Vec<f32> = self.powers.iter().map(|p| p.strength()).collect();
        for (emitter, gain) in self.distant.gains() {
            strengths[emitter.index()] /= gain;
        }
        self.emission = Alias::new(&strengths);
    }

    /// A photon from an area emitter, before the choice of the emitter is divided out.
    fn emit_from_surface(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        emitter: EmitterId,
        radiance: ColorInput,
        u: EmissionNumbers,
    ) -> Option<(Ray, Rgb, Option<SurfacePoint>)> {
        let pieces = &self.parts_of[emitter.index()];
        let (k, pmf) = pieces.by_power.as_ref()?.sample(u.part);
        let part = &self.parts[pieces.parts[k] as usize];
        let y = part.sample_area(geometry, u.position)?;
        let radiance = radiance.eval(y.uv, textures);
        if radiance.is_black() {
            return None;
        }
        // Light leaves on the side of the shading normal in proportion to the geometric cosine. Of each line through the
        // point just one direction is on that side, so turning a cosine-distributed one round samples this exactly.
        let w = Frame::from_normal(y.ng)
            .to_world(warp::cosine_hemisphere(u.direction))
            .normalize();
        let w = if y.frame.n.dot(w) >= 0.0 { w } else { -w };
        let flux = radiance * (PI / (part.pdf_area(&y) * pmf));
        Some((y.spawn(w), flux, Some(y)))
    }

    /// Chooses an emitter for the receiving point `p` with geometric normal `n` (`None`: all directions matter),
    /// by a light tree over position, orientation and power, then a point on it.
    /// `None` if nothing arrives (the emitter's back side, zero radiance). No visibility. Directions below `n` are rare but
    /// possible: shading normals may see them.
    pub fn sample_direct(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        p: Vec3,
        n: Option<Vec3>,
        u_choice: f32,
        u: Vec2,
    ) -> Option<DirectSample> {
        self.sample_planned(geometry, textures, p, n, &self.plan_direct(u_choice, u))
    }

    /// The first half of [`Emitters::sample_direct`]: what the numbers decide by themselves. Asks for the memory that the second
    /// half will read.
    #[inline]
    pub fn plan_direct(&self, u_choice: f32, u: Vec2) -> DirectPlan {
        let (is_distant, u_choice) = split(u_choice, self.distant_share);
        if is_distant {
            DirectPlan::Distant(self.distant.plan(u_choice, u))
        } else {
            DirectPlan::Local { u_choice, u }
        }
    }

    /// The second half of [`Emitters::sample_direct`].
    pub fn sample_planned(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        p: Vec3,
        n: Option<Vec3>,
        plan: &DirectPlan,
    ) -> Option<DirectSample> {
        let (u_choice, u) = match plan {
            DirectPlan::Distant(plan) => return self.sample_distant(p, n, plan),
            DirectPlan::Local { u_choice, u } => (*u_choice, *u),
        };
        let (index, pmf) = self.tree.sample(p, n, u_choice)?;
        let part = &self.parts[index];
        let pmf = pmf * (1.0 - self.distant_share);
        let emitter = part.emitter;
        match &self.emitters[emitter.index()] {
            Emitter::Area { radiance } => {
                let seen = part.sample(geometry, textures, *radiance, p, u)?;
                let pdf = seen.pdf * pmf;
                let weight = seen.radiance / pdf;
                Some(DirectSample {
                    wi: seen.wi,
                    target: seen.target,
                    weight,
                    pdf,
                    emitter,
                })
            }
            point => {
                let Form::Point { position } = part.form else {
                    return None;
                };
                let d = position - p;
                let wi = d.try_normalize()?;
                let weight = point_intensity(point, textures, -wi) / (d.length_squared() * pmf);
                let seen = DirectSample {
                    wi,
                    target: position,
                    weight,
                    pdf: 0.0,
                    emitter,
                };
                (!weight.is_black() && weight.is_finite()).then_some(seen)
            }
        }
    }

    fn sample_distant(&self, p: Vec3, n: Option<Vec3>, plan: &DistantPlan) -> Option<DirectSample> {
        let sample = self.distant.sample(n, plan);
        let (weight, pdf) = match sample.parallel {
            Some(irradiance) => (irradiance / self.distant_share, 0.0),
            None => {
                let (radiance, pdf) = sample
                    .known
                    .unwrap_or_else(|| self.distant.look_up(n, sample.wi));
                let pdf = self.distant_share * pdf;
                (radiance / pdf, pdf)
            }
        };
        if weight.is_black() || !weight.is_finite() {
            return None;
        }
        let sphere = self.distant.sphere();
        let far = (p - sphere.center).length() + 2.0 * sphere.radius;
        Some(DirectSample {
            wi: sample.wi,
            target: p + sample.wi * far,
            weight,
            pdf,
            emitter: sample.emitter,
        })
    }

    /// Density per solid angle with which [`Emitters::sample_direct`] at (`p`, `n`) finds the point `y` of an area emitter.
    pub fn pdf_direct(
        &self,
        _geometry: &Geometry,
        p: Vec3,
        n: Option<Vec3>,
        y: &SurfacePoint,
    ) -> f32 {
        let Some(index) = self.part_at(y.at) else {
            return 0.0;
        };
        let pmf = self.tree.pmf(p, n, index) * (1.0 - self.distant_share);
        if pmf > 0.0 {
            pmf * self.parts[index].pdf(p, y)
        } else {
            0.0
        }
    }

    /// Radiance that the surface emits at `x` towards `wo`; black for surfaces that do not emit.
    pub fn radiance(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        x: &SurfacePoint,
        wo: Vec3,
    ) -> Rgb {
        let Some(id) = geometry.primitives()[x.at.primitive.index()].emitter else {
            return Rgb::BLACK;
        };
        match self.emitters.get(id.index()) {
            Some(Emitter::Area { radiance }) if x.frame.n.dot(wo) > 0.0 => {
                radiance.eval(x.uv, textures)
            }
            _ => Rgb::BLACK,
        }
    }

    /// Radiance that arrives from the surroundings along unit `wi` (pointing away from the scene), and the density per solid angle
    /// with which [`Emitters::sample_direct`] at a receiver with normal `n` finds that direction.
    #[inline]
    pub fn environment(&self, n: Option<Vec3>, wi: Vec3) -> (Rgb, f32) {
        let (radiance, pdf) = self.distant.look_up(n, wi);
        (radiance, self.distant_share * pdf)
    }

    /// Whether there are surroundings at all.
    pub fn has_environment(&self) -> bool {
        self.distant.fills_directions()
    }

    /// Flux of one emitter into the scene in W (an estimate for distant emitters: irradiance times the scene's cross-section;
    /// for textured surfaces: from a grid of points).
    pub fn power(&self, id: EmitterId) -> Rgb {
        self.powers[id.index()]
    }

    fn part_at(&self, at: SurfaceRef) -> Option<usize> {
        let elements = self
            .elements_of
            .get(at.primitive.index())
            .copied()
            .flatten()?;
        // A primitive that is sampled as a whole has one entry for all its elements.
        let element = if elements.count == 1 { 0 } else { at.element };
        let part = (element < elements.count)
            .then(|| self.part_of_element[(elements.start + element) as usize])?;
        (part != NO_PART).then_some(part as usize)
    }
}

/// Finds out where light from afar gets in.
struct Pilot<'a, F> {
    geometry: &'a Geometry,
    distant: &'a Distant,
    see_through: &'a F,
}

/// Surfaces at which a walk of the pilot asks for light.
const PILOT_BOUNCES: usize = 4;

/// See-through surfaces that the pilot crosses at most on one ray.
const PILOT_CROSSINGS: usize = 8;

impl<F: Fn(PrimitiveId) -> bool> Pilot<'_, F> {
    fn walk(&self, mut ray: Ray, index: u64) -> Vec<Arrival> {
        let mut sampler = Sampler::new(0, 0, Stream::Pass, index);
        let mut arrivals = Vec::new();
        for _ in 0..PILOT_BOUNCES {
            let Some(x) = self.nearest(ray) else { break };
            let n = if x.ng.dot(ray.d) < 0.0 { x.ng } else { -x.ng };
            let is_free = |wi: Vec3| self.nearest(x.spawn(wi)).is_none();
            arrivals.extend(
                self.distant
                    .arrivals((x.p, n), || sampler.next_2d(), is_free),
            );
            let w = Frame::from_normal(n)
                .to_world(warp::cosine_hemisphere(sampler.next_2d()))
                .normalize();
            ray = x.spawn(w);
        }
        arrivals
    }

    /// The nearest surface that is not ignored.
    fn nearest(&self, mut ray: Ray) -> Option<SurfacePoint> {
        for _ in 0..PILOT_CROSSINGS {
            let x = self
                .geometry
                .surface_point(self.geometry.intersect(&ray)?.at);
            if !(self.see_through)(x.at.primitive) {
                return Some(x);
            }
            ray = x.spawn(ray.d);
        }
        None
    }
}

/// Pieces while they are collected.
struct PieceList {
    parts: Vec<Part>,
    bounds: Vec<PartBounds>,
    elements_of: Vec<Option<Elements>>,
    part_of_element: Vec<u32>,
}

impl PieceList {
    fn collect(emitters: &[Emitter], geometry: &Geometry, textures: &[Texture]) -> Self {
        let mut list = PieceList {
            parts: Vec::new(),
            bounds: Vec::new(),
            elements_of: vec![None; geometry.primitives().len()],
            part_of_element: Vec::new(),
        };
        for (i, primitive) in geometry.primitives().iter().enumerate() {
            let Some(id) = primitive.emitter else {
                continue;
            };
            if let Some(Emitter::Area { radiance }) = emitters.get(id.index()) {
                list.add_primitive(geometry, textures, PrimitiveId::from(i), id, *radiance);
            }
        }
        for (i, emitter) in emitters.iter().enumerate() {
            let part =
                parts::part_of_point(EmitterId::from(i), emitter, point_power(emitter, textures));
            list.add(part.into_iter());
        }
        list
    }

    /// Flux of each emitter.
    fn powers(&self, emitters: usize) -> Vec<Rgb> {
        let mut powers = vec![Rgb::BLACK; emitters];
        for (part, known) in self.parts.iter().zip(&self.bounds) {
            powers[part.emitter.index()] += known.power;
        }
        powers
    }

    fn by_emitter(&self, emitters: usize) -> Vec<Pieces> {
        let mut lists = vec![Vec::new(); emitters];
        for (i, part) in self.parts.iter().enumerate() {
            lists[part.emitter.index()].push(i as u32);
        }
        let strength = |i: &u32| self.bounds[*i as usize].power.strength();
        let pieces = |parts: Vec<u32>| {
            let strengths: Vec<f32> = parts.iter().map(strength).collect();
            Pieces {
                by_power: Alias::new(&strengths),
                parts,
            }
        };
        lists.into_iter().map(pieces).collect()
    }

    fn add(&mut self, pieces: impl Iterator<Item = (Part, PartBounds)>) {
        for (part, bounds) in pieces {
            self.parts.push(part);
            self.bounds.push(bounds);
        }
    }

    fn add_primitive(
        &mut self,
        geometry: &Geometry,
        textures: &[Texture],
        primitive: PrimitiveId,
        emitter: EmitterId,
        radiance: ColorInput,
    ) {
        let pieces = parts::parts_of_primitive(geometry, textures, primitive, emitter, radiance);
        let Some(last) = pieces.last() else { return };
        let (start, count) = (self.part_of_element.len() as u32, last.0 + 1);
        self.part_of_element
            .resize((start + count) as usize, NO_PART);
        for (k, (element, ..)) in pieces.iter().enumerate() {
            self.part_of_element[(start + element) as usize] = (self.parts.len() + k) as u32;
        }
        self.elements_of[primitive.index()] = Some(Elements { start, count });
        self.add(pieces.into_iter().map(|(_, part, bounds)| (part, bounds)));
    }
}

fn total_strength(powers: &[Rgb]) -> f32 {
    powers.iter().map(|p| p.strength()).sum()
}

/// Flux of a point or spot; black for others.
fn point_power(emitter: &Emitter, textures: &[Texture]) -> Rgb {
    match *emitter {
        Emitter::Point { intensity, .. } => intensity * (4.0 * PI),
        Emitter::Spot {
            direction,
            intensity,
            cutoff,
            slide: Some(slide),
            ..
        } => {
            let count = (SLIDE_GRID * SLIDE_GRID) as f32;
            let grid = (0..SLIDE_GRID * SLIDE_GRID)
                .map(|i| Vec2::new((i % SLIDE_GRID) as f32, (i / SLIDE_GRID) as f32))
                .map(|cell| (cell + 0.5) / SLIDE_GRID as f32);
            let sum: Rgb = grid
                .map(|u| cone_direction(direction, cutoff, u))
                .map(|w| point_intensity(emitter, textures, w))
                .sum();
            let brightest = textures[slide.texture.index()].max_luminance(textures);
            let floor = intensity * (brightest * parts::RADIANCE_FLOOR);
            (sum / count).zip(floor, f32::max) / warp::cone_pdf(cutoff.cos())
        }
        // ∫ falloff sinθ dθ, with the falloff linear in the angle beyond the beam.
        Emitter::Spot {
            intensity,
            cutoff,
            beam_width,
            ..
        } => {
            let rim = cutoff - beam_width;
            let mean_cos = if rim > 1e-4 {
                (cutoff.sin() - beam_width.sin()) / rim
            } else {
                cutoff.cos()
            };
            intensity * (2.0 * PI * (1.0 - mean_cos))
        }
        _ => Rgb::BLACK,
    }
}

/// Intensity of a point or spot towards the unit direction `w`; black for others.
fn point_intensity(emitter: &Emitter, textures: &[Texture], w: Vec3) -> Rgb {
    match *emitter {
        Emitter::Point { intensity, .. } => intensity,
        Emitter::Spot {
            direction,
            intensity,
            cutoff,
            beam_width,
            slide,
            ..
        } => {
            let falloff = intensity * spot_falloff(direction.dot(w), cutoff, beam_width);
            match slide {
                Some(slide) if !falloff.is_black() => {
                    let across = Vec2::from(slide.axes.map(|axis| axis.dot(w)));
                    let uv = 0.5 + 0.5 * across / (direction.dot(w) * cutoff.tan());
                    falloff * textures[slide.texture.index()].eval(uv, textures)
                }
                _ => falloff,
            }
        }
        _ => Rgb::BLACK,
    }
}

/// A direction within a cone, uniformly distributed.
fn cone_direction(axis: Vec3, cutoff: f32, u: Vec2) -> Vec3 {
    let local = warp::cone(u, cutoff.cos());
    Frame::from_normal(axis).to_world(local).normalize()
}

/// As Mitsuba's `spot`: 1 up to the beam, then linear in the angle, 0 from the cutoff on.
fn spot_falloff(cos: f32, cutoff: f32, beam_width: f32) -> f32 {
    let angle = cos.clamp(-1.0, 1.0).acos();
    if angle <= beam_width {
        1.0
    } else if angle >= cutoff {
        0.0
    } else {
        (cutoff - angle) / (cutoff - beam_width)
    }
}
