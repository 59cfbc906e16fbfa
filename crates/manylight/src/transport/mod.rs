//! The random walk of camera paths, photons and importons; next-event estimation; the step of a camera path.

pub mod camera_step;
pub mod direct;
pub mod direct_lanes;
mod numbers;
pub mod roulette;
pub(crate) mod stream;
#[cfg(test)]
mod tests;
pub mod walk;

pub use camera_step::{CameraStep, next_scattering_vertex};
pub use walk::{Arrival, Vertex, Walk, past_emitters};
