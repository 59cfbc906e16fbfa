//! PNG files: 8 bit sRGB, tagged as such, with metadata as text.

use crate::file_error::Fault;
use manylight::image::Image;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

/// The entries of the metadata that a PNG file has, with their keywords. `Software` is a keyword of the standard.
const KEYWORDS: [(&str, &str); 5] = [
    ("software", "Software"),
    ("scene", "scene"),
    ("scene.sha256", "scene.sha256"),
    ("command", "command"),
    ("samples", "samples"),
];

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
