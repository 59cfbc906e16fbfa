//! Reading of part files: the header first, then array by array.

use super::{BUFFER, DIGEST_DIGITS, DIGEST_KEY, FORMAT, HEADER_KEY, LENGTH_BYTES, PartHeader};
use crate::file_error::{Fault, FileError};
use crate::hex::hex;
use crate::read::open_regular;
use manylight::film::arrays::{ArrayValues, InvalidArray, sums_of_arrays};
use manylight::film::{Film, PassSums};
use safetensors::tensor::{Dtype, Metadata};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Longest header that is read: a part with a thousand blocks has one of 3 MB.
const MAX_HEADER: u64 = 100 << 20;

/// A part file with its header in memory. The file is open only while it is read: a merge may have
/// more parts than a process may have open files.
#[derive(Debug)]
pub struct PartFile {
    path: PathBuf,
    /// Length and JSON of the header, with zeros as checksum.
    head: Vec<u8>,
    /// The checksum that the file states.
    digest: String,
    /// Where the file states it, in bytes.
    digest_place: usize,
    arrays: Metadata,
    header: PartHeader,
}

impl PartFile {
    /// Reads the header of a file. The arrays are not read: see [`PartFile::verify`].
    ///
    /// # Errors
    /// The file cannot be read, or is no part file of this version.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let (mut file, length) =
            open_regular(path).map_err(|error| FileError::unreadable(path, error))?;
        let mut head = read_head(&mut file, length).map_err(|fault| fault.in_file(path))?;
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
        let Some(header) = entry(HEADER_KEY) else {
            return Err(fault("found a safetensors file without the entry manylight.part, expected a part of a render".into()));
        };
        let header = parse_header(header).map_err(fault)?;
        let digest = entry(DIGEST_KEY).cloned().unwrap_or_default();
        let Some(place) = digest_place(&head).filter(|_| digest.len() == DIGEST_DIGITS) else {
            return Err(fault("found no checksum: the file is damaged".into()));
        };
        head[place..place + DIGEST_DIGITS].fill(b'0');
        Ok(PartFile {
            path: path.into(),
            head,
            digest,
            digest_place: place,
            arrays,
            header,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The header.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Prefixes of the names of arrays, one per sums of passes.
    pub fn groups(&self) -> Vec<String> {
        let names = self.arrays.offset_keys().into_iter();
        names
            .filter_map(|name| Some(name.strip_suffix("passes")?.to_owned()))
            .collect()
    }

    /// Opens the file again.
    ///
    /// # Errors
    /// The file cannot be read, or another one has taken its place: the checksum is compared.
    fn file(&self) -> io::Result<File> {
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
    pub fn verify(&self) -> Result<(), FileError> {
        let mut digest = Sha256::new();
        digest.update(&self.head);
        let mut update = || -> io::Result<()> {
            let mut file = self.file()?;
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

    /// An empty film of the size and layers of the header; `group` is one of its groups.
    ///
    /// # Errors
    /// The header contradicts itself, or names a layer that this version does not know.
    pub fn film(&self, group: &str) -> Result<Film, FileError> {
        let film = &self.header.film;
        let [width, height] = film.crop_size.map(|n| n as usize);
        // The file has this many pixels: memory for a film is taken after this check.
        let name = format!("{group}sum.beauty");
        if self
            .arrays
            .info(&name)
            .is_none_or(|info| info.shape != [height, width, 3])
        {
            let message = format!(
                "array {name} does not have {width} x {height} pixels: the file is damaged"
            );
            return Err(FileError::malformed(&self.path, message));
        }
        film.film()
            .map_err(|message| FileError::malformed(&self.path, message))
    }

    /// The sums of a group of arrays, for `film`.
    ///
    /// # Errors
    /// The file cannot be read, or the arrays are missing or do not fit.
    pub fn sums(&self, group: &str, film: &Film) -> Result<PassSums, FileError> {
        let sums = || -> Result<PassSums, PartError> {
            let file = self.file()?;
            let read =
                |name: &str, shape: &[usize]| self.array(&file, &format!("{group}{name}"), shape);
            sums_of_arrays(film, read)
        };
        sums().map_err(|error| match error {
            PartError::Io(error) => FileError::unreadable(&self.path, error),
            PartError::Content(message) => FileError::malformed(&self.path, message),
        })
    }

    fn array(
        &self,
        mut file: &File,
        name: &str,
        shape: &[usize],
    ) -> Result<ArrayValues, PartError> {
        let missing = || PartError::Content(format!("array {name} is missing"));
        let info = self.arrays.info(name).ok_or_else(missing)?;
        if info.shape != shape {
            return Err(PartError::Content(format!(
                "array {name}: found the shape {:?}, expected {shape:?}",
                info.shape
            )));
        }
        let (start, end) = info.data_offsets;
        file.seek(SeekFrom::Start((self.head.len() + start) as u64))?;
        let mut bytes = vec![0; end - start];
        file.read_exact(&mut bytes)?;
        match info.dtype {
            Dtype::F64 => {
                let values = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b));
                Ok(ArrayValues::F64(values.collect()))
            }
            Dtype::U32 => {
                let values = bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
                Ok(ArrayValues::U32(values.collect()))
            }
            other => Err(PartError::Content(format!(
                "array {name}: found the type {other:?}, expected F64 or U32"
            ))),
        }
    }
}

/// Why sums cannot be read, before the path is added.
enum PartError {
    Io(io::Error),
    Content(String),
}

impl From<io::Error> for PartError {
    fn from(error: io::Error) -> Self {
        PartError::Io(error)
    }
}

impl From<InvalidArray> for PartError {
    fn from(error: InvalidArray) -> Self {
        PartError::Content(error.to_string())
    }
}

/// Length and JSON of the header of a file of `length` bytes.
fn read_head(file: &mut File, length: u64) -> Result<Vec<u8>, Fault> {
    let cut = || {
        Fault::new(format!(
            "found {length} bytes, expected a part of a render: the file is damaged or of another kind"
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

fn parse_header(text: &str) -> Result<PartHeader, String> {
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|error| format!("the header is damaged: {error}"))?;
    match value.get("format").and_then(serde_json::Value::as_u64) {
        Some(format) if format == u64::from(FORMAT) => {}
        Some(format) => {
            return Err(format!(
                "found a part file of format {format}; this version reads format {FORMAT}"
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
