//! safetensors files with a checksum and a header of ours: opened, verified, read array by array.

use crate::file_error::{Fault, FileError};
use crate::hex::hex;
use crate::read::open_regular;
use manylight::arrays::{ArrayValues, FoundArray, InvalidArray};
use safetensors::tensor::{Dtype, Metadata};
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Key of the checksum.
pub(super) const DIGEST_KEY: &str = "manylight.sha256";
/// Hexadecimal digits of the checksum.
pub(super) const DIGEST_DIGITS: usize = 64;
/// Bytes that are read or written at once.
pub(super) const BUFFER: usize = 1 << 20;
/// Bytes before the header: its length.
const LENGTH_BYTES: usize = 8;
/// Longest header that is read: a part with a thousand blocks has one of 3 MB.
const MAX_HEADER: u64 = 100 << 20;

/// What a file holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind {
    /// Key of the header in the metadata.
    pub(super) key: &'static str,
    /// Version of the layout.
    pub(super) format: u32,
    /// In messages, such as "a part of a render".
    pub(super) name: &'static str,
}

/// A file of arrays with its header in memory. The file is open only while it is read: a merge may
/// have more parts than a process may have open files.
#[derive(Debug)]
pub(super) struct ArrayFile {
    path: PathBuf,
    /// Length and JSON of the header, with zeros as checksum.
    head: Vec<u8>,
    /// The checksum that the file states.
    digest: String,
    /// Where the file states it, in bytes.
    digest_place: usize,
    arrays: Metadata,
}

impl ArrayFile {
    /// Reads the header of a file of `kind`. The arrays are not read: see [`ArrayFile::verify`].
    ///
    /// # Errors
    /// The file cannot be read, or is none of this kind and version.
    pub(super) fn open<H: DeserializeOwned>(
        path: &Path,
        kind: Kind,
    ) -> Result<(Self, H), FileError> {
        let (mut file, length) =
            open_regular(path).map_err(|error| FileError::unreadable(path, error))?;
        let mut head = read_head(&mut file, length, kind).map_err(|fault| fault.in_file(path))?;
        let fault = |message: String| Fault::new(message).in_file(path);
        let json = &head[LENGTH_BYTES..];
        let arrays: Metadata = serde_json::from_slice(json)
            .map_err(|error| fault(format!("the header is damaged: {error}")))?;
        let data = length - head.len() as u64;
        if arrays.data_len() as u64 != data {
            return Err(fault(format!(
                "found {data} bytes of arrays, expected {}: the file is damaged",
                arrays.data_len()
            )));
        }
        let entry = |key: &str| {
            arrays
                .metadata()
                .as_ref()
                .and_then(|entries| entries.get(key))
        };
        let Some(header) = entry(kind.key) else {
            return Err(fault(format!(
                "found a safetensors file without the entry {}, expected {}",
                kind.key, kind.name
            )));
        };
        let header = parse_header(header, kind).map_err(fault)?;
        let digest = entry(DIGEST_KEY).cloned().unwrap_or_default();
        let Some(place) = digest_place(&head).filter(|_| digest.len() == DIGEST_DIGITS) else {
            return Err(fault("found no checksum: the file is damaged".into()));
        };
        head[place..place + DIGEST_DIGITS].fill(b'0');
        let opened = ArrayFile {
            path: path.into(),
            head,
            digest,
            digest_place: place,
            arrays,
        };
        Ok((opened, header))
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The checksum.
    pub(super) fn digest(&self) -> &str {
        &self.digest
    }

    /// Prefixes of the names of arrays, one per group with an array `passes`, in the order of their
    /// place in the file.
    pub(super) fn groups(&self) -> Vec<String> {
        let names = self.arrays.offset_keys().into_iter();
        names
            .filter_map(|name| Some(name.strip_suffix("passes")?.to_owned()))
            .collect()
    }

    /// The shape of an array; `None` if there is none of this name.
    pub(super) fn shape(&self, name: &str) -> Option<&[usize]> {
        self.arrays.info(name).map(|info| info.shape.as_slice())
    }

    /// Opens the file again.
    ///
    /// # Errors
    /// The file cannot be read, or another one has taken its place: the checksum is compared.
    pub(super) fn reopen(&self) -> io::Result<File> {
        let (mut file, _) = open_regular(&self.path)?;
        file.seek(SeekFrom::Start(self.digest_place as u64))?;
        let mut digest = [0; DIGEST_DIGITS];
        file.read_exact(&mut digest)?;
        if digest == *self.digest.as_bytes() {
            Ok(file)
        } else {
            Err(io::Error::other("it was replaced while it was read"))
        }
    }

    /// Compares the checksum: reads the whole file.
    ///
    /// # Errors
    /// The file cannot be read, or is damaged.
    pub(super) fn verify(&self) -> Result<(), FileError> {
        let mut digest = Sha256::new();
        digest.update(&self.head);
        let mut update = || -> io::Result<()> {
            let mut file = self.reopen()?;
            file.seek(SeekFrom::Start(self.head.len() as u64))?;
            let mut buffer = vec![0; BUFFER];
            loop {
                match file.read(&mut buffer)? {
                    0 => return Ok(()),
                    count => digest.update(&buffer[..count]),
                }
            }
        };
        update().map_err(|error| FileError::unreadable(&self.path, error))?;
        if hex(&digest.finalize()) == self.digest {
            Ok(())
        } else {
            Err(FileError::malformed(
                &self.path,
                "the checksum does not fit the content: the file is damaged",
            ))
        }
    }

    /// Reads an array from `file`.
    pub(super) fn array(&self, mut file: &File, name: &str) -> Result<FoundArray, ArrayError> {
        let missing = || ArrayError::Content(format!("array {name} is missing"));
        let info = self.arrays.info(name).ok_or_else(missing)?;
        let (start, end) = info.data_offsets;
        file.seek(SeekFrom::Start((self.head.len() + start) as u64))?;
        let mut bytes = vec![0; end - start];
        file.read_exact(&mut bytes)?;
        let values = match info.dtype {
            Dtype::F64 => {
                let values = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b));
                ArrayValues::F64(values.collect())
            }
            Dtype::F32 => {
                let values = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b));
                ArrayValues::F32(values.collect())
            }
            Dtype::U32 => {
                let values = bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
                ArrayValues::U32(values.collect())
            }
            other => {
                return Err(ArrayError::Content(format!(
                    "array {name}: found the type {other:?}, expected F64, F32 or U32"
                )));
            }
        };
        Ok((info.shape.clone(), values))
    }

    /// `read`, with the path in its error.
    pub(super) fn read<T>(
        &self,
        read: impl FnOnce() -> Result<T, ArrayError>,
    ) -> Result<T, FileError> {
        read().map_err(|error| match error {
            ArrayError::Io(error) => FileError::unreadable(&self.path, error),
            ArrayError::Content(message) => FileError::malformed(&self.path, message),
        })
    }
}

