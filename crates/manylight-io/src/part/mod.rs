//! Part files: sums of some passes of a render, to be merged or continued without a change of bits.
//!
//! A part file is a [safetensors](https://github.com/huggingface/safetensors) file, so that other
//! programs can read its arrays. In its header, `__metadata__` has two entries. `manylight.part` is
//! a JSON object:
//!
//! | key | content |
//! |---|---|
//! | `format` | version of this layout, [`FORMAT`] |
//! | `render` | what decides about the bits of a render (name: value): parts of one render agree in all of it |
//! | `film` | `size`, `crop_offset`, `crop_size`, names of the `layers` and `id_layers`, passes of a `block`, whether passes continue `sequences` of samples |
//! | `state` | what a resumed render continues with: seconds of the stages, counts |
//! | `picture` | what image files say about the render: metadata, names of objects and materials, the camera |
//!
//! `manylight.sha256` is the SHA-256 of the whole file in hexadecimal digits, taken with 64 zeros
//! in the place of the digits.
//!
//! Arrays are those of [`manylight::film::arrays`], little-endian `F64` and `U32` in row order.
//! Their names begin with a group: `block.K.` for blocks of passes; `completed.` and `current.` for
//! a checkpoint.

mod header;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use crate::replace::check_regular as check_part_writable;
pub use header::{PartFilm, PartHeader};
pub use read::PartFile;
pub use write::write_part;

/// Version of the layout.
pub const FORMAT: u32 = 1;
/// Key of the header in the metadata of a file.
const HEADER_KEY: &str = "manylight.part";
/// Key of the checksum.
const DIGEST_KEY: &str = "manylight.sha256";
/// Hexadecimal digits of the checksum.
const DIGEST_DIGITS: usize = 64;
/// Bytes that are read or written at once.
const BUFFER: usize = 1 << 20;
/// Bytes before the header: its length.
const LENGTH_BYTES: usize = 8;
