//! Checks of EXR files before they are decoded: of the sizes that their headers declare, and of the
//! bytes that their chunks declare. The decoder takes memory for both before it reads them.

use super::size_check::check_size;
use crate::file_error::Fault;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::io::PeekRead;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::Compression;
use std::io::Cursor;

pub(super) fn damaged(error: exr::error::Error) -> Fault {
    Fault::new(format!("the EXR image cannot be decoded: {error}"))
}

/// Rejects the compressions of OpenEXR 3.4 and later, by the first attribute `compression`. The
/// decoder calls their chunks invalid.
fn check_compression(bytes: &[u8]) -> Result<(), Fault> {
    /// Name, type and size of the attribute.
    const ATTRIBUTE: &[u8] = b"compression\0compression\0\x01\0\0\0";
    /// Bytes of the headers that are searched.
    const SEARCHED: usize = 1 << 16;
    /// The number of DWAB, the last of the compressions that are read.
    const LAST: u8 = 9;
    let start = &bytes[..bytes.len().min(SEARCHED)];
    let found = start.windows(ATTRIBUTE.len()).position(|w| w == ATTRIBUTE);
    match found.and_then(|at| bytes.get(at + ATTRIBUTE.len())) {
        Some(number) if *number > LAST => Err(Fault::new(format!(
            "the EXR image has compression number {number}, a newer one (HTJ2K, LJ2K, ZSTD: OpenEXR 3.4 and later), which is not read; write it with ZIP, PIZ or DWA"
        ))),
        _ => Ok(()),
    }
}

/// Rejects headers that declare more samples than the file can contain, and chunks that are longer
/// than the file, before anything is allocated.
pub(super) fn check_headers(bytes: &[u8]) -> Result<(), Fault> {
    /// Most decoded bytes per byte of a file: those of PXR24, which stores three of the four bytes
    /// of a float by deflate, which expands 1032 times.
    const EXPANSION: u32 = 1032 * 4 / 3;
    /// That of DWA, which stores a number for 64 pixels. Images of one color may exceed it.
    const DWA_EXPANSION: u32 = 1 << 15;
    check_compression(bytes)?;
    let meta = read_headers(bytes)?;
    let is_dwa = meta.headers.iter().any(is_dwa);
    let expansion = if is_dwa { DWA_EXPANSION } else { EXPANSION };
    let mut decoded = 0;
    for header in &meta.headers {
        let size = header.layer_size;
        let channels = header.channels.list.iter();
        let pixel: usize = channels.map(|c| c.sample_type.bytes_per_sample()).sum();
        decoded += size.width() as u128 * size.height() as u128 * pixel as u128;
        check_size(
            [size.width(), size.height()],
            decoded,
            bytes.len(),
            expansion,
        )?;
    }
    if is_dwa {
        check_dwa_chunks(bytes)?;
    }
    Ok(())
}

/// Bytes of the fields before the size of a chunk: the first row of scan lines, or the four
/// coordinates of a tile.
const SCAN_LINE_FIELDS: usize = 4;
const TILE_FIELDS: usize = 16;
/// Bytes of the number of the part, in files with several.
const PART_FIELD: usize = 4;

/// The headers of the content of a file, after its chunks were found to end within the file.
///
/// # Errors
/// A header or the table of chunks cannot be read, or a chunk is longer than the rest of the file.
fn read_headers(bytes: &[u8]) -> Result<MetaData, Fault> {
    let mut cursor = Cursor::new(bytes);
    let meta = MetaData::read_from_buffered(&mut cursor, false).map_err(damaged)?;
    let tables = MetaData::read_offset_tables(&mut PeekRead::new(cursor), &meta.headers);
    for start in tables.map_err(damaged)?.into_iter().flatten() {
        check_chunk(bytes, start, &meta)?;
    }
    Ok(meta)
}

/// Checks the chunk that begins at byte `start`. The decoder finds other faults before it takes
/// memory.
fn check_chunk(bytes: &[u8], start: u64, meta: &MetaData) -> Result<(), Fault> {
    let number = |at: usize| {
        let field = bytes.get(at..)?.first_chunk()?;
        usize::try_from(i32::from_le_bytes(*field)).ok()
    };
    let declared = || {
        let start = usize::try_from(start).ok()?;
        let (part, fields) = if meta.requirements.is_multilayer() {
            (number(start)?, start.checked_add(PART_FIELD)?)
        } else {
            (0, start)
        };
        let at = fields.checked_add(fields_of(meta.headers.get(part)?)?)?;
        Some((number(at)?, bytes.len() - at - 4))
    };
    match declared() {
        Some((size, rest)) if size > rest => Err(Fault::new(format!(
            "the EXR image cannot be decoded: the chunk at byte {start} declares {size} bytes, more than the {rest} that follow"
        ))),
        _ => Ok(()),
    }
}

/// Bytes between the number of the part and the size of a chunk; `None` for deep images, which are
/// not decoded.
fn fields_of(header: &Header) -> Option<usize> {
    match header.blocks {
        _ if header.deep => None,
        BlockDescription::ScanLines => Some(SCAN_LINE_FIELDS),
        BlockDescription::Tiles(_) => Some(TILE_FIELDS),
    }
}

/// Whether chunks of this part are compressed by DWA.
fn is_dwa(header: &Header) -> bool {
    matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    )
}

/// Checks the counters of all chunks in the content of a file. The decoder takes memory by them
/// before it compares them with the pixels of the chunk.
///
/// # Errors
/// A chunk cannot be read, or has a counter that does not fit its pixels.
fn check_dwa_chunks(bytes: &[u8]) -> Result<(), Fault> {
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
        header.map_or(Ok(()), |header| check_dwa_chunk(header, &chunk))?;
    }
    Ok(())
}

fn check_dwa_chunk(header: &Header, chunk: &Chunk) -> Result<(), Fault> {
    /// Counters of sizes and numbers, after the version. The one after them names a method.
    const COUNTERS: usize = 9;
    /// How much counters may exceed the bytes of the pixels, as a factor and by bytes: blocks are
    /// padded to 8 x 8 pixels, and runs may be longer than what they stand for.
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
