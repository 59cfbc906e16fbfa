//! Spectra as linear Rec. 709 colors, as Mitsuba's RGB variants convert them.
//!
//! A spectrum is a list of (wavelength in nm, value) in increasing order, linear in between and zero outside. It is weighted
//! with the CIE 1931 2 degree observer from 360 nm to 830 nm. Reflectances and coefficients are seen under D65, emission is
//! not: a reflectance of 1 becomes white, a constant emission becomes the color of equal energy, (1.205, 0.948, 0.909).

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

/// Reflectance or transmittance: under D65, every channel limited to [0, 1].
pub fn reflectance_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    let daylight = integrate(|x| interpolate(spectrum, x) * cie::daylight(x));
    daylight.map(|v| v.clamp(0.0, 1.0))
}

/// Indices of refraction and absorption coefficients: under D65, no channel below 0.
pub fn coefficient_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    integrate(|x| interpolate(spectrum, x) * cie::daylight(x)).map(|v| v.max(0.0))
}

/// Emission: the spectrum itself, no channel below 0.
pub fn emission_rgb(spectrum: &[(f32, f32)]) -> Rgb {
    integrate(|x| interpolate(spectrum, x)).map(|v| v.max(0.0))
}

/// Emission of the same value at all wavelengths, exactly: equal energy has X = Y = Z. A constant reflectance or coefficient needs no conversion: it is gray.
pub fn constant_emission_rgb(value: f32) -> Rgb {
    rec709_from_xyz([f64::from(value); 3]).map(|v| v.max(0.0))
}

/// Radiance of a black body of `temperature` in kelvin, in W/(m² sr nm): Planck's law. Mitsuba's RGB variants lack this one;
/// the unit is that of its spectral variants.
pub fn blackbody_rgb(temperature: f32) -> Rgb {
    /// Speed of light in m/s, Planck's constant in J s, Boltzmann's constant in J/K.
    const C: f64 = 299_792_458.0;
    const H: f64 = 6.626_070_15e-34;
    const K: f64 = 1.380_649e-23;
    const METERS_PER_NM: f64 = 1e-9;
    let planck = |wavelength: f64| {
        let l = wavelength * METERS_PER_NM;
        let exponent = H * C / (l * K * f64::from(temperature));
        2.0 * H * C * C / (l.powi(5) * exponent.exp_m1()) * METERS_PER_NM
    };
    if temperature > 0.0 {
        integrate(planck).map(|v| v.max(0.0))
    } else {
        Rgb::BLACK
    }
}

/// A text file with a wavelength in nm and a value per line; empty lines and lines that start with `#` are skipped.
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
            return Err(Fault::at(
                number,
                1,
                format!("expected a wavelength and a value, found '{}'", line.trim()),
            ));
        };
        if spectrum.last().is_some_and(|&(last, _)| last >= wavelength) {
            return Err(Fault::at(
                number,
                1,
                format!("the wavelength {wavelength} does not increase"),
            ));
        }
        spectrum.push((wavelength, value));
    }
    if spectrum.is_empty() {
        Err(Fault::new("the file holds no wavelength and value"))
    } else {
        Ok(spectrum)
    }
}

/// Value at wavelength `x`.
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

/// Rec. 709 color of a function of the wavelength in nm. The rule has the same nodes and weights as Mitsuba's
/// `spectrum_list_to_srgb`, which for coarse spectra differ visibly from the exact integral.
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

/// IEC 61966-2-1.
fn rec709_from_xyz([x, y, z]: [f64; 3]) -> Rgb {
    Rgb::new(
        (3.240_479 * x - 1.537_150 * y - 0.498_535 * z) as f32,
        (-0.969_256 * x + 1.875_991 * y + 0.041_556 * z) as f32,
        (0.055_648 * x - 0.204_043 * y + 1.057_311 * z) as f32,
    )
}
