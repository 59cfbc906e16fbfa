//! The two containers of glTF: JSON text, and binary files (`.glb`) with a JSON chunk and a chunk
//! of data.

use crate::file_error::Fault;

/// The first bytes of a binary file.
pub(in crate::scene) const MAGIC: &[u8] = b"glTF";

const JSON_CHUNK: u32 = 0x4E4F_534A;
const DATA_CHUNK: u32 = 0x004E_4942;

/// Sizes in bytes of the header of a binary file, and of that of a chunk.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// The parts of a file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// JSON text.
    pub(super) json: &'a [u8],
    /// The data chunk of a binary file.
    pub(super) data: Option<&'a [u8]>,
    /// Whether the file is binary.
    pub(super) is_binary: bool,
}

impl<'a> Container<'a> {
    /// The parts of the file content `bytes`.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Fault> {
        if bytes.starts_with(MAGIC) {
            return Self::binary(bytes);
        }
        Ok(Container {
            json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            data: None,
            is_binary: false,
        })
    }

    fn binary(bytes: &'a [u8]) -> Result<Self, Fault> {
        let [_, version, length] = words(bytes).ok_or_else(|| {
            let found = bytes.len();
            Fault::new(format!(
                "the file ends in its header: found {found} bytes, expected at least {HEADER}"
            ))
        })?;
        if version != 2 {
            return Err(Fault::new(format!(
                "found version {version} of the binary container, expected 2"
            )));
        }
        let whole = bytes.get(..length as usize).ok_or_else(|| {
            Fault::new(format!(
                "the file is cut: its header says {length} bytes, found {}",
                bytes.len()
            ))
        })?;
        let mut rest = whole.get(HEADER..).unwrap_or_default();
        let (kind, json) = chunk(&mut rest, HEADER)?;
        if kind != JSON_CHUNK {
            return Err(Fault::new("the first chunk of the file is not JSON"));
        }
        let mut data = None;
        while !rest.is_empty() && data.is_none() {
            let offset = whole.len() - rest.len();
            let (kind, content) = chunk(&mut rest, offset)?;
            if kind == DATA_CHUNK {
                data = Some(content);
            }
        }
        Ok(Container {
            json,
            data,
            is_binary: true,
        })
    }
}

/// The little-endian words at the start of `bytes`.
fn words<const N: usize>(bytes: &[u8]) -> Option<[u32; N]> {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes.get(..4 * N)?.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().ok()?);
    }
    Some(words)
}

/// Splits the first chunk off `rest`, which starts `offset` bytes into the file.
fn chunk<'a>(rest: &mut &'a [u8], offset: usize) -> Result<(u32, &'a [u8]), Fault> {
    let cut = |message: String| Fault::new(format!("the chunk at offset {offset} {message}"));
    let [length, kind] =
        words(rest).ok_or_else(|| cut("is cut: its header is incomplete".into()))?;
    let content = &rest[CHUNK_HEADER..];
    if length as usize > content.len() {
        return Err(cut(format!(
            "says {length} bytes, but {} follow",
            content.len()
        )));
    }
    let (chunk, after) = content.split_at(length as usize);
    *rest = after;
    Ok((kind, chunk))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::mutations;

    fn binary() -> Vec<u8> {
        let mut file = b"glTF\x02\0\0\0\x28\0\0\0".to_vec();
        file.extend(b"\x04\0\0\0JSON{}  \x08\0\0\0BIN\0abcdefgh");
        file
    }

    #[test]
    fn chunks_are_split() {
        let file = binary();
        let container = Container::new(&file).unwrap();
        assert_eq!(container.json, b"{}  ");
        assert_eq!(container.data, Some(&b"abcdefgh"[..]));
        let text = Container::new(b"\xef\xbb\xbf{}").unwrap();
        assert_eq!((text.json, text.is_binary), (&b"{}"[..], false));
    }

    #[test]
    fn damaged_files_are_errors_or_files() {
        for bytes in mutations(&binary(), 2000) {
            if let Ok(container) = Container::new(&bytes) {
                assert!(container.json.len() <= bytes.len());
            }
        }
    }
}
