//! Specular chains seen by a glossy lobe: the direction from a gather point continues by specular events, and lights are
//! gathered at the surface behind.
//!
//! Caustic photons carry the same light; `caustic_shares.rs` says which part of it they account for. Light that emitters send
//! through such a chain is estimated by photons: emitters may be small.

use super::caustic_shares::photon_fraction;
use super::compensation::MAX_SURVIVAL;
use super::gather_points::{PixelGather, roulette_weight};
use super::gather_vertices::{DirectionNumbers, GatherDirection, GatherPath, GatherRole};
use super::gathering::EmittedLight;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::integrators::partition::PathStage;
use crate::maps::density::DensityReceiver;
use crate::math::Vec3;
use crate::transport::Vertex;

/// Chains of more segments end: they would carry hardly any light.
pub(super) const MAX_CHAIN: u32 = 64;
/// Factor from the throughput of a chain at the first gather point to the probability of following it: low-roughness lobes see bright
/// surfaces there. Measured at 64, over 4 passes at 160x90: no change beyond 3 % in U-Shape, Garage and Disco.
const FIRST_SURVIVAL_FACTOR: f32 = 16.0;

impl<'s> PixelGather<'_, 's, '_, '_> {
    /// Fraction of the light that glossy lobes at `from` see in the unit direction `w` by a specular chain, for which caustic photons
    /// account; `max_photon_radius` as in [`GatherPath`] there.
    pub(super) fn chain_fraction_of_photons(
        &mut self,
        from: &GatherDirection,
        w: Vec3,
        max_photon_radius: f32,
    ) -> f32 {
        let receiver = DensityReceiver {
            p: from.x.p,
            n: from.x.normal_towards(w),
        };
        let (prepared, found) = (self.prepared, &mut self.tile.found_caustics);
        if prepared.caustics_are_dense(receiver, from.segments, max_photon_radius, found) {
            photon_fraction(from.f_cos)
        } else {
            0.0
        }
    }

    /// Follows specular events from `y` on. `fraction` is the fraction of the direction's reflectance, per channel, for which
    /// directions account.
    pub(super) fn follow_specular_chain(
        &mut self,
        mut y: Vertex<'s>,
        mut path: GatherPath<'s>,
        fraction: Rgb,
    ) {
        let (mut most, mut factor) = (MAX_SURVIVAL, 1.0);
        if path.stage == PathStage::AfterX {
            (most, factor) = (1.0, FIRST_SURVIVAL_FACTOR);
        }
        path.stage = path.stage.after(Lobes::SPECULAR);
        path.walk.scale(fraction);
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
                self.gather(&y, path.clone(), role, lights, numbers);
            }
        }
    }
}
