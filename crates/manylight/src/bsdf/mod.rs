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
mod outlined;
mod response;
mod sampling;
mod scattering_model;
mod sides;
#[cfg(test)]
mod tests;
mod tilt;

pub use eval::DirectResponse;
pub(crate) use eval::DirectResponses;
pub use exit_transmittance::ExitTransmittance;
pub use fixed_wi::FixedWi;
pub use fixed_wo::FixedWo;
pub use fixed_wo_lanes::{FixedWoLanes, LaneModel};
pub use lobes::{Lobes, NEAR_DELTA_ALPHA};
pub use material::{Bitangent, Material};
pub use materials::Materials;
pub(crate) use model_sample::Numbers;
pub use models::coat::COSINES;
pub(crate) use sampling::BsdfSamples;
pub use sampling::{BsdfNumbers, BsdfSample};

use crate::lanes::{Axes, Float, Mask, One, Vector, Width};
use crate::math::Vec3;
use leaf::Leaf;
use lobes::Classes;

/// Most leaves of a material at a point; see [`Materials::bsdf`].
const MAX_LEAVES: usize = 4;

/// Absolute cosine between shading normal and geometric normal from which they count as equal: rounding of interpolated normals.
const ALIGNED_COSINE: f32 = 0.9998;

/// The scattering function at a point, or at a point of one material in each lane. It is `Copy`, and borrows only precomputed tables of
/// the scene.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s, S: Width = One> {
    /// Geometric normal.
    ng: Vector<S>,
    /// Shading frame.
    frame: Axes<S>,
    /// The leaves, followed by `None`.
    leaves: [Option<Leaf<'s, S>>; MAX_LEAVES],
    /// Fraction of light that passes straight through masks and null materials, by side: that of the shading normal, the other.
    pass_through: [Float<S>; 2],
    /// Whether any light passes straight through, thin dielectrics included.
    is_transparent: bool,
    /// The lanes in which a finite lobe transmits.
    transmits: Mask<S>,
    /// The classes of all lobes with positive weight.
    classes: Classes<S>,
    /// The lanes in which photon walks need defensive sampling: some normal in use is not the geometric one.
    is_defensive: Mask<S>,
}

impl<'s> Bsdf<'s> {
    /// The classes of all lobes with positive weight.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.classes.get()
    }

    /// Whether a finite lobe transmits light to the other side.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits.any()
    }

    /// `b(wo)` of the `DIFFUSE` lobes; see [`Bsdf::diffuse_weight`].
    #[inline]
    pub fn exit_transmittance(&self) -> ExitTransmittance<'s> {
        let diffuse = self.leaves().find(|leaf| leaf.lobes.diffuse.any());
        diffuse.map_or(ExitTransmittance::Lambert, |leaf| {
            leaf.model.exit_transmittance()
        })
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes; 1 without such lobes. It is roughly the width of the lobe in radians.
    #[inline]
    pub fn glossy_width(&self) -> f32 {
        self.glossy_widths().get()
    }

    /// The normal for sampling emitters: the shading normal on the side of `wo`. `None` if some lobe transmits, because then light
    /// from both sides contributes.
    #[inline]
    pub fn receiving_normal(&self, wo: Vec3) -> Option<Vec3> {
        let (n, is_one_sided) = self.receiving_normals(wo.into());
        is_one_sided.any().then(|| n.into())
    }
}

impl<'s, S: Width> Bsdf<'s, S> {
    /// The instruction set of the lanes.
    #[inline(always)]
    fn width(&self) -> S {
        self.ng.x.width()
    }

    /// [`Bsdf::receiving_normal`], and the lanes in which there is one.
    #[inline(always)]
    pub(crate) fn receiving_normals(&self, wo: Vector<S>) -> (Vector<S>, Mask<S>) {
        let n = self.frame.n;
        (n * wo.dot(n).sign(), !self.transmits)
    }

    /// [`Bsdf::glossy_width`] in each lane.
    #[inline(always)]
    pub(crate) fn glossy_widths(&self) -> Float<S> {
        let mut least = Float::splat(self.width(), 1.0);
        for leaf in self.leaves() {
            least = least.min(leaf.model.glossy_width(self.width()));
        }
        least
    }

    /// [`Bsdf::lobes`] of each lane.
    #[inline(always)]
    pub(crate) fn lobes_each(&self) -> S::Each<Lobes> {
        self.classes.each()
    }

    /// The lanes in which a finite lobe transmits.
    #[inline(always)]
    pub(crate) fn transmitting(&self) -> Mask<S> {
        self.transmits
    }

    /// The lanes with lobes of the classes `lobes`.
    #[inline(always)]
    pub(crate) fn has(&self, lobes: Lobes) -> Mask<S> {
        self.classes.has(Classes::splat(self.width(), lobes))
    }

    #[inline(always)]
    fn leaves(&self) -> impl Iterator<Item = &Leaf<'s, S>> {
        self.leaves.iter().map_while(Option::as_ref)
    }

    /// The only leaf, if there is one.
    #[inline(always)]
    fn only_leaf(&self) -> Option<&Leaf<'s, S>> {
        match &self.leaves {
            [Some(leaf), None, ..] => Some(leaf),
            _ => None,
        }
    }

    /// The weight of a leaf in the choice among several: 0 where `lobes` cannot be sampled given the local direction `given`.
    #[inline(always)]
    fn choice_weight(&self, leaf: &Leaf<'s, S>, given: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let can_sample = leaf.can_sample(given, lobes);
        can_sample.select(leaf.sampling_weight(given, lobes), 0.0)
    }
}

/// The largest single-precision number below 1.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
