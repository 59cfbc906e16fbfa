//! Checks of the bytes that the chunks of an EXR file declare. The decoder takes memory for them before it reads them.

use super::exr_file::damaged;
use crate::file_error::Fault;
use exr::io::PeekRead;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use std::io::Cursor;

/// Bytes of the fields before the size of a chunk: the first row of scan lines, or the four coordinates of a tile.
const SCAN_LINE_FIELDS: usize = 4;
const TILE_FIELDS: usize = 16;
/// Bytes of the number of the part, in files with several.
const PART_FIELD: usize = 4;

/// The headers of the content of a file, after its chunks were found to end within the file.
///
/// # Errors
/// A header or the table of chunks cannot be read, or a chunk is longer than the rest of the file.
pub(super) fn read_headers(bytes: &[u8]) -> Result<MetaData, Fault> {
    let mut cursor = Cursor::new(bytes);
    let meta = MetaData::read_from_buffered(&mut cursor, false).map_err(damaged)?;
    let tables = MetaData::read_offset_tables(&mut PeekRead::new(cursor), &meta.headers);
    for start in tables.map_err(damaged)?.into_iter().flatten() {
        check_chunk(bytes, start, &meta)?;
    }
    Ok(meta)
}

/// Checks the chunk that begins at byte `start`. The decoder finds other faults before it takes memory.
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

/// Bytes between the number of the part and the size of a chunk; `None` for deep images, which are not decoded.
fn fields_of(header: &Header) -> Option<usize> {
    match header.blocks {
        _ if header.deep => None,
        BlockDescription::ScanLines => Some(SCAN_LINE_FIELDS),
        BlockDescription::Tiles(_) => Some(TILE_FIELDS),
    }
}
