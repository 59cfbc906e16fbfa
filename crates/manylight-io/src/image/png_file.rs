//! PNG files: 8 bit sRGB, tagged as such, with metadata as text.

use crate::file_error::Fault;
use manylight::image::Image;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

/// The entries of the metadata that a PNG file has, with their keywords. `Software` is a keyword of
/// the standard.
const KEYWORDS: [(&str, &str); 5] = [
    ("software", "Software"),
    ("scene", "scene"),
    ("scene.sha256", "scene.sha256"),
    ("command", "command"),
    ("samples", "samples"),
];

/// Checks the length of the palette in the content of a file. The decoder assumes whole entries.
///
/// # Errors
/// The palette is damaged.
pub(super) fn check_palette(bytes: &[u8]) -> Result<(), Fault> {
    /// Bytes of the signature.
    const SIGNATURE: usize = 8;
    /// Bytes of length, name and checksum of a chunk.
    const CHUNK: usize = 12;
    /// Most bytes of a palette: 256 entries of three.
    const MAX: usize = 768;
    let mut rest = bytes.get(SIGNATURE..).unwrap_or_default();
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        if after.starts_with(b"PLTE") && !(length.is_multiple_of(3) && (3..=MAX).contains(&length))
        {
            return Err(Fault::new(format!(
                "found a palette of {length} bytes, expected a multiple of 3 up to {MAX}"
            )));
        }
        rest = rest.get(length.saturating_add(CHUNK)..).unwrap_or_default();
    }
    Ok(())
}

/// The file content for an image of one or three channels with these 8 bit values.
pub(super) fn encode(
    image: &Image,
    values: &[u8],
    metadata: &[(String, String)],
) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    let mut write = || -> Result<(), png::EncodingError> {
        let mut encoder = Encoder::new(&mut bytes, image.width as u32, image.height as u32);
        encoder.set_color(if image.channels == 3 {
            ColorType::Rgb
        } else {
            ColorType::Grayscale
        });
        encoder.set_depth(BitDepth::Eight);
        // With the gamma and the primaries for readers that know no sRGB chunk.
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        for (name, keyword) in KEYWORDS {
            if let Some((_, value)) = metadata.iter().find(|(other, _)| other == name) {
                encoder.add_itxt_chunk(keyword.to_owned(), value.clone())?;
            }
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(values)?;
        writer.finish()
    };
    write().map_err(|error| Fault::new(format!("the image cannot be encoded: {error}")))?;
    Ok(bytes)
}
