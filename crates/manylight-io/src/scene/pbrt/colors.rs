//! Colors and spectra as linear Rec. 709 colors.
//!
//! The emission of a light is a color or a spectrum. PBRT v4 keeps the values of colors and scales
//! spectra to luminance 1; `scale`, `power` and `illuminance` then set the magnitude. PBRT v3 keeps
//! the values of both.

use super::super::files::find_external_file;
use super::super::parameters::Parameters;
use super::super::sink::{Problem, Sink, Text};
use super::named_spectra::{NamedSpectrum, named_spectrum, spectrum_names};
use super::param_types::{Param, ParamType, Values};
use super::params::Params;
use crate::spectra;
use crate::suggest::did_you_mean;
use manylight::color::Rgb;
use manylight::math::{Mat3, Vec3};
use std::path::PathBuf;

/// A color space of `rgb` values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColorSpace {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

impl ColorSpace {
    const NAMES: [(&'static str, ColorSpace); 4] = [
        ("srgb", ColorSpace::Srgb),
        ("dci-p3", ColorSpace::DciP3),
        ("rec2020", ColorSpace::Rec2020),
        ("aces2065-1", ColorSpace::Aces),
    ];

    /// The color space with this name. Unknown names are reported.
    pub(super) fn named(name: &Text, sink: &Sink) -> Option<ColorSpace> {
        let lower = name.value.to_lowercase();
        let found = Self::NAMES.iter().find(|(known, _)| *known == lower);
        if found.is_none() {
            let message = format!("unknown color space `{}`", name.value);
            let names: Vec<&str> = Self::NAMES.iter().map(|(known, _)| *known).collect();
            let help = format!("expected one of {}", names.join(", "));
            sink.error(Problem::new("scene::bad_value", name.span, message).help(help));
        }
        found.map(|(_, space)| *space)
    }

    /// The Rec. 709 color of a color in this space. White stays white.
    fn to_rec709(self, color: Rgb) -> Rgb {
        // Products of the matrices from RGB to XYZ, with Bradford adaptation for ACES, and from XYZ
        // to Rec. 709. Rows sum to 1.
        let rows: [[f32; 3]; 3] = match self {
            ColorSpace::Srgb => return color,
            ColorSpace::DciP3 => [
                [1.224_94, -0.224_94, 0.0],
                [-0.042_057, 1.042_057, 0.0],
                [-0.019_638, -0.078_636, 1.098_274],
            ],
            ColorSpace::Rec2020 => [
                [1.660_491, -0.587_641, -0.072_85],
                [-0.124_55, 1.132_9, -0.008_35],
                [-0.018_151, -0.100_579, 1.118_73],
            ],
            ColorSpace::Aces => [
                [2.521_686, -1.134_131, -0.387_555],
                [-0.276_48, 1.372_719, -0.096_239],
                [-0.015_378, -0.152_975, 1.168_353],
            ],
        };
        let matrix = Mat3::from_cols_array_2d(&rows).transpose();
        Rgb::from((matrix * Vec3::from_array(color.to_array())).to_array())
    }
}

/// The meaning of a color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorUse {
    /// In [0, 1].
    Reflectance,
    /// At least 0, such as an index of refraction.
    Coefficient,
    /// Emission in PBRT v4: spectra have the luminance 1.
    Emission,
    /// Emission in PBRT v3: spectra keep their values.
    EmissionV3,
}

/// What colors depend on besides their parameter.
pub(super) struct ColorContext<'a> {
    pub(super) sink: &'a Sink,
    pub(super) folders: &'a [PathBuf],
    pub(super) space: ColorSpace,
}

