//! What parameters hold: numbers, colours, spectra, transforms. The text forms and their errors.

use super::super::sink::{Problem, Sink};
use super::object::{ObjectId, PluginFamily};
use super::xml::{Dialect, Text, XmlElement, find_file};
use crate::resolve::similar;
use crate::spectra::read_spectrum;
use glam::{DMat3, DMat4, DVec3, DVec4};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Float(f64),
    Integer(i64),
    Boolean(bool),
    String(String),
    Vector(DVec3),
    Rgb([f64; 3]),
    Spectrum(Spectrum),
    Transform(DMat4),
    Object(ObjectId),
    /// Already reported; reading it is silent.
    Broken,
}

/// A function of the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    /// The same at every wavelength.
    Uniform(f32),
    /// Pairs of wavelength in nm and value, linear between them.
    Sampled(Vec<(f32, f32)>),
    /// Planck's radiation of a temperature in K, times a factor.
    Blackbody { temperature: f32, scale: f32 },
}

impl Value {
    /// What it is, for messages.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Value::Float(_) => "a number",
            Value::Integer(_) => "an integer",
            Value::Boolean(_) => "a boolean",
            Value::String(_) => "a string",
            Value::Vector(_) => "a vector",
            Value::Rgb(_) => "a color",
            Value::Spectrum(_) => "a spectrum",
            Value::Transform(_) => "a transform",
            Value::Object(_) => "an object",
            Value::Broken => "nothing",
        }
    }
}

/// Tags of values and the steps of transforms, for suggestions.
const VALUE_TAGS: [&str; 14] = [
    "float",
    "integer",
    "boolean",
    "string",
    "point",
    "vector",
    "rgb",
    "srgb",
    "spectrum",
    "blackbody",
    "transform",
    "ref",
    "include",
    "default",
];
const STEP_TAGS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The value in an element, or `None` if the element is no value; a broken one is reported and [`Value::Broken`].
pub(super) fn parse(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let tag = element.tag.value.as_str();
    let value = match tag {
        "float" => number(sink, required_value(sink, element)?).map(Value::Float),
        "integer" => integer(sink, required_value(sink, element)?),
        "boolean" => boolean(sink, required_value(sink, element)?),
        "string" => Some(Value::String(required_value(sink, element)?.value.clone())),
        "point" | "vector" => {
            // 0.x takes absent components for 0.
            let missing = (element.dialect == Dialect::V0).then_some(0.0);
            vector(sink, element, missing).map(Value::Vector)
        }
        "rgb" | "srgb" => rgb(sink, element),
        "spectrum" => spectrum(sink, element),
        "blackbody" => blackbody(sink, element),
        "transform" => transform(sink, element).map(Value::Transform),
        "animation" => {
            let message = "<animation> is not supported; its first transform is used";
            sink.warn_once(
                "animation",
                Problem::new("scene::unsupported", element.tag.span, message),
            );
            element
                .children
                .first()
                .and_then(|first| transform(sink, first))
                .map(Value::Transform)
        }
        _ => {
            unknown_element(sink, element);
            return None;
        }
    };
    check_attributes(sink, element, value_attributes(tag));
    if !matches!(tag, "transform" | "animation") {
        for child in &element.children {
            let message = format!("<{}> cannot stand inside of <{tag}>", child.tag.value);
            sink.error(Problem::new(
                "scene::unexpected_element",
                child.tag.span,
                message,
            ));
        }
    }
    Some(value.unwrap_or(Value::Broken))
}

/// The attributes of a value's element.
fn value_attributes(tag: &str) -> &'static [&'static str] {
    match tag {
        "point" | "vector" => &["name", "value", "x", "y", "z"],
        "spectrum" => &["name", "value", "filename", "intent"],
        "rgb" | "srgb" => &["name", "value", "intent"],
        "blackbody" => &["name", "value", "temperature", "scale"],
        "transform" | "animation" => &["name"],
        _ => &["name", "value"],
    }
}

