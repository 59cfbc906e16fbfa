//! Emission of photons.

use super::description::Emitter;
use super::elements::EmitterElement;
use super::emission_cells::{EmissionCells, UnitChoice};
use super::infinite::{GuidingPrepass, InfiniteEmissionNumbers, InfiniteLightGuides};
use super::point::spot_direction;
use super::{EmissionSource, Emitters};
use crate::color::Rgb;
use crate::geometry::{Geometry, Ray, SurfacePoint};
use crate::ids::{EmitterId, PrimitiveId};
use crate::math::{Frame, Vec2};
use crate::sampling::alias::Alias;
use crate::sampling::warp;
use crate::texture::{ColorInput, Texture};
use std::f32::consts::PI;
use std::sync::Arc;

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
    /// The part of the emitter that names tell apart.
    pub source: EmissionSource,
    /// The emitting point of an area emitter; `None` for points, spots and infinite lights. Light
    /// tracing connects it to the camera.
    pub surface: Option<SurfacePoint>,
}

/// Densities for the emission of photons that are concentrated on the visible part of the scene:
/// by infinite lights, and the choice among emitters. A guide changes densities only: the expected
/// value of every estimate stays the same.
///
/// The default guide is unguided emission.
#[derive(Clone, Debug, Default)]
pub struct EmissionGuide {
    infinite: Option<Arc<InfiniteLightGuides>>,
    choice: EmitterChoice,
}

/// How the emitter of a photon is chosen.
#[derive(Clone, Debug, Default)]
enum EmitterChoice {
    /// By power, then an element of it by power.
    #[default]
    ByPower,
    /// By [`EmissionGuide::weights`], then an element by power.
    ByGuidedPower(Option<Alias>),
    /// Among elements and infinite lights.
    Units(UnitChoice),
}

/// A chosen emitter.
struct Chosen<'a> {
    emitter: EmitterId,
    /// The element, of emitters with a position.
    element: Option<&'a EmitterElement>,
    /// Probability of the choice of an element of the emitter.
    element_pmf: f32,
    /// Probability of the rest of the choice.
    pmf: f32,
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
        let guide = EmissionGuide {
            infinite: Some(Arc::new(guides)),
            choice: EmitterChoice::ByPower,
        };
        let choice = Alias::new(&guide.weights(emitters));
        EmissionGuide {
            choice: EmitterChoice::ByGuidedPower(choice),
            ..guide
        }
    }

    /// The cells among which [`EmissionGuide::with_shares`] divides the photons.
    pub fn cells(&self, emitters: &Emitters) -> EmissionCells {
        EmissionCells::new(emitters, &self.weights(emitters))
    }

    /// This guide with emission from one cell alone: photons have the flux of that cell. `None`
    /// without power.
    pub fn of_cell(&self, cells: &EmissionCells, cell: usize) -> Option<EmissionGuide> {
        Some(EmissionGuide {
            infinite: self.infinite.clone(),
            choice: EmitterChoice::Units(cells.choice_within(cell)?),
        })
    }

    /// This guide with the probability `shares` of each cell. All of them must be positive.
    pub fn with_shares(self, cells: &EmissionCells, shares: &[f32]) -> EmissionGuide {
        match cells.choice(shares) {
            None => self,
            Some(choice) => EmissionGuide {
                choice: EmitterChoice::Units(choice),
                ..self
            },
        }
    }

    /// By emitter, in proportion to its probability by power. Guided photons of infinite lights have
    /// less flux by the gain of their guide.
    pub(super) fn weights(&self, emitters: &Emitters) -> Vec<f32> {
        let powers = emitters.powers.iter();
        let mut weights: Vec<f32> = powers.map(|p| p.selection_weight()).collect();
        if let Some(guides) = &self.infinite {
            for (emitter, gain) in emitters.infinite.gains(guides) {
                weights[emitter.index()] /= gain;
            }
        }
        weights
    }

    /// The probability of each emitter.
    pub(super) fn probabilities(&self, emitters: &Emitters) -> Vec<f32> {
        let count = emitters.emitters.len();
        let by_emitter = match &self.choice {
            EmitterChoice::ByPower => &emitters.by_power,
            EmitterChoice::ByGuidedPower(choice) => choice,
            EmitterChoice::Units(choice) => return choice.probabilities(count),
        };
        let probability = |i| by_emitter.as_ref().map_or(0.0, |choice| choice.pmf(i));
        (0..count).map(probability).collect()
    }

    /// Chooses an emitter and an element of it.
    fn choose<'a>(&self, emitters: &'a Emitters, u: EmissionNumbers) -> Option<Chosen<'a>> {
        let by_emitter = match &self.choice {
            EmitterChoice::ByPower => &emitters.by_power,
            EmitterChoice::ByGuidedPower(choice) => choice,
            EmitterChoice::Units(choice) => {
                let (unit, pmf) = choice.sample(u.emitter);
                let element = (unit.element).map(|i| emitters.elements.element(i as usize));
                return Some(Chosen {
                    emitter: unit.emitter,
                    element,
                    element_pmf: 1.0,
                    pmf,
                });
            }
        };
        let (index, pmf) = by_emitter.as_ref()?.sample(u.emitter);
        let emitter = EmitterId::from(index);
        let element = emitters.elements.choose(emitter, u.element);
        Some(Chosen {
            emitter,
            element: element.map(|(element, _)| element),
            element_pmf: element.map_or(1.0, |(_, pmf)| pmf),
            pmf,
        })
    }

    /// Emits a photon: chooses an emitter by power or by this guide, then a position and a
    /// direction. `None` if the sample has no flux.
    pub fn sample(
        &self,
        emitters: &Emitters,
        geometry: &Geometry,
        textures: &[Texture],
        u: EmissionNumbers,
    ) -> Option<EmissionSample> {
        let chosen = self.choose(emitters, u)?;
        let (emitter, pmf) = (chosen.emitter, chosen.pmf);
        let (ray, flux, surface) = match &emitters.emitters[emitter.index()] {
            Emitter::Area { radiance } | Emitter::InvisibleArea { radiance } => {
                emit_from_surface(&chosen, (geometry, textures), *radiance, u)?
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
                let guides = self.infinite.as_deref();
                let (ray, flux) = emitters.infinite.emit(emitter, guides, numbers)?;
                (ray, flux, None)
            }
        };
        (!flux.is_black()).then_some(EmissionSample {
            ray,
            flux: flux / pmf,
            emitter,
            source: (chosen.element)
                .map_or(EmissionSource::Emitter(emitter), EmitterElement::source),
            surface,
        })
    }
}

/// Ray, flux before division by the probability of the emitter, and emitting point of a photon of
/// an area emitter.
fn emit_from_surface(
    chosen: &Chosen,
    (geometry, textures): (&Geometry, &[Texture]),
    radiance: ColorInput,
    u: EmissionNumbers,
) -> Option<(Ray, Rgb, Option<SurfacePoint>)> {
    let (element, pmf) = (chosen.element?, chosen.element_pmf);
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