impl ColorContext<'_> {
    /// The color of the parameter `name`, if it is given and not a texture.
    pub(super) fn color(
        &self,
        params: &Params<'_>,
        name: &'static str,
        color_use: ColorUse,
    ) -> Option<Rgb> {
        let param = params.get(name)?;
        match (param.ty, &param.values) {
            (ParamType::Rgb | ParamType::Xyz, Values::Numbers(values)) => {
                let Some(&[r, g, b]) = values.first_chunk::<3>().filter(|_| values.len() == 3)
                else {
                    params.refuse(param, "three numbers");
                    return None;
                };
                let color = Rgb::new(r, g, b);
                let color = match param.ty {
                    ParamType::Xyz => spectra::rec709_from_xyz([r, g, b].map(f64::from)),
                    _ => self.space.to_rec709(color),
                };
                Some(self.limited(params, param, color, color_use))
            }
            (ParamType::Float, Values::Numbers(values)) if values.len() == 1 => {
                Some(self.limited(params, param, Rgb::splat(values[0]), color_use))
            }
            (ParamType::Blackbody, Values::Numbers(values)) => {
                self.blackbody(params, param, values, color_use)
            }
            (ParamType::Spectrum, Values::Numbers(values)) => {
                let samples = self.samples(params, param, values)?;
                Some(of_samples(&samples, color_use))
            }
            (ParamType::Spectrum, Values::Strings(names)) => {
                let [name] = names.as_slice() else {
                    params.refuse(param, "one name");
                    return None;
                };
                self.named(name, color_use)
            }
            _ => {
                params.mismatch(param, &"a color or a spectrum");
                None
            }
        }
    }

    /// Clamps reflectances to [0, 1] and other colors to at least 0, with a warning.
    fn limited(&self, params: &Params<'_>, param: &Param, color: Rgb, color_use: ColorUse) -> Rgb {
        let most = match color_use {
            ColorUse::Reflectance => 1.0,
            _ => f32::INFINITY,
        };
        let clamped = color.map(|v| v.clamp(0.0, most));
        // Conversions between color spaces may leave the range by design.
        if clamped != color && self.space == ColorSpace::Srgb {
            let range = if most == 1.0 { "[0, 1]" } else { "[0, ∞)" };
            let (name, object) = (&param.name.value, params.describe());
            let message = format!("`{name}` of {object} is outside of {range}; it is clamped");
            let problem = Problem::new("scene::clamped", param.span, message);
            self.sink.warn_once("color range", problem);
        }
        clamped
    }

    /// The color of `[temperature]`, or `[temperature scale]` in PBRT v3.
    fn blackbody(
        &self,
        params: &Params<'_>,
        param: &Param,
        values: &[f32],
        color_use: ColorUse,
    ) -> Option<Rgb> {
        let (temperature, scale) = match *values {
            [temperature] => (temperature, 1.0),
            [temperature, scale] => (temperature, scale),
            _ => (-1.0, 1.0),
        };
        if temperature <= 0.0 {
            params.refuse(param, "a positive temperature in kelvin");
            return None;
        }
        let color = spectra::blackbody_rgb(temperature);
        let peak = spectra::blackbody_peak(temperature);
        Some(match color_use {
            ColorUse::Emission => color / color.luminance() * scale,
            _ => color / peak * scale,
        })
    }

    /// Pairs of wavelength in nm and value.
    fn samples(
        &self,
        params: &Params<'_>,
        param: &Param,
        values: &[f32],
    ) -> Option<Vec<(f32, f32)>> {
        let pairs: Vec<(f32, f32)> = values
            .chunks_exact(2)
            .map(|pair| (pair[0], pair[1]))
            .collect();
        if !values.len().is_multiple_of(2) || !spectra::is_spectrum(&pairs) {
            let required = "pairs of wavelength and value with increasing wavelengths";
            params.refuse(param, required);
            return None;
        }
        Some(pairs)
    }

    /// The color of a named spectrum or of a file.
    fn named(&self, name: &Text, color_use: ColorUse) -> Option<Rgb> {
        if let Some(spectrum) = named_spectrum(&name.value) {
            return Some(match spectrum {
                NamedSpectrum::Color(color) => color,
                NamedSpectrum::Glass(eta) => {
                    let message = format!("the dispersion of `{}` is ignored", name.value);
                    self.sink.unsupported("dispersion", name.span, message);
                    Rgb::splat(eta)
                }
            });
        }
        if !name.value.contains('.') {
            let known = spectrum_names();
            let help = did_you_mean(&name.value, known.iter().map(String::as_str));
            let files = "expected a named spectrum or a file such as `name.spd`";
            let message = format!("unknown spectrum `{}`", name.value);
            let problem = Problem::new("scene::bad_value", name.span, message);
            self.sink
                .error(problem.help(help.unwrap_or_else(|| files.to_owned())));
            return None;
        }
        let path = find_external_file(self.sink, self.folders, name, "spectrum file")?;
        self.sink.note_read(&path);
        match spectra::read_spectrum(&path) {
            Ok(samples) => Some(of_samples(&samples, color_use)),
            Err(error) => {
                let message = format!("cannot use the spectrum file {error}");
                let problem = Problem::new("scene::broken_file", name.span, message);
                self.sink.error(problem.caused_by(&error));
                None
            }
        }
    }
}

/// The color of samples at increasing wavelengths.
fn of_samples(samples: &[(f32, f32)], color_use: ColorUse) -> Rgb {
    match color_use {
        ColorUse::Reflectance => spectra::reflectance_rgb(samples),
        ColorUse::Coefficient => spectra::coefficient_rgb(samples),
        ColorUse::EmissionV3 => spectra::emission_rgb(samples),
        ColorUse::Emission => {
            let color = spectra::emission_rgb(samples);
            let luminance = color.luminance();
            if luminance > 0.0 {
                color / luminance
            } else {
                Rgb::BLACK
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_in_every_color_space() {
        for (name, space) in ColorSpace::NAMES {
            let white = space.to_rec709(Rgb::WHITE);
            let off = white.map(|v| (v - 1.0).abs()).max_channel();
            assert!(off < 1e-4, "{name}: {white:?}");
        }
    }
}
