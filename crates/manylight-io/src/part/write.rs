//! Writing of part files, array by array.

use super::{BUFFER, DIGEST_DIGITS, DIGEST_KEY, HEADER_KEY, PartHeader};
use crate::file_error::FileError;
use crate::hex::hex;
use crate::replace::replace;
use manylight::film::arrays::{ArrayValues, SumArray};
use safetensors::tensor::{Dtype, Metadata, TensorInfo};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Writes a part file with groups of arrays, each with the prefix of its names. The file is
/// replaced as a whole or not at all. One array is in memory at a time.
///
/// # Errors
/// The file cannot be written.
pub fn write_part<'g>(
    path: &Path,
    header: &PartHeader,
    groups: &'g [(String, Vec<SumArray<'g>>)],
) -> Result<(), FileError> {
    let named = |(prefix, arrays): &'g (String, Vec<SumArray<'g>>)| {
        let arrays = arrays.iter();
        arrays.map(move |array| (format!("{prefix}{}", array.name), array))
    };
    let mut sorted: Vec<(String, &SumArray)> = groups.iter().flat_map(named).collect();
    // Values of eight bytes first, so that every array is aligned.
    sorted.sort_by_key(|(_, array)| !array.is_float());
    let write = || -> io::Result<()> {
        let head = head(header, &sorted)?;
        replace(path, |file| write_file(file, &head, &sorted))
    };
    write().map_err(|error| FileError::unwritable(path, error))
}

/// Length and JSON of the header, with zeros as checksum.
fn head(header: &PartHeader, arrays: &[(String, &SumArray)]) -> io::Result<Vec<u8>> {
    let metadata = HashMap::from([
        (HEADER_KEY.to_owned(), serde_json::to_string(header)?),
        (DIGEST_KEY.to_owned(), "0".repeat(DIGEST_DIGITS)),
    ]);
    let mut end = 0;
    let infos = arrays.iter().map(|(name, array)| {
        let (dtype, bytes) = if array.is_float() {
            (Dtype::F64, 8)
        } else {
            (Dtype::U32, 4)
        };
        let start = end;
        end += array.count() * bytes;
        let info = TensorInfo {
            dtype,
            shape: array.shape.clone(),
            data_offsets: (start, end),
        };
        (name.clone(), info)
    });
    let metadata = Metadata::new(Some(metadata), infos.collect()).map_err(io::Error::other)?;
    let mut json = serde_json::to_vec(&metadata)?;
    json.resize(json.len().next_multiple_of(8), b' ');
    let mut head = (json.len() as u64).to_le_bytes().to_vec();
    head.append(&mut json);
    Ok(head)
}

fn write_file(file: &mut File, head: &[u8], arrays: &[(String, &SumArray)]) -> io::Result<()> {
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
    let place = super::read::digest_place(head)
        .ok_or_else(|| io::Error::other("the header has no checksum"))?;
    file.seek(SeekFrom::Start(place as u64))?;
    file.write_all(hex(&digest.finalize()).as_bytes())
}

fn little_endian(values: ArrayValues) -> Vec<u8> {
    match values {
        ArrayValues::F64(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ArrayValues::U32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
    }
}
