//! JPEG, decoded by the `jpeg-decoder` crate.
//!
//! Its interpolation of chroma is close to that of libjpeg: on photographs, the mean of each
//! channel differs by at most 0.12 of
//! 255. On noisy photographs, the bias is a quarter of that of the decoder in the `image` crate.
//!      Bias matters because
//! interreflection amplifies the tint of a textured wall.

use super::low_range::{MAX_DECODED_BYTES, bytes_to_linear};
use super::size_check::check_size;
use super::transfer::Transfer;
use crate::file_error::Fault;
use jpeg_decoder::{Decoder, PixelFormat};
use manylight::image::Image;

/// Most decoded bytes per byte of a file. A progressive file has at least one bit for each block of
/// 8 x 8 values; with chroma at a quarter of the resolution, these are 1365 bytes.
const EXPANSION: u32 = 4096;

/// The image in the file content `bytes`.
pub(super) fn decode(bytes: &[u8], transfer: Transfer) -> Result<Image, Fault> {
    let undecodable = |error: jpeg_decoder::Error| {
        Fault::new(format!("the JPEG image cannot be decoded: {error}"))
    };
    let mut decoder = Decoder::new(bytes);
    decoder.set_max_decoding_buffer_size(MAX_DECODED_BYTES as usize);
    decoder.read_info().map_err(undecodable)?;
    let info = decoder
        .info()
        .ok_or_else(|| Fault::new("the JPEG image cannot be decoded: it has no header"))?;
    let size = [info.width, info.height].map(usize::from);
    let decoded = size[0] * size[1] * info.pixel_format.pixel_bytes();
    check_size(size, decoded as u128, bytes.len(), EXPANSION)?;
    let values = decoder.decode().map_err(undecodable)?;
    let channels = match info.pixel_format {
        PixelFormat::L8 => 1,
        PixelFormat::RGB24 => 3,
        other => {
            return Err(Fault::new(format!(
                "found a JPEG image with {other:?} pixels, expected gray or RGB"
            )));
        }
    };
    let data = bytes_to_linear(&values, channels, channels, transfer);
    Ok(Image {
        width: usize::from(info.width),
        height: usize::from(info.height),
        channels,
        data,
    })
}
