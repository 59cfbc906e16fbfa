//! Values that are colors or spectra.

use super::super::super::files::find_file;
use super::super::super::sink::{Problem, Sink, Text};
use super::super::xml::XmlElement;
use super::numbers::{bad_value, number, numbers, parse_finite, tokens};
use super::value::{Spectrum, Value};
use crate::spectra::{is_spectrum, read_spectrum};

/// `<rgb>` or `<srgb>`: one or three numbers, or `#rrggbb`. sRGB is converted to linear.
pub(super) fn rgb(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = element.required(sink, "value")?;
    let expected = "one or three numbers, or `#rrggbb`";
    let values = if let Some(digits) = text.value.trim().strip_prefix('#') {
        let parsed = (digits.len() == 6)
            .then(|| u32::from_str_radix(digits, 16).ok())
            .flatten();
        let Some(code) = parsed else {
            bad_value(sink, text, expected);
            return None;
        };
        [16, 8, 0].map(|shift| f64::from(code >> shift & 0xff) / 255.0)
    } else {
        let values = numbers(sink, text, &[1, 3], expected)?;
        if values.len() == 1 {
            [values[0]; 3]
        } else {
            [values[0], values[1], values[2]]
        }
    };
    Some(Value::Rgb(if element.tag.value == "srgb" {
        values.map(linear_from_srgb)
    } else {
        values
    }))
}

/// The sRGB curve in double precision (IEC 61966-2-1).
fn linear_from_srgb(v: f64) -> f64 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// `<spectrum>` with the attribute `value` or `filename`.
pub(super) fn spectrum(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = match (element.attribute("value"), element.attribute("filename")) {
        (Some(value), None) => value.clone(),
        (None, Some(name)) => return spectrum_file(sink, element, name).map(Value::Spectrum),
        _ => {
            let message = "<spectrum> needs either `value` or `filename`";
            sink.error_at("scene::missing_attribute", element.tag.span, message);
            return None;
        }
    };
    let expected = "one number, or pairs `wavelength:value` with increasing wavelengths";
    if text.value.contains(':') {
        let samples = wavelength_pairs(&text.value);
        if samples.is_none() {
            bad_value(sink, &text, expected);
        }
        return samples.map(|samples| Value::Spectrum(Spectrum::Sampled(samples)));
    }
    // Three numbers are a color, as in 0.x files.
    let values = numbers(sink, &text, &[1, 3], expected)?;
    Some(match values[..] {
        [r, g, b] => Value::Rgb([r, g, b]),
        _ => Value::Spectrum(Spectrum::Uniform(values[0] as f32)),
    })
}

/// Pairs `wavelength:value` with increasing wavelengths.
fn wavelength_pairs(text: &str) -> Option<Vec<(f32, f32)>> {
    // The pair may have a space after the colon.
    let text = text.replace(": ", ":");
    let pair = |token: &str| {
        let (wavelength, value) = token.split_once(':')?;
        Some((
            parse_finite(wavelength)? as f32,
            parse_finite(value)? as f32,
        ))
    };
    let samples: Vec<(f32, f32)> = tokens(&text).into_iter().map(pair).collect::<Option<_>>()?;
    is_spectrum(&samples).then_some(samples)
}

fn spectrum_file(sink: &Sink, element: &XmlElement, name: &Text) -> Option<Spectrum> {
    let path = find_file(sink, &element.folders, name, "spectrum file")?;
    sink.note_read(&path);
    match read_spectrum(&path) {
        Ok(samples) => Some(Spectrum::Sampled(samples)),
        Err(error) => {
            let message = format!("cannot use the spectrum file {error}");
            let problem = Problem::new("scene::broken_file", name.span, message);
            sink.error(problem.label("this spectrum file"));
            None
        }
    }
}

/// `<blackbody>` with a temperature in kelvin and a scale.
pub(super) fn blackbody(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = element.required(sink, "temperature")?;
    let temperature = parse_finite(text.value.trim().trim_end_matches(['K', 'k']).trim_end());
    let Some(temperature) = temperature.filter(|temperature| *temperature > 0.0) else {
        bad_value(sink, text, "a positive temperature in kelvin");
        return None;
    };
    let scale = match element.attribute("scale") {
        Some(scale) => number(sink, scale)?,
        None => 1.0,
    };
    Some(Value::Spectrum(Spectrum::Blackbody {
        temperature: temperature as f32,
        scale: scale as f32,
    }))
}