fn unknown_element(sink: &Sink, element: &XmlElement) {
    let tag = element.tag.value.as_str();
    if STEP_TAGS.contains(&tag.to_lowercase().as_str()) {
        let message = format!("<{tag}> can only stand inside of <transform>");
        sink.error(Problem::new(
            "scene::unexpected_element",
            element.tag.span,
            message,
        ));
        return;
    }
    let families = [
        PluginFamily::Integrator,
        PluginFamily::Sensor,
        PluginFamily::Film,
        PluginFamily::Filter,
        PluginFamily::Sampler,
        PluginFamily::Emitter,
        PluginFamily::Shape,
        PluginFamily::Bsdf,
        PluginFamily::Texture,
        PluginFamily::Medium,
        PluginFamily::Phase,
        PluginFamily::Volume,
    ];
    let known = VALUE_TAGS
        .iter()
        .copied()
        .chain(families.iter().map(|family| family.tag()));
    let help = similar(tag, known).map(|similar| format!("did you mean <{similar}>?"));
    let message = format!("unknown element <{tag}>");
    sink.error(Problem::new("scene::unknown_element", element.tag.span, message).maybe_help(help));
}

/// Reports attributes that are not `known`.
pub(super) fn check_attributes(sink: &Sink, element: &XmlElement, known: &[&str]) {
    for attribute in &element.attributes {
        let name = attribute.name.value.as_str();
        if !known.contains(&name) {
            let help = match similar(name, known.iter().copied()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("known attributes: {}", known.join(", ")),
            };
            let message = format!("<{}> has no attribute `{name}`", element.tag.value);
            sink.error(
                Problem::new("scene::unknown_attribute", attribute.name.span, message).help(help),
            );
        }
    }
}

/// An attribute that must be there.
pub(super) fn required_attribute<'e>(
    sink: &Sink,
    element: &'e XmlElement,
    name: &str,
) -> Option<&'e Text> {
    let found = element.attribute(name);
    if found.is_none() {
        let message = format!("<{}> needs the attribute `{name}`", element.tag.value);
        sink.error(
            Problem::new("scene::missing_attribute", element.tag.span, message)
                .label("in this element"),
        );
    }
    found
}

fn required_value<'e>(sink: &Sink, element: &'e XmlElement) -> Option<&'e Text> {
    required_attribute(sink, element, "value")
}

fn bad_value(sink: &Sink, text: &Text, expected: &str) {
    // Whoever left `$name` in span has reported it.
    if text.value.contains('$') {
        return;
    }
    sink.error(
        Problem::new(
            "scene::bad_value",
            text.span,
            format!("found `{}`, expected {expected}", text.value),
        )
        .label(format!("not {expected}")),
    );
}

/// The parts between blanks and commas.
fn tokens(text: &str) -> Vec<&str> {
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|token| !token.is_empty())
        .collect()
}

fn parse_finite(token: &str) -> Option<f64> {
    token.parse::<f64>().ok().filter(|value| value.is_finite())
}

fn number(sink: &Sink, text: &Text) -> Option<f64> {
    let value = parse_finite(text.value.trim());
    if value.is_none() {
        bad_value(sink, text, "a number");
    }
    value
}

fn numbers(sink: &Sink, text: &Text, counts: &[usize], expected: &str) -> Option<Vec<f64>> {
    let values: Option<Vec<f64>> = tokens(&text.value).into_iter().map(parse_finite).collect();
    let values = values.filter(|values| counts.contains(&values.len()));
    if values.is_none() {
        bad_value(sink, text, expected);
    }
    values
}

fn integer(sink: &Sink, text: &Text) -> Option<Value> {
    let value = text.value.trim().parse::<i64>().ok();
    if value.is_none() {
        bad_value(sink, text, "an integer");
    }
    value.map(Value::Integer)
}

fn boolean(sink: &Sink, text: &Text) -> Option<Value> {
    let value = match text.value.trim().to_lowercase().as_str() {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    };
    if value.is_none() {
        bad_value(sink, text, "`true` or `false`");
    }
    value.map(Value::Boolean)
}

