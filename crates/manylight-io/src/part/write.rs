//! Writing of part files, array by array.

use super::array_file::{BUFFER, DIGEST_DIGITS, DIGEST_KEY, Kind};
use super::header::{PART, PartHeader};
use crate::file_error::FileError;
use crate::hex::hex;
use crate::replace::replace;
use manylight::arrays::{ArrayKind, ArrayValues, NamedArray};
use safetensors::tensor::{Dtype, Metadata, TensorInfo};
use serde::Serialize;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Groups of arrays, each with the prefix of its names.
pub type ArrayGroups<'g> = [(String, Vec<NamedArray<'g>>)];

/// Writes a part file. It is replaced as a whole or not at all. One array is in memory at a time.
///
/// # Errors
/// The file cannot be written.
pub fn write_part(path: &Path, header: &PartHeader, groups: &ArrayGroups) -> Result<(), FileError> {
    write_arrays(path, PART, header, groups)
}

/// Writes a file of `kind`, as [`write_part`] does.
pub(super) fn write_arrays(
    path: &Path,
    kind: Kind,
    header: &impl Serialize,
    groups: &ArrayGroups,
) -> Result<(), FileError> {
    let mut sorted: Vec<(String, &NamedArray)> = Vec::new();
    for (prefix, arrays) in groups {
        sorted.extend(
            arrays
                .iter()
                .map(|array| (format!("{prefix}{}", array.name), array)),
        );
    }
    // Values of eight bytes first, so that every array is aligned.
    sorted.sort_by_key(|(_, array)| array.kind() != ArrayKind::F64);
    let write = || -> io::Result<()> {
        let head = head(kind, header, &sorted)?;
        replace(path, |file| write_file(file, &head, &sorted))
    };
    write().map_err(|error| FileError::unwritable(path, error))
}

/// Length and JSON of the header, with zeros as checksum.
fn head(
    kind: Kind,
    header: &impl Serialize,
    arrays: &[(String, &NamedArray)],
) -> io::Result<Vec<u8>> {
    let metadata = HashMap::from([
        (kind.key.to_owned(), serde_json::to_string(header)?),
        (DIGEST_KEY.to_owned(), "0".repeat(DIGEST_DIGITS)),
    ]);
    let mut end = 0;
    let infos = arrays.iter().map(|(name, array)| {
        let dtype = match array.kind() {
            ArrayKind::F64 => Dtype::F64,
            ArrayKind::F32 => Dtype::F32,
            ArrayKind::U32 => Dtype::U32,
        };
        let start = end;
        end += array.count() * array.kind().bytes();
        let info = TensorInfo {
            dtype,
            shape: array.shape.clone(),
            data_offsets: (start, end),
        };
        (name.clone(), info)
    });
    let metadata = Metadata::new(Some(metadata), infos.collect()).map_err(io::Error::other)?;
    // The entries of the metadata come in an order that differs from run to run.
    let mut value = serde_json::to_value(&metadata)?;
    if let Some(Value::Object(entries)) = value.get_mut("__metadata__") {
        entries.sort_keys();
    }
    let mut json = serde_json::to_vec(&value)?;
    json.resize(json.len().next_multiple_of(8), b' ');
    let mut head = (json.len() as u64).to_le_bytes().to_vec();
    head.append(&mut json);
    Ok(head)
}

fn write_file(file: &mut File, head: &[u8], arrays: &[(String, &NamedArray)]) -> io::Result<()> {
    let mut digest = Sha256::new();
    let mut out = BufWriter::with_capacity(BUFFER, &mut *file);
    let mut put = |bytes: &[u8]| {
        digest.update(bytes);
        out.write_all(bytes)
    };
    put(head)?;
    for (_, array) in arrays {
        put(&little_endian(array.values()))?;
    }
    out.flush()?;
    drop(out);
    let place = super::array_file::digest_place(head)
        .ok_or_else(|| io::Error::other("the header has no checksum"))?;
    file.seek(SeekFrom::Start(place as u64))?;
    file.write_all(hex(&digest.finalize()).as_bytes())
}

fn little_endian(values: ArrayValues) -> Vec<u8> {
    match values {
        ArrayValues::F64(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ArrayValues::F32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ArrayValues::U32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
    }
}
