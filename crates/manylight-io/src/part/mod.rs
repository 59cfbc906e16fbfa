//! Files of arrays: part files and kept virtual lights.
//!
//! A part file holds sums of some passes of a render, to be merged or continued without a change of
//! bits. It is a [safetensors](https://github.com/huggingface/safetensors) file, so that other
//! programs can read its arrays. In its header, `__metadata__` has two entries. `manylight.part` is
//! a JSON object:
//!
//! | key | content |
//! |---|---|
//! | `format` | version of this layout, [`FORMAT`] |
//! | `render` | what decides about the bits of a render (name: value): parts of one render agree in all of it |
//! | `film` | `size`, `crop_offset`, `crop_size`, names of the `layers` and `id_layers`, passes of a `block` |
//! | `state` | what a resumed render continues with: seconds of the stages, counts |
//! | `picture` | what image files say about the render: metadata, names of objects and materials, the camera |
//!
//! `manylight.sha256` is the SHA-256 of the whole file in hexadecimal digits, taken with 64 zeros
//! in the place of the digits.
//!
//! Arrays are those of [`manylight::film::arrays`], little-endian `F64`, `F32` and `U32` in row
//! order. Their names begin with a group: `block.K.` for blocks of passes; `completed.` and
//! `current.` for a checkpoint.
//!
//! A file of kept lights has the entry `manylight.lights` instead: a [`LightsHeader`]. Its arrays,
//! `F32` and `U32`, are those of [`KeptLights::arrays`]; `group.K.` begins the names of a group of
//! passes. docs/kept_lights.md lists them.
//!
//! [`KeptLights::arrays`]: manylight::integrators::KeptLights::arrays

mod array_file;
mod header;
mod lights;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use crate::replace::check_regular as check_part_writable;
pub use header::{PartFilm, PartHeader};
pub use lights::{LightsFile, LightsHeader, write_lights};
pub use read::PartFile;
pub use write::{ArrayGroups, write_part};

/// Version of the layout of part files.
pub const FORMAT: u32 = 2;
