//! Scattering at surfaces. [`Material`] is the description in a scene file, [`Bsdf`] the scattering function at one point.
//!
//! Directions are physical: light arrives from `wi` and leaves along `wo`. Both are unit vectors that point away from the surface.
//! A camera walk has `wo` and samples `wi`; a photon walk has `wi` and samples `wo`.
//!
//! Each lobe belongs to a class of [`Lobes`], and functions take the set of classes to consider: the path partition
//! (docs/path_partition.md) is by the class of scattering events, and one surface may have lobes of several classes.
//!
//! A [`Bsdf`] is a weighted list of leaves (`leaf.rs`), each a scattering model (`models/`) with the sides and the tilted frame of
//! its wrappers. [`Materials`] makes it from the material tree (`flatten.rs`).

mod albedo;
mod bound;
mod eval;
mod exit_transmittance;
mod fixed_wi;
mod fixed_wo;
mod fixed_wo_lanes;
mod flatten;
mod incident_cone;
mod instantiate;
mod lambert;
mod leaf;
mod lobes;
pub mod material;
mod materials;
mod model;
mod model_sample;
mod models;
mod response;
mod sampling;
mod sides;
#[cfg(test)]
mod tests;
mod tilt;

pub use eval::DirectResponse;
pub use exit_transmittance::ExitTransmittance;
pub use fixed_wi::FixedWi;
pub use fixed_wo::FixedWo;
pub use fixed_wo_lanes::{FixedWoLanes, LaneModel};
pub use lobes::{Lobes, NEAR_DELTA_ALPHA};
pub use material::{Bitangent, Material};
pub use materials::Materials;
pub use models::coat::{COSINES, interpolate_lanes};
pub use sampling::{BsdfNumbers, BsdfSample};

use crate::math::{Frame, Vec3};
use leaf::Leaf;

/// Most leaves of a material at a point; see [`Materials::bsdf`].
const MAX_LEAVES: usize = 4;

/// Absolute cosine between shading normal and geometric normal from which they count as equal: rounding of interpolated normals.
const ALIGNED_COSINE: f32 = 0.9998;

/// The scattering function at a point. It is small and `Copy`, and borrows only precomputed tables of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s> {
    /// Geometric normal.
    ng: Vec3,
    /// Shading frame.
    frame: Frame,
    /// The leaves, followed by `None`.
    leaves: [Option<Leaf<'s>>; MAX_LEAVES],
    /// Fraction of light that passes straight through masks and null materials, by side: that of the shading normal, the other.
    pass_through: [f32; 2],
    /// Whether any light passes straight through, thin dielectrics included.
    is_transparent: bool,
    /// Whether a finite lobe transmits.
    transmits: bool,
    lobes: Lobes,
    exit_transmittance: ExitTransmittance<'s>,
    glossy_width: f32,
    /// Whether photon walks need defensive sampling: some normal in use is not the geometric one.
    is_defensive: bool,
}

impl<'s> Bsdf<'s> {
    /// The classes of all lobes with positive weight.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.lobes
    }

    /// Whether a finite lobe transmits light to the other side.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits
    }

    /// `b(wo)` of the `DIFFUSE` lobes; see [`Bsdf::diffuse_weight`].
    #[inline]
    pub fn exit_transmittance(&self) -> ExitTransmittance<'s> {
        self.exit_transmittance
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes; 1 without such lobes. It is roughly the width of the lobe in radians.
    #[inline]
    pub fn glossy_width(&self) -> f32 {
        self.glossy_width
    }

    /// The normal for sampling emitters: the shading normal on the side of `wo`. `None` if some lobe transmits, because then light
    /// from both sides contributes.
    #[inline]
    pub fn receiving_normal(&self, wo: Vec3) -> Option<Vec3> {
        if self.transmits {
            return None;
        }
        Some(self.frame.n * 1.0f32.copysign(wo.dot(self.frame.n)))
    }

    /// The leaves from which `lobes` can be sampled given the local direction `given`, with the weights of the choice among them.
    #[inline]
    fn weighted_leaves(&self, given: Vec3, lobes: Lobes) -> impl Iterator<Item = (&Leaf<'s>, f32)> {
        let is_alone = self.leaves[1].is_none();
        self.sampleable_leaves(given, lobes).map(move |leaf| {
            let weight = if is_alone {
                1.0
            } else {
                leaf.sampling_weight(given, lobes)
            };
            (leaf, weight)
        })
    }

    /// The leaves from which `lobes` can be sampled given the local direction `given`.
    #[inline]
    fn sampleable_leaves(&self, given: Vec3, lobes: Lobes) -> impl Iterator<Item = &Leaf<'s>> {
        self.leaves
            .iter()
            .map_while(Option::as_ref)
            .filter(move |leaf| leaf.can_sample(given, lobes))
    }
}

/// The largest single-precision number below 1.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