/// Why arrays cannot be used, before the path is added.
pub(super) enum ArrayError {
    Io(io::Error),
    Content(String),
}

impl From<io::Error> for ArrayError {
    fn from(error: io::Error) -> Self {
        ArrayError::Io(error)
    }
}

impl From<InvalidArray> for ArrayError {
    fn from(error: InvalidArray) -> Self {
        ArrayError::Content(error.to_string())
    }
}

/// Length and JSON of the header of a file of `length` bytes.
fn read_head(file: &mut File, length: u64, kind: Kind) -> Result<Vec<u8>, Fault> {
    let cut = || {
        Fault::new(format!(
            "found {length} bytes, expected {}: the file is damaged or of another kind",
            kind.name
        ))
    };
    let mut head = vec![0; LENGTH_BYTES];
    file.read_exact(&mut head).map_err(|_| cut())?;
    let json = u64::from_le_bytes(head.as_slice().try_into().map_err(|_| cut())?);
    if json > MAX_HEADER || json > length.saturating_sub(LENGTH_BYTES as u64) {
        return Err(cut());
    }
    head.resize(LENGTH_BYTES + json as usize, 0);
    file.read_exact(&mut head[LENGTH_BYTES..])
        .map_err(|_| cut())?;
    Ok(head)
}

fn parse_header<H: DeserializeOwned>(text: &str, kind: Kind) -> Result<H, String> {
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|error| format!("the header is damaged: {error}"))?;
    match value.get("format").and_then(serde_json::Value::as_u64) {
        Some(format) if format == u64::from(kind.format) => {}
        Some(format) => {
            return Err(format!(
                "found {} of format {format}; this version reads format {}",
                kind.name, kind.format
            ));
        }
        None => return Err("the header states no format: the file is damaged".into()),
    }
    serde_json::from_value(value).map_err(|error| format!("the header is damaged: {error}"))
}

/// Where the digits of the checksum are in the head of a file.
pub(super) fn digest_place(head: &[u8]) -> Option<usize> {
    let key = format!("\"{DIGEST_KEY}\":\"");
    let start = head
        .windows(key.len())
        .position(|window| window == key.as_bytes())?
        + key.len();
    (start + DIGEST_DIGITS <= head.len()).then_some(start)
}
