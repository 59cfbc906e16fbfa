//! Scattering models, one per file, in a local frame with the normal as z axis; see
//! [`super::scattering_model`] for their contract, [`super::model`] for the list. Also the parts
//! that several models share: Fresnel equations, microfacet distributions, tables of coats, a
//! lobe over a diffuse base.

pub(super) mod coat;
pub(super) mod coat_family;
pub(super) mod conductor;
pub(super) mod dielectric;
pub(super) mod diffuse;
pub(super) mod diffuse_transmitter;
pub(super) mod fresnel;
pub(super) mod lobe_over_base;
pub(super) mod microfacet;
pub(super) mod phong;
pub(super) mod plastic;
pub(super) mod principled;
pub(super) mod rough_diffuse;
pub(super) mod substrate;
pub(super) mod thin_dielectric;
pub(super) mod ward;
