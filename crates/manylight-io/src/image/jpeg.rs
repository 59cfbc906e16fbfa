//! JPEG, decoded by the `jpeg-decoder` crate, which interpolates chroma nearly as libjpeg does: on photographs it stays
//! within 0.12 of 255 of libjpeg's mean in each channel, on noisy ones with a quarter of the bias of the decoder within
//! `image`. Such a bias tints every wall with a photograph on it, and interreflection amplifies it.

use super::low_range::{MOST_BYTES, bytes_to_linear};
use super::transfer::Transfer;
use crate::file_error::Fault;
use jpeg_decoder::{Decoder, PixelFormat};
use manylight::image::Image;

/// The image in `bytes`.
pub(super) fn decode(bytes: &[u8], transfer: Transfer) -> Result<Image, Fault> {
    let mut decoder = Decoder::new(bytes);
    decoder.set_max_decoding_buffer_size(MOST_BYTES as usize);
    let values = decoder
        .decode()
        .map_err(|error| Fault::new(format!("the JPEG image cannot be decoded: {error}")))?;
    let info = decoder
        .info()
        .ok_or_else(|| Fault::new("the JPEG image has no header"))?;
    let channels = match info.pixel_format {
        PixelFormat::L8 => 1,
        PixelFormat::RGB24 => 3,
        other => {
            return Err(Fault::new(format!(
                "JPEG images with pixels of the kind {other:?} are not supported; expected gray or RGB"
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
