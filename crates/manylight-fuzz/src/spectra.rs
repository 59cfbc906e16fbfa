//! Spectra.

use crate::folder::with_file;
use crate::messages::check_file_error;
use manylight_io::spectra::{coefficient_rgb, emission_rgb, read_spectrum, reflectance_rgb};

/// Reads a spectrum, and converts it to colors.
pub(crate) fn check(input: &[u8]) {
    with_file(input, "values.spd", |path| match read_spectrum(path) {
        Ok(spectrum) => {
            assert!(spectrum.is_sorted_by(|a, b| a.0 < b.0));
            assert!(spectrum.iter().all(|(l, v)| l.is_finite() && v.is_finite()));
            let _ = (
                reflectance_rgb(&spectrum),
                coefficient_rgb(&spectrum),
                emission_rgb(&spectrum),
            );
        }
        Err(error) => check_file_error(&error),
    });
}
