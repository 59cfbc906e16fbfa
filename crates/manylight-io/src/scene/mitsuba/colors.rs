//! Color parameters: conversion of values and textures to the inputs of materials and emitters.

use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::DescBuilder;
use super::family::{PluginFamily, SPECTRA};
use super::object::Param;
use super::props::Props;
use super::values::{ObjectId, Spectrum, Value, number_list};
use crate::spectra;
use manylight::color::Rgb;
use manylight::texture::{ColorInput, FloatInput};

/// The use of a color. It determines how spectra are converted, and which values are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorUse {
    /// Reflectance or transmittance, in [0, 1].
    Reflectance,
    /// Index of refraction or absorption.
    Coefficient,
    /// Radiance, intensity or irradiance of an emitter.
    Emission,
}

impl Spectrum {
    /// The color of a spectrum. `None` for a black body that is not an emission.
    fn to_rgb(&self, color_use: ColorUse) -> Option<Rgb> {
        Some(match (self, color_use) {
            (Spectrum::Uniform(value), ColorUse::Emission) => {
                spectra::constant_emission_rgb(*value)
            }
            (Spectrum::Uniform(value), _) => Rgb::splat(*value),
            (Spectrum::Sampled(samples), ColorUse::Emission) => spectra::emission_rgb(samples),
            (Spectrum::Sampled(samples), ColorUse::Coefficient) => {
                spectra::coefficient_rgb(samples)
            }
            (Spectrum::Sampled(samples), ColorUse::Reflectance) => {
                spectra::reflectance_rgb(samples)
            }
            (Spectrum::Blackbody { temperature, scale }, ColorUse::Emission) => {
                spectra::blackbody_rgb(*temperature) * *scale
            }
            (Spectrum::Blackbody { .. }, _) => return None,
        })
    }
}

impl DescBuilder<'_> {
    /// The parameter `name` as a color or a texture. `default` is gray.
    pub(super) fn color_input(
        &mut self,
        props: &Props<'_>,
        name: &'static str,
        default: f32,
        color_use: ColorUse,
    ) -> ColorInput {
        let Some(param) = props.get(name) else {
            return ColorInput::Constant(Rgb::splat(default));
        };
        if let Some(id) = self.nested_texture(&param.value) {
            let texture = self.texture(id).map(ColorInput::Texture);
            return texture.unwrap_or(ColorInput::Constant(Rgb::splat(default)));
        }
        let color = self.constant(props, param, color_use, "a color, a spectrum or a texture");
        ColorInput::Constant(color.unwrap_or(Rgb::splat(default)))
    }

    /// The parameter `name` as a constant color. `default` is gray.
    pub(super) fn color(
        &mut self,
        props: &Props<'_>,
        name: &'static str,
        default: f32,
        color_use: ColorUse,
    ) -> Rgb {
        let constant = props
            .get(name)
            .and_then(|param| self.constant(props, param, color_use, "a color or a spectrum"));
        constant.unwrap_or(Rgb::splat(default))
    }

    /// The parameter `name` as a number or a texture.
    pub(super) fn float_input(
        &mut self,
        props: &Props<'_>,
        name: &'static str,
        default: f32,
    ) -> FloatInput {
        let Some(param) = props.get(name) else {
            return FloatInput::Constant(default);
        };
        if let Some(id) = self.nested_texture(&param.value) {
            let texture = self.texture(id).map(FloatInput::Texture);
            return texture.unwrap_or(FloatInput::Constant(default));
        }
        let color = self.constant(props, param, ColorUse::Coefficient, "a number or a texture");
        FloatInput::Constant(color.map_or(default, gray))
    }

    /// The color of a value. A value of another type is reported, with `expected`.
    fn constant(
        &mut self,
        props: &Props<'_>,
        param: &Param,
        color_use: ColorUse,
        expected: &str,
    ) -> Option<Rgb> {
        match &param.value {
            Value::Float(value) => Some(Rgb::splat(*value as f32)),
            Value::Integer(value) => Some(Rgb::splat(*value as f32)),
            Value::Rgb(rgb) => {
                self.checked_rgb(props, param, rgb.map(|v| v as f32).into(), color_use)
            }
            Value::Spectrum(spectrum) => {
                let color = spectrum.to_rgb(color_use);
                if color.is_none() {
                    props.mismatch(param, &expected);
                }
                color
            }
            Value::Object(id) if self.tree.get(*id).family == PluginFamily::Spectrum => {
                self.spectrum_plugin(*id, color_use)
            }
            _ => {
                props.mismatch(param, &expected);
                None
            }
        }
    }

    /// Checks that a reflectance is in [0, 1]. In files of version 0.x it is clamped with a
    /// warning.
    fn checked_rgb(
        &self,
        props: &Props<'_>,
        param: &Param,
        color: Rgb,
        color_use: ColorUse,
    ) -> Option<Rgb> {
        let inside = color.to_array().iter().all(|v| (0.0..=1.0).contains(v));
        if inside || color_use != ColorUse::Reflectance {
            return Some(color);
        }
        if !props.is_v0() {
            props.refuse(param, "in [0, 1]");
            return None;
        }
        let (name, object) = (&param.name.value, props.describe());
        let message = format!("`{name}` of {object} is outside of [0, 1]; it is clamped");
        let problem = Problem::new("scene::clamped", param.span, message);
        self.sink.warn_once("reflectance range", problem);
        Some(color.map(|v| v.clamp(0.0, 1.0)))
    }

    /// The color of a `<spectrum type="...">`.
    pub(super) fn spectrum_plugin(&mut self, id: ObjectId, color_use: ColorUse) -> Option<Rgb> {
        let props = self.props(id);
        let color = match props.plugin().value.as_str() {
            // Unlike `<spectrum value="..."/>` on an emitter, it is no spectrum there.
            "uniform" => Some(Rgb::splat(props.float("value", 1.0))),
            "d65" => {
                let color = self.color(&props, "color", 1.0, ColorUse::Emission);
                Some(color * props.float("scale", 1.0))
            }
            "srgb" => Some(self.color(&props, "color", 1.0, color_use)),
            "rawconstant" => raw_constant(&props),
            "irregular" => {
                let wavelengths = numbers(&props, "wavelengths");
                let lists = wavelengths.zip(numbers(&props, "values"));
                lists.and_then(|(w, v)| sampled(&props, w, v, color_use))
            }
            "regular" => {
                let first = props.float("wavelength_min", 360.0);
                let last = props.float("wavelength_max", 830.0);
                numbers(&props, "values").and_then(|values| {
                    let step = (last - first) / (values.len().max(2) - 1) as f32;
                    let wavelengths = (0..values.len()).map(|i| first + step * i as f32);
                    sampled(&props, wavelengths.collect(), values, color_use)
                })
            }
            "blackbody" => {
                props.ignore(&["wavelength_min", "wavelength_max"]);
                let temperature = props.float_where("temperature", 5000.0, |t| t > 0.0, "positive");
                Some(spectra::blackbody_rgb(temperature) * props.float("scale", 1.0))
            }
            _ => {
                self.unsupported(&props, SPECTRA, &[]);
                return None;
            }
        };
        props.finish();
        color
    }
}

