//! Photons from the emitters and importons from the sensor.

pub mod importons;
pub mod photons;
mod tasks;

pub use importons::{Importon, trace_gather_importons, trace_importons};
pub use photons::{
    Photon, parent, trace_photons, trace_photons_of_groups, usable_by_virtual_lights,
};