/// From `value` (one or three numbers) or `x`, `y`, `z`; those that are absent are `missing`, or an error.
fn vector(sink: &Sink, element: &XmlElement, missing: Option<f64>) -> Option<DVec3> {
    if let Some(value) = element.attribute("value") {
        if let Some(mixed) = ["x", "y", "z"]
            .iter()
            .find_map(|name| element.attribute(name))
        {
            let message = "`value` and `x`, `y`, `z` exclude each other";
            sink.error(Problem::new("scene::bad_value", mixed.span, message));
        }
        let values = numbers(sink, value, &[1, 3], "one or three numbers")?;
        return Some(if values.len() == 1 {
            DVec3::splat(values[0])
        } else {
            DVec3::from_slice(&values)
        });
    }
    let mut vector = DVec3::ZERO;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        vector[axis] = match (element.attribute(name), missing) {
            (Some(text), _) => number(sink, text)?,
            (None, Some(missing)) => missing,
            (None, None) => {
                required_attribute(sink, element, name);
                return None;
            }
        };
    }
    Some(vector)
}

fn rgb(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = required_value(sink, element)?;
    let encoded = element.tag.value == "srgb";
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
    Some(Value::Rgb(if encoded {
        values.map(linear_from_srgb)
    } else {
        values
    }))
}

