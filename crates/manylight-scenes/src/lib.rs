//! Generators of manylight's own scenes. Each is a function from a level of detail to a [`scene::Scene`], plain data that
//! [`files`] turns into a folder; the same call gives the same bytes on every platform.

pub mod build;
pub mod files;
pub mod material;
pub mod mesh;
pub mod mitsuba;
pub mod pcg;
pub mod picture;
pub mod ply;
pub mod pose;
pub mod rounding;
pub mod scene;
pub mod scenes;
