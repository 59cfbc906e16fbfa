//! A photorealistic many-light renderer.

pub mod bsdf;
pub mod color;
pub mod emitters;
pub mod film;
pub mod geometry;
pub mod ids;
pub mod image;
pub mod integrators;
pub mod maps;
pub mod math;
pub mod particles;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod sensors;
pub mod texture;
pub mod transport;
pub mod virtual_lights;
