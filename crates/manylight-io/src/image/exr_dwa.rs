//! Checks of EXR chunks that are compressed by DWAA or DWAB. The decoder takes memory by the counters of a chunk before it compares them
//! with the pixels of the chunk.

use super::exr_file::damaged;
use crate::file_error::Fault;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::meta::header::Header;
use exr::prelude::Compression;
use std::io::Cursor;

/// Whether chunks of this part are compressed by DWA.
pub(super) fn is_dwa(header: &Header) -> bool {
    matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    )
}

/// Checks the counters of all chunks in the content of a file.
///
/// # Errors
/// A chunk cannot be read, or has a counter that does not fit its pixels.
pub(super) fn check_chunks(bytes: &[u8]) -> Result<(), Fault> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let headers = reader.headers().to_vec();
    let chunks = reader
        .filter_chunks(false, |_, _, _| true)
        .map_err(damaged)?;
    for chunk in chunks {
        let chunk = chunk.map_err(damaged)?;
        let header = headers
            .get(chunk.layer_index)
            .filter(|header| is_dwa(header));
        header.map_or(Ok(()), |header| check_chunk(header, &chunk))?;
    }
    Ok(())
}

fn check_chunk(header: &Header, chunk: &Chunk) -> Result<(), Fault> {
    /// Counters of sizes and numbers, after the version. The one after them names a method.
    const COUNTERS: usize = 9;
    /// How much counters may exceed the bytes of the pixels, as a factor and by bytes: blocks are padded to 8 x 8 pixels, and runs may be
    /// longer than what they stand for.
    const FACTOR: u64 = 8;
    const ALWAYS_ALLOWED: u64 = 1 << 16;
    let data = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let place = header
        .get_block_data_indices(&chunk.compressed_block)
        .and_then(|indices| header.get_absolute_block_pixel_coordinates(indices))
        .map_err(damaged)?;
    let decoded = place.size.area() as u64 * header.channels.bytes_per_pixel as u64;
    // Such chunks are not compressed.
    if data.len() as u64 == decoded {
        return Ok(());
    }
    let counters = data
        .as_chunks::<8>()
        .0
        .iter()
        .map(|b| u64::from_le_bytes(*b));
    let most = decoded
        .saturating_mul(FACTOR)
        .saturating_add(ALWAYS_ALLOWED);
    match counters
        .skip(1)
        .take(COUNTERS)
        .find(|&counter| counter > most)
    {
        Some(counter) => Err(Fault::new(format!(
            "the EXR image cannot be decoded: a chunk of {decoded} bytes of pixels declares {counter} bytes"
        ))),
        None => Ok(()),
    }
}
