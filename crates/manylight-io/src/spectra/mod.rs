//! Conversion of spectra to linear Rec. 709 colors, equal to that of Mitsuba's RGB variants.
//!
//! A spectrum is a list of (wavelength in nm, value) with increasing wavelengths, linearly
//! interpolated and zero outside. It is integrated with the CIE 1931 2 degree observer from 360 nm
//! to 830 nm. Reflectances and coefficients are multiplied by illuminant D65, so that a reflectance
//! of 1 becomes white. Emission is not, so that a constant emission of 1 becomes the color of the
//! equal-energy spectrum, (1.205, 0.948, 0.909).

mod cie;
mod ior;
mod metals;

#[cfg(test)]
mod tests;

pub use ior::{dielectric_ior, dielectric_names};
pub use metals::{metal, metal_names};

use crate::file_error::{Fault, FileError, read_bytes};
use manylight::color::Rgb;
use std::path::Path;

/// Color of a reflectance or transmittance under D65, clamped to [0, 1].
pub fn reflectance_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    let daylight = integrate(|x| interpolate(spectrum, x) * cie::daylight(x));
    daylight.map(|v| v.clamp(0.0, 1.0))
}

/// Color of an index of refraction or absorption coefficient under D65, clamped to at least 0.
pub fn coefficient_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    integrate(|x| interpolate(spectrum, x) * cie::daylight(x)).map(|v| v.max(0.0))
}

/// Color of an emission spectrum, clamped to at least 0.
pub fn emission_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    integrate(|x| interpolate(spectrum, x)).map(|v| v.max(0.0))
}

/// Color of a constant emission spectrum (X = Y = Z = `value`), clamped to at least 0. A constant
/// reflectance or coefficient needs no conversion, because its color is gray.
pub fn constant_emission_rgb(value: f32) -> Rgb {
    rec709_from_xyz([f64::from(value); 3]).map(|v| v.max(0.0))
}

/// Radiance in W/(m² sr nm) of a black body of `temperature` in kelvin, by Planck's law; black for
/// temperatures up to 0. The unit is that of Mitsuba's spectral variants (its RGB variants do not
/// support black bodies).
pub fn blackbody_rgb(temperature: f32) -> Rgb {
    if temperature > 0.0 {
        integrate(|wavelength| planck(wavelength, temperature)).map(|v| v.max(0.0))
    } else {
        Rgb::BLACK
    }
}

/// Largest radiance in W/(m² sr nm) of a black body of `temperature` > 0 in kelvin over all
/// wavelengths.
pub fn blackbody_peak(temperature: f32) -> f32 {
    /// Wien's displacement constant in nm K.
    const WIEN: f64 = 2.897_771_955e6;
    planck(WIEN / f64::from(temperature), temperature) as f32
}

/// Planck's law in W/(m² sr nm), for a wavelength in nm and a temperature in kelvin.
fn planck(wavelength: f64, temperature: f32) -> f64 {
    /// Speed of light in m/s.
    const C: f64 = 299_792_458.0;
    /// Planck constant in J s.
    const H: f64 = 6.626_070_15e-34;
    /// Boltzmann constant in J/K.
    const K: f64 = 1.380_649e-23;
    const METERS_PER_NM: f64 = 1e-9;
    let l = wavelength * METERS_PER_NM;
    let exponent = H * C / (l * K * f64::from(temperature));
    2.0 * H * C * C / (l.powi(5) * exponent.exp_m1()) * METERS_PER_NM
}

/// Whether there are samples, at increasing wavelengths.
pub(crate) fn is_spectrum(samples: &[(f32, f32)]) -> bool {
    !samples.is_empty() && samples.windows(2).all(|pair| pair[0].0 < pair[1].0)
}

/// Reads a text file with one wavelength in nm and one value per line. Empty lines and lines that
/// start with `#` are skipped.
///
/// # Errors
/// The file cannot be read, a line is not two finite numbers, the wavelengths do not increase, or
/// there are none.
pub fn read_spectrum(path: &Path) -> Result<Vec<(f32, f32)>, FileError> {
    let bytes = read_bytes(path)?;
    parse_spectrum(&bytes).map_err(|fault| fault.in_file(path))
}

fn parse_spectrum(bytes: &[u8]) -> Result<Vec<(f32, f32)>, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut spectrum: Vec<(f32, f32)> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if words.first().is_none_or(|w| w.starts_with('#')) {
            continue;
        }
        let values: Option<Vec<f32>> = words
            .iter()
            .map(|w| w.parse().ok().filter(|v: &f32| v.is_finite()))
            .collect();
        let Some(&[wavelength, value]) = values.as_deref() else {
            let message = format!("expected a wavelength and a value, found '{}'", line.trim());
            return Err(Fault::at(number, 1, message));
        };
        if spectrum.last().is_some_and(|&(last, _)| last >= wavelength) {
            let message = format!(
                "the wavelength {wavelength} is not larger than the one before; expected increasing wavelengths"
            );
            return Err(Fault::at(number, 1, message));
        }
        spectrum.push((wavelength, value));
    }
    if spectrum.is_empty() {
        Err(Fault::new(
            "expected lines with a wavelength and a value, found none",
        ))
    } else {
        Ok(spectrum)
    }
}

/// Value at the wavelength `x` in nm.
fn interpolate(spectrum: &[(f32, f32)], x: f64) -> f64 {
    let after = spectrum.partition_point(|&(wavelength, _)| f64::from(wavelength) <= x);
    let before = after.checked_sub(1).map(|i| spectrum[i]);
    match (before, spectrum.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => {
            let t = (x - f64::from(x0)) / (f64::from(x1) - f64::from(x0));
            f64::from(y0) * (1.0 - t) + f64::from(y1) * t
        }
        (Some((x0, y0)), None) if f64::from(x0) == x => f64::from(y0),
        _ => 0.0,
    }
}

/// Rec. 709 color of `power`, a function of the wavelength in nm. The quadrature uses the nodes and
/// weights of Mitsuba's `spectrum_list_to_srgb`, because they differ visibly from the exact
/// integral for coarse spectra.
fn integrate(power: impl Fn(f64) -> f64) -> Rgb {
    const STEPS: u32 = 1000;
    const RANGE: f64 = cie::LAST - cie::FIRST;
    let mut xyz = [0.0; 3];
    for step in 0..STEPS {
        let wavelength = cie::FIRST + f64::from(step) / f64::from(STEPS - 1) * RANGE;
        let value = power(wavelength);
        for (sum, weight) in xyz.iter_mut().zip(cie::observer(wavelength)) {
            *sum += weight * value;
        }
    }
    let scale = RANGE / f64::from(STEPS) / cie::LUMINOSITY_INTEGRAL;
    rec709_from_xyz(xyz.map(|v| v * scale))
}

/// Linear Rec. 709 from CIE XYZ (IEC 61966-2-1).
pub(crate) fn rec709_from_xyz([x, y, z]: [f64; 3]) -> Rgb {
    Rgb::new(
        (3.240_479 * x - 1.537_150 * y - 0.498_535 * z) as f32,
        (-0.969_256 * x + 1.875_991 * y + 0.041_556 * z) as f32,
        (0.055_648 * x - 0.204_043 * y + 1.057_311 * z) as f32,
    )
}
