//! A photorealistic many-light renderer.
//!
//! Rich-VPLs (Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light Methods", Eurographics 2015)
//! and the methods they are compared with, as pure functions over plain data: no files, no printing, and no failure but in
//! [`scene::Scene::build`]. Files are the business of `manylight-io`, the command line of `manylight-cli`.
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers; a test reads this list and checks it. From 5 on it is the
//! order of the method. Start reading at [`integrators::many_light`].
//!
//! ```text
//! 12 render
//! 11 integrators
//! 10 gather
//!  9 light_tree
//!  8 virtual_lights
//!  7 maps
//!  6 particles
//!  5 transport
//!  4 scene
//!  3 bsdf emitters sensors
//!  2 geometry texture film
//!  1 sampling image stats lanes
//!  0 math color ids simd
//! ```

pub mod math;

pub mod color;

pub mod image;

pub mod ids;

mod simd;

pub mod sampling;

pub mod lanes;

pub mod stats;

pub mod geometry;

pub mod texture;

pub mod film;

pub mod bsdf;

pub mod emitters;

pub mod sensors;

pub mod scene;

pub mod transport;

pub mod particles;

pub mod maps;

pub mod virtual_lights;

pub mod light_tree;

pub mod gather;

pub mod integrators;

pub mod render;

#[cfg(any(test, feature = "testing"))]
pub mod testing;
