//! Emission of photons.

use super::Emitters;
use super::description::Emitter;
use super::infinite::{GuidingPrepass, InfiniteEmissionNumbers, InfiniteLightGuides};
use super::point::spot_direction;
use crate::color::Rgb;
use crate::geometry::{Geometry, Ray, SurfacePoint};
use crate::ids::{EmitterId, PrimitiveId};
use crate::math::{Frame, Vec2};
use crate::sampling::alias::Alias;
use crate::sampling::warp;
use crate::texture::{ColorInput, Texture};
use std::f32::consts::PI;

/// The random numbers of the emission of one photon, each in [0, 1).
#[derive(Clone, Copy, Debug)]
pub struct EmissionNumbers {
    /// Choice of the emitter.
    pub emitter: f32,
    /// Position on the emitter; for infinite lights on the disc through which their rays enter the
    /// scene.
    pub position: Vec2,
    /// Direction.
    pub direction: Vec2,
    /// Choice of the element of an area emitter; for infinite lights choice between guided and
    /// unguided emission.
    pub element: f32,
}

/// An emitted photon.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// The photon's ray; the origin is moved off the emitter's surface.
    pub ray: Ray,
    /// Emitted flux over the probability density of the sample (including the choice of the
    /// emitter), in W. Divided by the number of emitted photons it is the flux of the photon.
    pub flux: Rgb,
    /// The emitter.
    pub emitter: EmitterId,
    /// The emitting point of an area emitter; `None` for points, spots and infinite lights. Light
    /// tracing connects it to the camera.
    pub surface: Option<SurfacePoint>,
}

/// Densities for the emission of photons by infinite lights that are concentrated on the visible
/// part of the scene. A guide changes densities only: the expected value of every estimate stays
/// the same.
///
/// The default guide is unguided emission.
#[derive(Debug, Default)]
pub struct EmissionGuide(Option<GuidedEmission>);

#[derive(Debug)]
struct GuidedEmission {
    guides: InfiniteLightGuides,
    /// Choice of an emitter. Infinite lights are chosen in proportion to power over gain of their
    /// guide: guided photons have less flux by that factor.
    choice: Option<Alias>,
}

impl EmissionGuide {
    /// A guide for the photons of infinite lights, made by a guiding pre-pass: diffuse walks start
    /// along the camera's `rays` and sample the infinite lights at each of their vertices. Without
    /// a guide, few photons of the sun or sky reach an interior through its windows. The walks pass
    /// through the surfaces for which `see_through` is true: glass in windows.
    ///
    /// The same rays give the same guide, for any number of threads. Without infinite lights the
    /// guide is the default one, and `rays` is not called.
    pub fn new(
        emitters: &Emitters,
        geometry: &Geometry,
        rays: impl FnOnce() -> Vec<Ray>,
        see_through: impl Fn(PrimitiveId) -> bool + Sync,
    ) -> EmissionGuide {
        if emitters.infinite.is_empty() {
            return EmissionGuide::default();
        }
        let prepass = GuidingPrepass {
            geometry,
            lights: &emitters.infinite,
            see_through: &see_through,
        };
        let guides = prepass.learn_guides(rays());
        let mut weights: Vec<f32> = emitters
            .powers
            .iter()
            .map(|p| p.selection_weight())
            .collect();
        for (emitter, gain) in emitters.infinite.gains(&guides) {
            weights[emitter.index()] /= gain;
        }
        let choice = Alias::new(&weights);
        EmissionGuide(Some(GuidedEmission { guides, choice }))
    }

    /// Emits a photon: chooses an emitter by power, for infinite lights by this guide, then a
    /// position and a direction. `None` if the sample has no flux.
    pub fn sample(
        &self,
        emitters: &Emitters,
        geometry: &Geometry,
        textures: &[Texture],
        u: EmissionNumbers,
    ) -> Option<EmissionSample> {
        let guided = self.0.as_ref();
        let choice = guided.map_or(&emitters.by_power, |guided| &guided.choice);
        let (index, pmf) = choice.as_ref()?.sample(u.emitter);
        let emitter = EmitterId::from(index);
        let (ray, flux, surface) = match &emitters.emitters[index] {
            Emitter::Area { radiance } | Emitter::InvisibleArea { radiance } => {
                emit_from_surface(emitters, (geometry, textures), emitter, *radiance, u)?
            }
            Emitter::Point {
                position,
                intensity,
            } => (
                Ray::new(*position, warp::sphere(u.direction)),
                *intensity / warp::SPHERE_PDF,
                None,
            ),
            point @ Emitter::Goniometric { position, .. } => {
                let w = warp::sphere(u.direction);
                let flux = point.point_intensity(textures, w) / warp::SPHERE_PDF;
                (Ray::new(*position, w), flux, None)
            }
            spot @ Emitter::Spot {
                position,
                direction,
                cutoff,
                projector,
                ..
            } => {
                let (w, pdf) = spot_direction(*direction, *cutoff, projector.as_ref(), u.direction);
                let flux = spot.point_intensity(textures, w) / pdf;
                (Ray::new(*position, w), flux, None)
            }
            Emitter::Directional { .. } | Emitter::Constant { .. } | Emitter::Environment(_) => {
                let numbers = InfiniteEmissionNumbers {
                    position: u.position,
                    direction: u.direction,
                    guide: u.element,
                };
                let guides = guided.map(|guided| &guided.guides);
                let (ray, flux) = emitters.infinite.emit(emitter, guides, numbers)?;
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
}

/// Ray, flux before division by the probability of the emitter, and emitting point of a photon of
/// an area emitter.
fn emit_from_surface(
    emitters: &Emitters,
    (geometry, textures): (&Geometry, &[Texture]),
    emitter: EmitterId,
    radiance: ColorInput,
    u: EmissionNumbers,
) -> Option<(Ray, Rgb, Option<SurfacePoint>)> {
    let (element, pmf) = emitters.elements.choose(emitter, u.element)?;
    let y = element.sample_area(geometry, u.position)?;
    let radiance = radiance.eval(&y, textures);
    if radiance.is_black() {
        return None;
    }
    // Light leaves on the side of the shading normal, in proportion to the geometric cosine. Of two
    // opposite directions exactly one is on that side, so a cosine-distributed direction on the
    // other side is reversed.
    let w = Frame::from_normal(y.ng)
        .to_world(warp::cosine_hemisphere(u.direction))
        .normalize();
    let w = if y.frame.n.dot(w) >= 0.0 { w } else { -w };
    let flux = radiance * (PI / (element.pdf_area(&y) * pmf));
    Some((y.spawn(w), flux, Some(y)))
}
