//! Specular chains seen by a glossy lobe: the direction from a gather point continues by specular events, and lights are
//! gathered at the surface behind.
//!
//! A density estimate of caustic photons on a glossy lobe would show single photons. Light that emitters send through such a
//! chain is estimated by photons all the same: emitters may be small.

use super::compensation::MAX_SURVIVAL;
use super::gather_points::{PixelGather, roulette_weight};
use super::gathering::{DirectionNumbers, EmittedLight, GatherPath, GatherRole};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::integrators::partition::PathStage;
use crate::transport::Vertex;

/// Chains of more segments end: they would carry hardly any light.
pub(super) const MAX_CHAIN: u32 = 64;
/// Largest probability of following a chain from the first gather point. Unmeasured.
const MAX_FIRST_SURVIVAL: f32 = 0.5;
/// Factor from the throughput of a chain to that probability: low-roughness lobes see bright surfaces there. Unmeasured.
const FIRST_SURVIVAL_FACTOR: f32 = 16.0;

impl<'s> PixelGather<'_, 's, '_, '_> {
    /// Follows specular events from `y` on. `glossy_fraction` is the fraction of the direction's reflectance that is due to
    /// glossy lobes, per channel.
    pub(super) fn follow_specular_chain(
        &mut self,
        mut y: Vertex<'s>,
        mut path: GatherPath<'s>,
        glossy_fraction: Rgb,
    ) {
        let (mut most, mut factor) = (MAX_SURVIVAL, 1.0);
        if path.stage == PathStage::AfterX {
            (most, factor) = (MAX_FIRST_SURVIVAL, FIRST_SURVIVAL_FACTOR);
        }
        path.stage = path.stage.after(Lobes::SPECULAR);
        path.walk.scale(glossy_fraction);
        while y.bsdf.lobes().has(Lobes::SPECULAR) && y.segments < MAX_CHAIN {
            let numbers = self.sampler.next_bsdf();
            if !path.walk.scatter(&y, numbers, Lobes::SPECULAR) {
                return;
            }
            let weight = factor * roulette_weight(&path.walk) / self.first_weight;
            if !path.walk.survive(weight.min(most), self.sampler.next_1d()) {
                return;
            }
            (most, factor) = (MAX_SURVIVAL, 1.0);
            let Some(next) = self.next_vertex(&mut path, EmittedLight::Photons) else {
                return;
            };
            y = next;
            if y.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                let lights = self.sparse_lights();
                let numbers = DirectionNumbers::single(self.sampler);
                let role = GatherRole::BehindSpecularChain;
                self.gather(&y, path.clone(), role, lights, &numbers);
            }
        }
    }
}
