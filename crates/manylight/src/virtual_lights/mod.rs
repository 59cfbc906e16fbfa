//! Virtual lights: from photons to lights that can be gathered. The heart of the method of Simon,
//! Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light Methods",
//! Eurographics 2015.
//!
//! | stage | input → output | modules |
//! |---|---|---|
//! | basis | order of photons along a space-filling curve, surfaces | [`curve`], [`surfaces`] |
//! | placement | photons, importance → [`Site`]s | `candidates`, [`select()`], [`relax`] |
//! | flux | photons, sites → [`PhotonClusters`] | [`nearest_light`], [`assign()`] (partition) or [`density`]; `clusters` |
//! | light groups | placement and flux, group by group | [`light_groups`] |
//! | extent | cluster → radius and points | [`moments`] |
//! | emission | cluster → diffuse flux, glossy profile | `reflection`; `glossy`: a table (`octahedral_grid`, filled by `octahedral_profile`, stored by `tables`, read by `table_lookup`), or lobes (`lobe_fit`, `von_mises_fisher`) |
//! | set | clusters → [`VirtualLights`] | `light`, `build`, with `areas` and `depth_limits` |
//! | evaluation | light, direction → radiant intensity or its bound | `emission_view`; `intensity_bound`, `max_mips` |
//!
//! The stages are independent: any placement goes with any flux rule (but the density rule expects
//! sites where selection placed them), and with any form of emission. Modules import only from the
//! rows above and from their own row.

pub mod curve;
pub mod surfaces;

pub(crate) mod candidates;
pub mod relax;
pub mod select;

pub mod assign;
mod clusters;
pub mod density;
pub mod nearest_light;

pub mod light_groups;

pub mod moments;

mod glossy;
mod light;
mod lobe_fit;
mod octahedral_grid;
mod octahedral_profile;
mod reflection;
mod table_blocks;
mod table_lookup;
mod tables;
mod von_mises_fisher;

mod areas;
mod build;
mod depth_limits;
mod set;

pub(crate) mod kept;

mod emission_view;
mod intensity_bound;
mod max_mips;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub use assign::assign;
pub use build::build_lights;
pub use candidates::Candidates;
pub use clusters::PhotonClusters;
pub(crate) use emission_view::{EmissionView, RadiantIntensity, SingleEmission};
pub use glossy::GlossyForm;
pub use intensity_bound::IntensityBound;
pub use light::{Emission, VirtualLight};
pub use nearest_light::NearestLights;
pub use reflection::Reflection;
pub use select::{Site, select};
pub use set::{ProfileFlux, VirtualLights};
pub use surfaces::SurfaceLocation;
pub use tables::TableStorage;
