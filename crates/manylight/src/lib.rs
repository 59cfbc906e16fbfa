//! A photorealistic many-light renderer.
//!
//! Rich-VPLs (Simon, Hanika, Dachsbacher, "Rich-VPLs for Improving the Versatility of Many-Light
//! Methods", Eurographics 2015) and the methods they are compared with, as pure functions over
//! plain data. The crate promises:
//!
//! * no files, no printing, and no failure but where it checks what comes in, as in
//!   [`scene::Scene::build`]; files belong to the crate `manylight-io`, the command line to
//!   `manylight-cli`;
//! * the same bits for the same seed, for any number of threads;
//! * units in SI, radiance in linear RGB, directions away from the surface.
//!
//! # A render in ten lines
//!
//! ```
//! use manylight::prelude::*;
//! use manylight_io::{LoadOptions, load_scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))?;
//! let desc = load_scene("scenes/furnace/emissive-box.xml".as_ref(), &LoadOptions::default())?.desc;
//! let scene = Scene::build(desc, 0)?;
//! let method = MethodKind::ManyLight(ManyLight::rich_vpl());
//! let film = render_film(&scene, method, Budget::passes(1), 0);
//! let image = film.image(Layer::Beauty).ok_or("every film has a beauty layer")?;
//! assert!(image.data.iter().all(|radiance| radiance.is_finite()));
//! # Ok(()) }
//! ```
//!
//! `examples/render_scene.rs` writes the image, too. A scene can also be described in code: see
//! [`scene::SceneDesc`].
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers; a test reads this list and checks it.
//! From 7 on it is the order of the method. Start reading at [`integrators::many_light`].
//!
//! ```text
//! 15 prelude
//! 14 render
//! 13 integrators
//! 12 gather
//! 11 light_tree
//! 10 virtual_lights
//!  9 maps
//!  8 particles
//!  7 transport
//!  6 scene
//!  5 bsdf emitters sensors
//!  4 texture
//!  3 geometry film
//!  2 sampling
//!  1 image stats lanes arrays
//!  0 math color ids simd
//! ```

pub mod math;

pub mod color;

pub mod image;

pub mod ids;

pub mod arrays;

mod simd;
pub use simd::{instruction_set, select_instruction_set};

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

pub mod prelude;

#[cfg(any(test, feature = "testing"))]
pub mod testing;
