//! Random walks of camera paths, photons and importons, as streams; next-event estimation; Russian
//! roulette.

pub mod direct;
pub mod roulette;
pub(crate) mod stream;
#[cfg(test)]
mod tests;
pub mod walk;

pub use walk::{Vertex, Walk, past_emitters};
