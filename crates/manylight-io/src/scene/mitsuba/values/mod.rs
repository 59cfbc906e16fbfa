//! Parsing of parameter values: numbers, vectors, colors, spectra and transforms.

mod color;
mod numbers;
mod transform;
mod value;

pub(super) use numbers::number_list;
pub(super) use value::{ObjectId, Spectrum, Value};

use super::super::sink::{Problem, Sink};
use super::family::PluginFamily;
use super::xml::{Dialect, XmlElement};
use crate::suggest::similar;
use numbers::{boolean, integer, number, vector};
use transform::STEP_TAGS;

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

/// The value of an element. `None` if the element is not a value; [`Value::Broken`] if the value is
/// invalid. Both are reported.
pub(super) fn parse(sink: &Sink, element: &XmlElement) -> Option<Value> {
    let tag = element.tag.value.as_str();
    let value = match tag {
        "float" => number(sink, element.required(sink, "value")?).map(Value::Float),
        "integer" => integer(sink, element.required(sink, "value")?),
        "boolean" => boolean(sink, element.required(sink, "value")?),
        "string" => Some(Value::String(element.required(sink, "value")?.clone())),
        "point" | "vector" => {
            // Absent components are 0 in 0.x, and errors since version 2.
            let missing = (element.dialect == Dialect::V0).then_some(0.0);
            vector(sink, element, missing).map(Value::Vector)
        }
        "rgb" | "srgb" => color::rgb(sink, element),
        "spectrum" => color::spectrum(sink, element),
        "blackbody" => color::blackbody(sink, element),
        "transform" => transform::matrix_of(sink, element).map(Value::Transform),
        "animation" => transform::key_frames(sink, element).map(Value::Animation),
        _ => {
            unknown_element(sink, element);
            return None;
        }
    };
    element.check_attributes(sink, value_attributes(tag));
    if !matches!(tag, "transform" | "animation") {
        for child in &element.children {
            let message = format!("<{}> cannot be nested in <{tag}>", child.tag.value);
            sink.error_at("scene::unexpected_element", child.tag.span, message);
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
        sink.error_at("scene::unexpected_element", element.tag.span, message);
        return;
    }
    let known = VALUE_TAGS.into_iter().chain(PluginFamily::nested_tags());
    let help = similar(tag, known).map(|similar| format!("did you mean <{similar}>?"));
    let message = format!("unknown element <{tag}>");
    sink.error(Problem::new("scene::unknown_element", element.tag.span, message).maybe_help(help));
}
