//! Sizes that headers of compressed images declare, compared with what files of their length can
//! contain.

use crate::file_error::Fault;

/// Decoded bytes that any file may have: a limit below which nothing is compared.
const ALWAYS_ALLOWED: u128 = 1 << 20;

/// Checks that `file_bytes` of a file can contain an image of `decoded_bytes`, before memory is
/// taken for it. `expansion` is the largest number of decoded bytes per byte of the format.
///
/// # Errors
/// The image has no pixels, or the file cannot contain it.
pub(super) fn check_size(
    [width, height]: [usize; 2],
    decoded_bytes: u128,
    file_bytes: usize,
    expansion: u32,
) -> Result<(), Fault> {
    if width == 0 || height == 0 {
        return Err(Fault::new(format!(
            "found {width} x {height} pixels, expected at least one"
        )));
    }
    let most = (file_bytes as u128 * u128::from(expansion)).max(ALWAYS_ALLOWED);
    if decoded_bytes <= most {
        return Ok(());
    }
    Err(Fault::new(format!(
        "the header declares {width} x {height} pixels, more than fit into the {file_bytes} bytes of the file"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_beyond_the_expansion_are_refused() {
        assert!(check_size([4096, 4096], 1 << 24, 1 << 14, 1 << 10).is_ok());
        let refused = check_size([4096, 4097], (1 << 24) + 4096, 1 << 14, 1 << 10).unwrap_err();
        assert_eq!(
            refused.in_file("f".as_ref()).to_string(),
            "f: the header declares 4096 x 4097 pixels, more than fit into the 16384 bytes of the file"
        );
        assert!(check_size([512, 512], 1 << 20, 1, 1).is_ok());
        assert!(check_size([512, 0], 0, 1, 1).is_err());
    }
}
