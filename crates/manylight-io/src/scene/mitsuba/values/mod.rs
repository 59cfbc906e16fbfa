//! Parsing of parameter values: numbers, vectors, colors, spectra and transforms.

mod color;
mod transform;

use super::super::sink::{Problem, Sink};
use super::object::{ObjectId, PluginFamily};
use super::xml::{Dialect, Text, XmlElement};
use crate::resolve::similar;
use glam::{DMat4, DVec3};

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
    /// An invalid value. It has been reported, so reading it reports nothing.
    Broken,
}

/// A spectrum, a function of the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    /// Constant over all wavelengths.
    Uniform(f32),
    /// Pairs of wavelength in nm and value, linearly interpolated.
    Sampled(Vec<(f32, f32)>),
    /// Emission of a black body of this temperature in kelvin, times `scale`.
    Blackbody { temperature: f32, scale: f32 },
}

impl Value {
    /// The type of the value, for messages.
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

/// Tags of values and of special elements, for suggestions.
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
/// Tags of the elements in `<transform>`.
const STEP_TAGS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The value of an element. `None` if the element is not a value; [`Value::Broken`] if the value is invalid. Both are reported.
pub(super) fn parse(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let tag = element.tag.value.as_str();
    let value = match tag {
        "float" => number(sink, element.required(sink, "value")?).map(Value::Float),
        "integer" => integer(sink, element.required(sink, "value")?),
        "boolean" => boolean(sink, element.required(sink, "value")?),
        "string" => Some(Value::String(
            element.required(sink, "value")?.value.clone(),
        )),
        "point" | "vector" => {
            // Absent components are 0 in 0.x, and errors since version 2.
            let missing = (element.dialect == Dialect::V0).then_some(0.0);
            vector(sink, element, missing).map(Value::Vector)
        }
        "rgb" | "srgb" => color::rgb(sink, element),
        "spectrum" => color::spectrum(sink, element),
        "blackbody" => color::blackbody(sink, element),
        "transform" => transform::matrix_of(sink, element).map(Value::Transform),
        "animation" => {
            let message = "<animation> is not supported; its first transform is used";
            sink.warn_once(
                "animation",
                Problem::new("scene::unsupported", element.tag.span, message),
            );
            element
                .children
                .first()
                .and_then(|first| transform::matrix_of(sink, first))
                .map(Value::Transform)
        }
        _ => {
            unknown_element(sink, element);
            return None;
        }
    };
    element.check_attributes(sink, value_attributes(tag));
    if !matches!(tag, "transform" | "animation") {
        for child in &element.children {
            let message = format!("<{}> cannot be nested in <{tag}>", child.tag.value);
            sink.error(Problem::new(
                "scene::unexpected_element",
                child.tag.span,
                message,
            ));
        }
    }
    Some(value.unwrap_or(Value::Broken))
}

/// The attributes that the element of a value may have.
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

/// Reports an element that is not a value.
fn unknown_element(sink: &Sink, element: &XmlElement) {
    let tag = element.tag.value.as_str();
    if STEP_TAGS.contains(&tag.to_lowercase().as_str()) {
        let message = format!("<{tag}> must be nested in <transform>");
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

/// Reports an invalid attribute value.
fn bad_value(sink: &Sink, text: &Text, expected: &str) {
    // An undefined `$name` has been reported.
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

/// The parts of `text` between white space and commas.
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

/// A list of numbers, with one of the lengths `counts`.
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

/// The vector of the attribute `value` (one or three numbers) or of `x`, `y` and `z`. An absent component is `missing`, or an
/// error.
fn vector(sink: &Sink, element: &XmlElement, missing: Option<f64>) -> Option<DVec3> {
    if let Some(value) = element.attribute("value") {
        if let Some(mixed) = ["x", "y", "z"]
            .iter()
            .find_map(|name| element.attribute(name))
        {
            let message = "found both `value` and `x`, `y`, `z`, expected one of them";
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
                element.required(sink, name);
                return None;
            }
        };
    }
    Some(vector)
}
