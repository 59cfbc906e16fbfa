//! Densities of emitted photons among rays, by which other ways to find their light are weighed.

use super::emission::{EmissionGuide, EmissionSample};
use super::{Emitter, Emitters};
use crate::arrays::{FoundArray, InvalidArray, NamedArray, read_floats};
use crate::color::Rgb;
use crate::geometry::Geometry;
use crate::ids::EmitterId;
use crate::texture::Texture;

/// Name of [`RayDensities::array`].
const ARRAY: &str = "ray_densities";

/// The expected number of photons per area perpendicular to a ray and solid angle, in 1/(m² sr).
///
/// Photons of an emitter have about the same flux `Φ`, and carry its radiance `L`: `L / Φ` of them
/// pass. `Φ` is the mean over the emitter, so that the density is a function of the emitter and the
/// radiance alone, which whoever arrives at the emitter knows.
#[derive(Clone, Debug)]
pub struct RayDensities {
    /// `1 / Φ` by emitter, in 1/W. Infinite for emitters that no ray finds.
    per_flux: Vec<f32>,
    /// The same for all environments together.
    of_environments: f32,
}

impl RayDensities {
    /// Of `path_count` photons that `guide` emits.
    pub fn new(guide: &EmissionGuide, emitters: &Emitters, path_count: u32) -> Self {
        let weights = guide.weights(emitters);
        let probabilities = guide.probabilities(emitters);
        let paths = path_count as f32;
        let density = |probability: f32, weight: f32| match weight > 0.0 {
            true => paths * probability / weight,
            false => 0.0,
        };
        let (mut probability, mut weight) = (0.0, 0.0);
        let mut per_flux = Vec::with_capacity(weights.len());
        for ((emitter, &p), &w) in emitters.emitters.iter().zip(&probabilities).zip(&weights) {
            match emitter {
                Emitter::Area { .. } => per_flux.push(density(p, w)),
                Emitter::Constant { .. } | Emitter::Environment(_) => {
                    per_flux.push(density(p, w));
                    (probability, weight) = (probability + p, weight + w);
                }
                Emitter::InvisibleArea { .. }
                | Emitter::Point { .. }
                | Emitter::Goniometric { .. }
                | Emitter::Spot { .. }
                | Emitter::Directional { .. } => per_flux.push(f32::INFINITY),
            }
        }
        RayDensities {
            per_flux,
            of_environments: density(probability, weight),
        }
    }

    /// As an array: by emitter, then of all environments.
    pub(crate) fn array(&self) -> NamedArray<'_> {
        let values = || (self.per_flux.iter().copied()).chain([self.of_environments]);
        NamedArray::floats(ARRAY, [self.per_flux.len() + 1], values)
    }

    /// The inverse of [`RayDensities::array`].
    ///
    /// # Errors
    /// Those of `read`, and densities of other emitters.
    pub(crate) fn of_array<E: From<InvalidArray>>(
        emitters: &Emitters,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let mut per_flux = read_floats(ARRAY, 1, read)?;
        let (found, expected) = (per_flux.len(), emitters.emitters.len() + 1);
        match per_flux.pop() {
            Some(of_environments) if found == expected => Ok(RayDensities {
                per_flux,
                of_environments,
            }),
            _ => {
                let message = format!("found {found} values, expected {expected}");
                Err(InvalidArray::new(ARRAY, message).into())
            }
        }
    }

    /// Where a ray meets the surface of an emitter with this radiance in W/(m² sr); for rays that
    /// leave the scene, `None`.
    pub fn at(&self, emitter: Option<EmitterId>, radiance: Rgb) -> f32 {
        let per_flux = emitter.map_or(self.of_environments, |id| self.per_flux[id.index()]);
        per_flux * radiance.selection_weight()
    }

    /// On the ray of an emitted photon. Infinite where no ray in the other direction finds its
    /// emitter.
    pub(crate) fn of_sample(
        &self,
        emitters: &Emitters,
        (geometry, textures): (&Geometry, &[Texture]),
        sample: &EmissionSample,
    ) -> f32 {
        let (id, d) = (sample.emitter, sample.ray.d);
        if self.per_flux[id.index()].is_infinite() {
            return f32::INFINITY;
        }
        match &sample.surface {
            Some(y) => self.at(Some(id), emitters.radiance(geometry, textures, y, d)),
            None => self.at(None, emitters.environment(None, -d, None).0),
        }
    }
}
