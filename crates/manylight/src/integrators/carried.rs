//! The complement of the clamp by photons: light that the sum over lights lacks, from photons that bring it.
//!
//! A photon that went on from a smooth surface at `z` to `y` is a path that the virtual light at `z` stands for, too. Of the light from `z`,
//! the clamp takes a share away at `x`; a density estimate at `x` gives it back, in which each photon counts by that share.
//! The estimate spreads light over its radius, which is small beside the surface that a light stands for: what the clamp takes
//! changes little over it.
//!
//! Source: Sriwasansak, Gruson, Hachisuka, "Efficient Energy-Compensated VPLs Using Photon Splatting", I3D 2018; here for lights that
//! stand for many photons, so that the clamp asks whose a photon at `z` is.

use super::caustics::bandwidth;
use super::eye_path::Gathering;
use super::light_set::LightSet;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::ids::LightId;
use crate::maps::density::{Receiver, estimate};
use crate::maps::{KdTree, Located, Neighbors};
use crate::math::Vec3;
use crate::particles::{Photon, parent};
use crate::scene::Scene;
use crate::virtual_lights::{Claims, Spot};
use rayon::prelude::*;

/// Neighbors in an estimate.
pub(super) const CARRIED_NEIGHBORS: usize = 48;

/// A photon that came from a smooth surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    photon: Photon,
    /// Where it came from.
    from: Spot,
    /// The light that stands for light from there, if one does.
    owner: Option<LightId>,
}

impl Located for Carried {
    #[inline]
    fn position(&self) -> Vec3 {
        self.photon.p
    }
}

impl AsRef<Photon> for Carried {
    fn as_ref(&self) -> &Photon {
        &self.photon
    }
}

/// The photons among `photons`, in path order, that came from smooth surfaces; without owners.
pub(super) fn carried(scene: &Scene, photons: &[Photon]) -> Vec<Carried> {
    let of = |j: usize| {
        let before = &photons[parent(photons, j)?];
        Some(Carried {
            photon: photons[j],
            from: Spot::of(before, scene),
            owner: None,
        })
    };
    (0..photons.len()).into_par_iter().filter_map(of).collect()
}

/// The photons with their owners, ready to be asked for.
pub(super) fn owned(scene: &Scene, claims: &Claims, mut photons: Vec<Carried>) -> KdTree<Carried> {
    photons
        .par_iter_mut()
        .with_min_len(256)
        .for_each(|carried| carried.owner = claims.light(scene, &carried.from));
    KdTree::build_ordered(photons)
}

impl LightSet<'_> {
    /// What the clamp takes away at a gathering point, by a density estimate.
    pub(super) fn carried_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let at = &point.at;
        let n = at.lit_from.unwrap_or(at.x.normal_towards(at.wo));
        let receiver = Receiver { p: at.x.p, n };
        let mut sum = Rgb::BLACK;
        estimate(
            &self.carried,
            receiver,
            bandwidth(self, point),
            found,
            |one, kernel| {
                let Carried {
                    photon,
                    from,
                    owner,
                } = one;
                if self.limits.allow(point.segments + u32::from(photon.depth)) {
                    let missing = self.gather.missing(&self.lights, at, from, *owner);
                    let f = at.bsdf.f(photon.wi, at.wo, Lobes::SMOOTH);
                    sum += photon.flux * f * (kernel * missing);
                }
            },
        );
        sum
    }
}
