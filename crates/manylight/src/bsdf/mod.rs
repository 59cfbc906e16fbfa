//! Scattering at surfaces. [`Material`] is the description in a scene file, [`Bsdf`] the scattering
//! function at one point.
//!
//! Directions are physical: light arrives from `wi` and leaves along `wo`. Both are unit vectors
//! that point away from the surface. A camera walk has `wo` and samples `wi`; a photon walk has
//! `wi` and samples `wo`.
//!
//! Each lobe belongs to a class of [`Lobes`], and functions take the set of classes to consider:
//! the path partition (docs/path_partition.md) is by the class of scattering events, and one
//! surface may have lobes of several classes.
//!
//! A [`Bsdf`] is a weighted list of leaves (`leaf.rs`), each a scattering model (`models/`) with
//! the sides and the tilted frame of its wrappers. [`Materials`] makes it from the material tree
//! (`flatten.rs`).

mod exit_transmittance;
mod fixed_wi;
mod fixed_wo;
mod fixed_wo_lanes;
mod flatten;
mod function;
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
mod samples;
mod sampling;
mod scattering_model;
mod sides;
#[cfg(test)]
mod tests;
mod tilt;

pub use exit_transmittance::ExitTransmittance;
pub(crate) use fixed_wi::FixedWi;
pub use fixed_wo::FixedWo;
pub use fixed_wo_lanes::{FixedWoLanes, LaneModel};
pub use function::Bsdf;
#[cfg(test)]
use function::DirectResponses;
pub use lobes::{Lobes, NEAR_DELTA_ALPHA};
pub use material::{Bitangent, Material};
pub use materials::Materials;
pub(crate) use model_sample::Numbers;
pub use models::coat::COSINES;
pub(crate) use samples::BsdfSamples;
pub use samples::{BsdfNumbers, BsdfSample};
