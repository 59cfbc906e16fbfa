//! What the scene file declares as sources of light ("light" is reserved for virtual lights).
//!
//! An emitter answers three questions: a photon leaves ([`Emitters::sample_emission`]), it is seen from a point
//! ([`Emitters::sample_direct`]), a ray hits it ([`Emitters::radiance`], [`Emitters::environment`]).

mod description;
mod distant;
pub mod environment;
mod environment_tiles;
mod flat;
mod guide;
mod light_tree;
mod part_list;
mod parts;
mod pilot;
mod point;
mod strength;
#[cfg(test)]
mod tests;
mod warp_within;

pub use description::{Emitter, ProjectorTexture};
pub use environment::Environment;

use crate::color::Rgb;
use crate::geometry::{Geometry, Ray, SurfacePoint};
use crate::ids::{EmitterId, PrimitiveId};
use crate::image::Image;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::alias::Alias;
use crate::sampling::warp;
use crate::texture::{ColorInput, Texture};
pub use distant::InfiniteLightPlan;
use distant::{Arrival, BoundingSphere, Distant, EmissionPoint, Guides};
use light_tree::LightTree;
use part_list::PartList;
use parts::Form;
use pilot::Pilot;
use point::cone_direction;
use rayon::prelude::*;
use std::f32::consts::PI;
use strength::Strength;
use warp_within::split;

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
pub enum EmitterPlan {
    /// An emitter at some place in the scene.
    Local {
        /// Chooses it.
        u_choice: f32,
        /// Chooses a point on it.
        u: Vec2,
    },
    /// An emitter at infinity.
    Distant(InfiniteLightPlan),
}

/// All emitters of a scene, with what is needed to choose among 10^5 of them.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    powers: Vec<Rgb>,
    /// Chooses an emitter for a photon, by power.
    emission: Option<Alias>,
    parts: PartList,
    /// Chooses a part for direct light.
    tree: LightTree,
    distant: Distant,
    /// Probability that direct light asks the distant emitters.
    distant_share: f32,
}

/// Densities for the emission of photons that are concentrated on the part of the scene that the camera sees.
/// A guide changes densities only: the expected value of every estimate stays the same.
/// The default guide is unguided emission: emitters are chosen by power.
#[derive(Debug, Default)]
pub struct EmissionGuide(Option<GuidedEmission>);

#[derive(Debug)]
struct GuidedEmission {
    /// Densities over the emission of each infinite light.
    guides: Guides,
    /// Replaces [`Emitters::emission`]. Infinite lights are chosen in proportion to power over gain, because a guided photon
    /// carries less flux by the gain.
    choice: Option<Alias>,
}