fn linear_from_srgb(v: f64) -> f64 {
    // IEC 61966-2-1.
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

fn spectrum(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = match (element.attribute("value"), element.attribute("filename")) {
        (Some(value), None) => value.clone(),
        (None, Some(name)) => return spectrum_file(sink, element, name).map(Value::Spectrum),
        _ => {
            let message = "<spectrum> needs either `value` or `filename`";
            sink.error(Problem::new(
                "scene::missing_attribute",
                element.tag.span,
                message,
            ));
            return None;
        }
    };
    let expected = "one number, or pairs `wavelength:value` with growing wavelengths";
    if text.value.contains(':') {
        let samples = wavelength_pairs(&text.value);
        if samples.is_none() {
            bad_value(sink, &text, expected);
        }
        return samples.map(|samples| Value::Spectrum(Spectrum::Sampled(samples)));
    }
    // Three numbers are a color in 0.x files.
    let values = numbers(sink, &text, &[1, 3], expected)?;
    Some(match values[..] {
        [r, g, b] => Value::Rgb([r, g, b]),
        _ => Value::Spectrum(Spectrum::Uniform(values[0] as f32)),
    })
}

fn wavelength_pairs(text: &str) -> Option<Vec<(f32, f32)>> {
    // A blank after the colon belongs to the pair.
    let text = text.replace(": ", ":");
    let pair = |token: &str| {
        let (wavelength, value) = token.split_once(':')?;
        Some((
            parse_finite(wavelength)? as f32,
            parse_finite(value)? as f32,
        ))
    };
    let samples: Vec<(f32, f32)> = tokens(&text).into_iter().map(pair).collect::<Option<_>>()?;
    growing(&samples).then_some(samples)
}

fn growing(samples: &[(f32, f32)]) -> bool {
    !samples.is_empty() && samples.windows(2).all(|pair| pair[0].0 < pair[1].0)
}

fn spectrum_file(sink: &Sink, element: &XmlElement, name: &Text) -> Option<Spectrum> {
    let path = find_file(sink, &element.folders, name, "spectrum")?;
    match read_spectrum(&path) {
        Ok(samples) => Some(Spectrum::Sampled(samples)),
        Err(error) => {
            let report = Problem::new(
                "scene::broken_file",
                name.span,
                format!("cannot use the spectrum {error}"),
            );
            sink.error(report.label("this spectrum"));
            None
        }
    }
}

fn blackbody(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let text = required_attribute(sink, element, "temperature")?;
    let temperature = parse_finite(text.value.trim().trim_end_matches(['K', 'k']).trim_end());
    let Some(temperature) = temperature.filter(|temperature| *temperature > 0.0) else {
        bad_value(sink, text, "a temperature in kelvin");
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

/// The steps of a transform, the first applied first.
fn transform(sink: &Sink, element: &XmlElement) -> Option<DMat4> {
    let mut result = Some(DMat4::IDENTITY);
    for step in &element.children {
        let matrix = transform_step(sink, step);
        result = matrix.zip(result).map(|(matrix, result)| matrix * result);
    }
    result
}

fn transform_step(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let name = step.tag.value.to_lowercase();
    let attributes: &[&str] = match name.as_str() {
        "rotate" => &["angle", "value", "x", "y", "z"],
        "lookat" => &["origin", "target", "up"],
        "matrix" => &["value"],
        _ => &["value", "x", "y", "z"],
    };
    let matrix = match name.as_str() {
        "translate" => vector(sink, step, Some(0.0)).map(DMat4::from_translation),
        "scale" => vector(sink, step, Some(1.0)).map(DMat4::from_scale),
        "rotate" => rotation(sink, step),
        "lookat" => look_at(sink, step),
        "matrix" => matrix(sink, step),
        _ => {
            let help =
                similar(&name, STEP_TAGS).map(|similar| format!("did you mean <{similar}>?"));
            let message = format!("<{}> is no step of a transform", step.tag.value);
            sink.error(
                Problem::new("scene::unknown_element", step.tag.span, message).maybe_help(help),
            );
            return None;
        }
    };
    check_attributes(sink, step, attributes);
    matrix
}

fn rotation(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let axis = vector(sink, step, Some(0.0))?;
    let angle = number(sink, required_attribute(sink, step, "angle")?)?;
    if axis == DVec3::ZERO {
        let message = "the axis of a rotation must not be zero";
        sink.error(
            Problem::new("scene::bad_value", step.tag.span, message)
                .help("expected for instance `y=\"1\"`"),
        );
        return None;
    }
    Some(match step.dialect {
        Dialect::V0 => DMat4::from_axis_angle(axis.normalize(), angle.to_radians()),
        Dialect::V3 => {
            warn_unless_unit(sink, step, axis);
            rodrigues(axis, angle.to_radians())
        }
    })
}

/// Version 3 takes the axis as it stands, so that another length than 1 also scales and shears.
fn warn_unless_unit(sink: &Sink, step: &XmlElement, axis: DVec3) {
    const TOLERANCE: f64 = 0.01;
    let length = axis.length();
    if (length - 1.0).abs() > TOLERANCE {
        let message = format!("the axis of this rotation has length {length:.3}, not 1");
        sink.warn(
            Problem::new("scene::axis_length", step.tag.span, message)
                .help("as in Mitsuba 3 it is used as it stands, and the result is no rotation"),
        );
    }
}

/// `cosθ I + (1 - cosθ) a aᵀ + sinθ [a]×`, for an axis of any length.
fn rodrigues(axis: DVec3, angle: f64) -> DMat4 {
    let (sin, cos) = angle.sin_cos();
    let column =
        |unit: DVec3| unit * cos + axis * (axis.dot(unit) * (1.0 - cos)) + axis.cross(unit) * sin;
    DMat4::from_mat3(DMat3::from_cols(
        column(DVec3::X),
        column(DVec3::Y),
        column(DVec3::Z),
    ))
}

fn look_at(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let point = |text: &Text| {
        numbers(sink, text, &[3], "three numbers").map(|values| DVec3::from_slice(&values))
    };
    let origin = point(required_attribute(sink, step, "origin")?)?;
    let target = point(required_attribute(sink, step, "target")?)?;
    let up = match step.attribute("up") {
        Some(up) => point(up)?,
        None => DVec3::ZERO,
    };
    let forward = (target - origin).normalize_or_zero();
    let up = if up == DVec3::ZERO {
        forward.any_orthonormal_vector()
    } else {
        up
    };
    let left = up.cross(forward).normalize_or_zero();
    if forward == DVec3::ZERO || left == DVec3::ZERO {
        let message = "lookat needs a `target` apart from `origin`, and an `up` across the view";
        sink.error(
            Problem::new("scene::bad_value", step.tag.span, message).label("no view is defined"),
        );
        return None;
    }
    let up = forward.cross(left);
    Some(DMat4::from_cols(
        left.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        origin.extend(1.0),
    ))
}

fn matrix(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let text = required_value(sink, step)?;
    let values = numbers(sink, text, &[9, 16], "9 or 16 numbers")?;
    let size = if values.len() == 16 { 4 } else { 3 };
    let mut result = DMat4::IDENTITY;
    for (index, value) in values.iter().enumerate() {
        result.col_mut(index % size)[index / size] = *value;
    }
    if result.row(3) != DVec4::W {
        let message = "the last row of the matrix must be `0 0 0 1`: projections are not supported";
        sink.error(Problem::new("scene::bad_value", text.span, message));
        return None;
    }
    Some(result)
}
