//! Files compressed by gzip, recognized by content.

use crate::file_error::Fault;
use std::io::Read;

/// Whether the file content is compressed.
pub(crate) fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1F, 0x8B])
}

/// The content of a file, unpacked if it is compressed. Deflate expands at most 1032 times, so the file bounds the memory.
pub(crate) fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>, Fault> {
    if !is_packed(&bytes) {
        return Ok(bytes);
    }
    let mut content = Vec::new();
    match flate2::read::MultiGzDecoder::new(bytes.as_slice()).read_to_end(&mut content) {
        Ok(_) => Ok(content),
        Err(error) => Err(Fault::new(format!(
            "the compressed file is damaged: {error}"
        ))),
    }
}