/// Where local and distant emitters compete, each gets at least this share.
const LEAST_SHARE: f32 = 0.25;

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
        let (parts, bounds) = PartList::collect(&emitters, geometry, textures);
        let mut powers = parts.powers(&bounds);
        let local = total_strength(&powers);
        for (id, power) in distant.powers() {
            powers[id.index()] = power;
        }
        let far = total_strength(&powers) - local;
        let tree = LightTree::new(&bounds);
        let distant_share = distant_share(
            (!tree.is_empty()).then_some(local),
            (!distant.is_empty()).then_some(far),
        );
        let strengths: Vec<f32> = powers.iter().map(|p| p.strength()).collect();
        Emitters {
            powers,
            emission: Alias::new(&strengths),
            parts,
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

    /// Starts a photon: chooses an emitter by power (see [`EmissionGuide`]), then a position and a direction.
    /// `None` if the sample has no flux.
    pub fn sample_emission(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        guide: &EmissionGuide,
        u: EmissionNumbers,
    ) -> Option<EmissionSample> {
        let guided = guide.0.as_ref();
        let choice = guided.map_or(&self.emission, |guided| &guided.choice);
        let (index, pmf) = choice.as_ref()?.sample(u.emitter);
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
                let flux = spot.point_intensity(textures, w) / warp::cone_pdf(cutoff.cos());
                (Ray::new(*position, w), flux, None)
            }
            Emitter::Directional { .. } | Emitter::Constant { .. } | Emitter::Environment(_) => {
                let point = EmissionPoint {
                    position: u.position,
                    direction: u.direction,
                    guide: u.part,
                };
                let (ray, flux) = self
                    .distant
                    .emit(emitter, guided.map(|g| &g.guides), point)?;
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

    /// A guide for the photons of infinite lights, made by a guiding pre-pass: diffuse walks start along the camera's `rays` and
    /// sample the infinite lights at each of their vertices. Unguided, few photons of the sun or sky reach an interior
    /// through its windows. The walks pass through the surfaces for which `see_through` is true: glass in windows.
    ///
    /// The same rays give the same guide. Without infinite lights the guide is the default one, and `rays` is not called.
    pub fn emission_guide(
        &self,
        geometry: &Geometry,
        rays: impl FnOnce() -> Vec<Ray>,
        see_through: impl Fn(PrimitiveId) -> bool + Sync,
    ) -> EmissionGuide {
        if self.distant.is_empty() {
            return EmissionGuide::default();
        }
        let pilot = Pilot {
            geometry,
            distant: &self.distant,
            see_through: &see_through,
        };
        let walks = rays()
            .into_par_iter()
            .enumerate()
            .map(|(i, ray)| pilot.walk(ray, i as u64));
        let arrivals: Vec<Arrival> = walks.collect::<Vec<_>>().into_iter().flatten().collect();
        let guides = self.distant.guides(&arrivals);
        let mut strengths: Vec<f32> = self.powers.iter().map(|p| p.strength()).collect();
        for (emitter, gain) in self.distant.gains(&guides) {
            strengths[emitter.index()] /= gain;
        }
        let choice = Alias::new(&strengths);
        EmissionGuide(Some(GuidedEmission { guides, choice }))
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
        let (part, pmf) = self.parts.choose(emitter, u.part)?;
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
        self.sample(geometry, textures, p, n, &self.plan(u_choice, u))
    }

    /// The first half of [`Emitters::sample_direct`]: what the numbers decide by themselves. Asks for the memory that the second
    /// half will read.
    #[inline]
    pub fn plan(&self, u_choice: f32, u: Vec2) -> EmitterPlan {
        let (is_distant, u_choice) = split(u_choice, self.distant_share);
        if is_distant {
            EmitterPlan::Distant(self.distant.plan(u_choice, u))
        } else {
            EmitterPlan::Local { u_choice, u }
        }
    }

    /// Takes a plan one step on: asks for memory that the next step, or [`Emitters::sample`], will read. After three steps
    /// pictures have nothing left to do. Optional.
    #[inline]
    pub fn prefetch_step(&self, plan: &mut EmitterPlan) {
        if let EmitterPlan::Distant(plan) = plan {
            self.distant.refine(plan);
        }
    }

    /// The second half of [`Emitters::sample_direct`].
    pub fn sample(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        p: Vec3,
        n: Option<Vec3>,
        plan: &EmitterPlan,
    ) -> Option<DirectSample> {
        let (u_choice, u) = match plan {
            EmitterPlan::Distant(plan) => return self.sample_distant(p, n, plan),
            EmitterPlan::Local { u_choice, u } => (*u_choice, *u),
        };
        let (index, pmf) = self.tree.sample(p, n, u_choice)?;
        let part = self.parts.part(index);
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
                let weight = point.point_intensity(textures, -wi) / (d.length_squared() * pmf);
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

    fn sample_distant(
        &self,
        p: Vec3,
        n: Option<Vec3>,
        plan: &InfiniteLightPlan,
    ) -> Option<DirectSample> {
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
    pub fn pdf_direct(&self, p: Vec3, n: Option<Vec3>, y: &SurfacePoint) -> f32 {
        let Some(index) = self.parts.index_at(y.at) else {
            return 0.0;
        };
        let pmf = self.tree.pmf(p, n, index) * (1.0 - self.distant_share);
        if pmf > 0.0 {
            pmf * self.parts.part(index).pdf(p, y)
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
}

/// The share of distant emitters, by the strength of both where there are any.
fn distant_share(local: Option<f32>, distant: Option<f32>) -> f32 {
    match (local, distant) {
        (_, None) => 0.0,
        (None, Some(_)) => 1.0,
        (Some(local), Some(distant)) => {
            (distant / (distant + local)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        }
    }
}

fn total_strength(powers: &[Rgb]) -> f32 {
    powers.iter().map(|p| p.strength()).sum()
}
