//! Emitters: the light sources of a scene ("light" alone is reserved for virtual lights in this
//! project).
//!
//! Three questions are answered:
//! * emit a photon: [`EmissionGuide::sample`] (`emission.rs`);
//! * sample an emitter from a point: [`Emitters::sample`] (`direct.rs`);
//! * a ray hits an emitter: [`Emitters::radiance`], or leaves the scene: [`Emitters::environment`].
//!
//! Emitters with a position are divided into elements (`elements/`), from which `emitter_tree/`
//! chooses for a receiver. Parallel light and environments are infinite lights (`infinite/`), with
//! guides for their photons.

mod description;
mod direct;
mod elements;
mod emission;
mod emission_cells;
mod emitter_tree;
mod environment_lobes;
mod infinite;
mod point;
mod ray_density;
mod receivers;
#[cfg(test)]
mod tests;

pub use description::{
    DeformedCone, EmissionSource, Emitter, Environment, ProjectorTexture, SpotFalloff,
};
pub use direct::{DirectSample, DirectSamples, LobesOfLanes};
pub use emission::{EmissionGuide, EmissionNumbers, EmissionSample};
pub use emission_cells::EmissionCells;
pub use environment_lobes::{EnvironmentLobes, MAX_ENVIRONMENT_LOBES};
pub use ray_density::RayDensities;
pub use receivers::Receivers;

use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint};
use crate::ids::EmitterId;
use crate::image::Image;
use crate::math::Vec3;
use crate::sampling::alias::Alias;
use crate::texture::Texture;
use elements::{ElementBounds, ElementList};
use emitter_tree::EmitterTree;
use infinite::{BoundingSphere, InfiniteLights};

/// All emitters of a scene, with the data structures for choosing among 10⁵ of them.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    /// By emitter, in W.
    powers: Vec<Rgb>,
    /// Choice of an emitter by power for a photon.
    by_power: Option<Alias>,
    elements: ElementList,
    /// By element: its center, and its selection weight as a power.
    element_weights: Vec<(Vec3, f32)>,
    /// Choice of an element for a receiver.
    tree: EmitterTree,
    infinite: InfiniteLights,
    /// Probability of sampling an infinite light for a receiver.
    infinite_probability: f32,
}

/// Smallest probability of sampling infinite lights, and of sampling the other emitters, in scenes
/// with both. Powers do not tell how much light of each arrives at a receiver. At 0.1 and 0.4, the
/// pixel variance of path tracing is 1.37 and .95 times as large in a room with a bright sky behind
/// a slit and a dim lamp, 1.44 and 1.08 times on a plain under a dim sky with a small, bright lamp.
const MIN_GROUP_PROBABILITY: f32 = 0.25;

impl Emitters {
    /// Prepares sampling. Area emitters are found through `geometry`'s primitives; several
    /// primitives may share one emitter. `Scene::build` rejects emitters inside instanced groups.
    pub fn new(mut emitters: Vec<Emitter>, geometry: &Geometry, textures: &[Texture]) -> Self {
        let infinite = InfiniteLights::new(&emitters, BoundingSphere::new(geometry.bounds()));
        for emitter in &mut emitters {
            if let Emitter::Environment(environment) = emitter {
                environment.image = Image::default();
            }
        }
        let (elements, bounds) = ElementList::collect(&emitters, geometry, textures);
        let mut powers = elements.powers(&bounds);
        let local_weight = total_weight(&powers);
        for (id, power) in infinite.powers() {
            powers[id.index()] = power;
        }
        let infinite_weight = total_weight(&powers) - local_weight;
        let tree = EmitterTree::new(&bounds);
        let infinite_probability = infinite_probability(
            (!tree.is_empty()).then_some(local_weight),
            (!infinite.is_empty()).then_some(infinite_weight),
        );
        let weights: Vec<f32> = powers.iter().map(|p| p.selection_weight()).collect();
        Emitters {
            powers,
            by_power: Alias::new(&weights),
            elements,
            element_weights: bounds
                .iter()
                .map(ElementBounds::center_and_weight)
                .collect(),
            tree,
            infinite,
            infinite_probability,
            emitters,
        }
    }

    /// The descriptions, indexed by [`EmitterId`]. Images of environment maps are replaced by empty
    /// ones: they are stored as tiles.
    pub fn descriptions(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Radiance in W/(m² sr) that the surface emits at `x` towards `wo`; black for surfaces that do
    /// not emit.
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
                radiance.eval(x, textures)
            }
            _ => Rgb::BLACK,
        }
    }

    /// Whether there is an infinite light that fills a solid angle: rays that leave the scene may
    /// find radiance.
    pub fn has_environment(&self) -> bool {
        self.infinite.fills_directions()
    }

    /// The infinite lights that fill a solid angle.
    pub fn environment_lights(&self) -> impl Iterator<Item = EmitterId> + '_ {
        self.infinite.environments()
    }

    /// Radiance of each infinite light that fills a solid angle, from the unit direction `wi`: the
    /// terms of [`Emitters::environment`].
    pub fn environment_terms(&self, wi: Vec3) -> impl Iterator<Item = (EmitterId, Rgb)> + '_ {
        self.infinite.terms(wi)
    }

    /// The source of a sample, given by [`DirectSamples::source`]; `None` for the environment.
    pub(crate) fn source(&self, source: u32) -> Option<EmissionSource> {
        let source = source as usize;
        match source < self.elements.len() {
            true => Some(self.elements.element(source).source()),
            false => {
                let light = self.infinite.emitter(source - self.elements.len());
                light.map(EmissionSource::Emitter)
            }
        }
    }

    /// Flux of one emitter into the scene in W. It is an estimate for infinite lights (irradiance
    /// times the cross-section of the bounding sphere) and for textured emitters (a mean over a
    /// grid).
    pub fn power(&self, id: EmitterId) -> Rgb {
        self.powers[id.index()]
    }
}

/// Probability of sampling an infinite light, by the total selection weights of both groups; `None`
/// for an empty group.
fn infinite_probability(local: Option<f32>, infinite: Option<f32>) -> f32 {
    match (local, infinite) {
        (_, None) => 0.0,
        (None, Some(_)) => 1.0,
        (Some(local), Some(infinite)) => (infinite / (infinite + local))
            .clamp(MIN_GROUP_PROBABILITY, 1.0 - MIN_GROUP_PROBABILITY),
    }
}

fn total_weight(powers: &[Rgb]) -> f32 {
    powers.iter().map(|p| p.selection_weight()).sum()
}
