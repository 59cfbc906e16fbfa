//! Portable float maps: a header of `PF` (RGB) or `Pf` (gray), width, height and scale, then rows
//! of `f32` from bottom to top. A negative scale means little endian; its magnitude is ignored.

use crate::file_error::Fault;
use manylight::image::Image;

/// The image in the file content `bytes`.
pub(super) fn parse(bytes: &[u8]) -> Result<Image, Fault> {
    let (words, start) = header(bytes)?;
    let channels = if words[0] == "PF" { 3 } else { 1 };
    let size = |word: &str| {
        word.parse::<usize>().map_err(|_| {
            Fault::new(format!(
                "expected the width or height of a PFM image, found '{word}'"
            ))
        })
    };
    let (width, height) = (size(&words[1])?, size(&words[2])?);
    if width == 0 || height == 0 {
        return Err(Fault::new(format!(
            "found {width} x {height} pixels, expected at least one"
        )));
    }
    let scale: f32 = words[3].parse().map_err(|_| {
        Fault::new(format!(
            "expected the scale of a PFM image, found '{}'",
            words[3]
        ))
    })?;
    let value_count = width
        .checked_mul(height)
        .and_then(|n| n.checked_mul(channels));
    let content = value_count.and_then(|n| bytes[start..].get(..n.checked_mul(4)?));
    let content = content.ok_or_else(|| {
        Fault::new(format!("the file ends at byte {}, before the end of {width} x {height} pixels of {channels} values", bytes.len()))
    })?;
    let value = |b: &[u8]| {
        if scale < 0.0 {
            f32::from_le_bytes([b[0], b[1], b[2], b[3]])
        } else {
            f32::from_be_bytes([b[0], b[1], b[2], b[3]])
        }
    };
    let row_bytes = width * channels * 4;
    let data = content
        .chunks_exact(row_bytes)
        .rev()
        .flat_map(|row| row.chunks_exact(4).map(value))
        .collect();
    Ok(Image {
        width,
        height,
        channels,
        data,
    })
}

/// The four words of the header, and the offset of the values, which start after one white-space
/// byte.
fn header(bytes: &[u8]) -> Result<([String; 4], usize), Fault> {
    let mut words: [String; 4] = Default::default();
    let mut at = 0;
    for word in &mut words {
        at += bytes[at..]
            .iter()
            .take_while(|b| b.is_ascii_whitespace())
            .count();
        let length = bytes[at..]
            .iter()
            .take_while(|b| !b.is_ascii_whitespace())
            .count();
        *word = String::from_utf8_lossy(&bytes[at..at + length]).into_owned();
        at += length;
    }
    if at < bytes.len() {
        Ok((words, at + 1))
    } else {
        Err(Fault::new(
            "the file ends before the end of the header of a PFM image",
        ))
    }
}

/// The file content for `image`, which has one or three channels.
pub(super) fn encode(image: &Image) -> Vec<u8> {
    let kind = if image.channels == 3 { "PF" } else { "Pf" };
    let mut bytes = format!("{kind}\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in image
        .data
        .chunks_exact((image.width * image.channels).max(1))
        .rev()
    {
        bytes.extend(row.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}
