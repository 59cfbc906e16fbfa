//! Files compressed by gzip, recognized by content.

use crate::file_error::Fault;
use std::io::Read;

/// Whether the file content is compressed.
pub(crate) fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1F, 0x8B])
}

/// Most bytes that `compressed` bytes of deflate may expand to. The format allows 1032 times as
/// many, with which a small file fills the memory; scenes and meshes reach a tenth.
pub(crate) fn most_unpacked(compressed: usize) -> u64 {
    /// Most times that a large file may expand.
    const RATIO: u64 = 256;
    /// Bytes to which any file may expand.
    const ALWAYS_ALLOWED: u64 = 256 << 20;
    (compressed as u64)
        .saturating_mul(RATIO)
        .max(ALWAYS_ALLOWED)
}

/// The content of a file, unpacked if it is compressed.
pub(crate) fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>, Fault> {
    if !is_packed(&bytes) {
        return Ok(bytes);
    }
    let most = most_unpacked(bytes.len());
    let mut content = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes.as_slice())
        .take(most + 1)
        .read_to_end(&mut content)
        .map_err(|error| Fault::new(format!("the compressed file is damaged: {error}")))?;
    if content.len() as u64 > most {
        return Err(Fault::new(format!(
            "the compressed file of {} bytes expands to more than {most} bytes",
            bytes.len()
        )));
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::read::GzEncoder;

    #[test]
    fn files_that_fill_the_memory_are_refused() {
        let zeros = std::io::repeat(0).take((256 << 20) + 1);
        let mut bomb = Vec::new();
        GzEncoder::new(zeros, Compression::best())
            .read_to_end(&mut bomb)
            .unwrap();
        let refused = unpacked(bomb)
            .unwrap_err()
            .in_file("f".as_ref())
            .to_string();
        assert!(
            refused.ends_with("expands to more than 268435456 bytes"),
            "{refused}"
        );
    }

    #[test]
    fn large_files_may_expand_by_a_ratio() {
        assert_eq!(most_unpacked(1), 256 << 20);
        assert_eq!(most_unpacked(1 << 30), 256 << 30);
    }
}