/// A number, or a vector of three, without any conversion.
fn raw_constant(props: &Props<'_>) -> Option<Rgb> {
    let Some(param) = props.get("value") else {
        props.missing("value");
        return None;
    };
    match &param.value {
        Value::Float(value) => Some(Rgb::splat(*value as f32)),
        Value::Integer(value) => Some(Rgb::splat(*value as f32)),
        Value::Vector(value) => Some(Rgb::from(value.as_vec3().to_array())),
        Value::Rgb(value) => Some(Rgb::from(value.map(|v| v as f32))),
        _ => {
            props.mismatch(param, &"a number or a vector");
            None
        }
    }
}

/// A list of numbers in a string.
fn numbers(props: &Props<'_>, name: &'static str) -> Option<Vec<f32>> {
    let numbers = number_list(&props.required_string(name)?.value);
    if numbers.is_none() {
        props.refuse_named(name, "a list of numbers");
    }
    numbers
}

/// The color of samples at increasing wavelengths in nm.
fn sampled(
    props: &Props<'_>,
    wavelengths: Vec<f32>,
    values: Vec<f32>,
    color_use: ColorUse,
) -> Option<Rgb> {
    let counts_differ = wavelengths.len() != values.len();
    let samples: Vec<(f32, f32)> = wavelengths.into_iter().zip(values).collect();
    if counts_differ || !spectra::is_spectrum(&samples) {
        let required = "one number for each wavelength, with increasing wavelengths";
        props.refuse_named("values", required);
        return None;
    }
    Spectrum::Sampled(samples).to_rgb(color_use)
}

/// The number of a color: exactly its value if it is gray, else its luminance.
fn gray(color: Rgb) -> f32 {
    if color.r == color.g && color.g == color.b {
        color.r
    } else {
        color.luminance()
    }
}
