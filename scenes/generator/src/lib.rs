//! Generators of manylight's own scenes: a corridor, a kitchen, a garage and a disco.
//!
//! Each generator is a function from a level of [detail](scenes::Detail) to a [`scene::Scene`],
//! which is plain data. [`files`] turns a scene into a folder: a Mitsuba 3 XML file and a PBRT v4
//! file, which share binary PLY meshes and PNG textures, or a glTF 2.0 file.
//!
//! * The same call gives the same bytes on every platform: generators draw from a fixed random
//!   sequence ([`pcg`]), and all written numbers are rounded to a coarse step ([`rounding`]).
//! * Units are meters and degrees; y points up; colors are linear RGB with sRGB primaries.
//! * The crate does not depend on the renderer.
//!
//! ```
//! use manylight_scenes::files::{self, Format};
//! use manylight_scenes::scenes::{Detail, generator_named};
//!
//! let generator = generator_named("u-shape").expect("a known name");
//! let scene = (generator.generate)(Detail::default());
//! assert!(scene.triangle_count() > 40_000);
//!
//! // `files::write` writes the same files into a folder.
//! let files = files::of(&scene, &[Format::Mitsuba])?;
//! assert_eq!(files[0].0.to_str(), Some("scene.xml"));
//! # Ok::<(), std::io::Error>(())
//! ```

pub mod build;
pub mod files;
pub mod fresnel;
pub mod gltf;
mod head;
pub mod material;
pub mod mesh;
pub mod mitsuba;
pub mod noise;
pub mod pbrt;
pub mod pcg;
pub mod ply;
pub mod png;
pub mod pose;
pub mod rounding;
pub mod scene;
pub mod scenes;
#[cfg(test)]
mod testing;
