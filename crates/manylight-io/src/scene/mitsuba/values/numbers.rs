//! Numbers and vectors in attributes.

use super::super::super::sink::{Problem, Sink, Text};
use super::super::xml::XmlElement;
use super::value::Value;
use glam::DVec3;

/// Reports an invalid attribute value.
pub(super) fn bad_value(sink: &Sink, text: &Text, expected: &str) {
    // An undefined `$name` has been reported.
    if text.value.contains('$') {
        return;
    }
    let message = format!("found `{}`, expected {expected}", text.value);
    let problem = Problem::new("scene::bad_value", text.span, message);
    sink.error(problem.label(format!("not {expected}")));
}

/// The parts of `text` between white space and commas.
pub(super) fn tokens(text: &str) -> Vec<&str> {
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|token| !token.is_empty())
        .collect()
}

pub(super) fn parse_finite(token: &str) -> Option<f64> {
    token.parse::<f64>().ok().filter(|value| value.is_finite())
}

pub(super) fn number(sink: &Sink, text: &Text) -> Option<f64> {
    let value = parse_finite(text.value.trim());
    if value.is_none() {
        bad_value(sink, text, "a number");
    }
    value
}

/// A list of finite numbers in single precision. `None` if another word is in the text.
pub(in super::super) fn number_list(text: &str) -> Option<Vec<f32>> {
    let number = |token: &str| token.parse().ok().filter(|v: &f32| v.is_finite());
    tokens(text).into_iter().map(number).collect()
}

/// A list of numbers, with one of the lengths `counts`.
pub(super) fn numbers(
    sink: &Sink,
    text: &Text,
    counts: &[usize],
    expected: &str,
) -> Option<Vec<f64>> {
    let values: Option<Vec<f64>> = tokens(&text.value).into_iter().map(parse_finite).collect();
    let values = values.filter(|values| counts.contains(&values.len()));
    if values.is_none() {
        bad_value(sink, text, expected);
    }
    values
}

pub(super) fn integer(sink: &Sink, text: &Text) -> Option<Value> {
    let value = text.value.trim().parse::<i64>().ok();
    if value.is_none() {
        bad_value(sink, text, "an integer");
    }
    value.map(Value::Integer)
}

pub(super) fn boolean(sink: &Sink, text: &Text) -> Option<Value> {
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

/// The vector of the attribute `value` (one or three numbers) or of `x`, `y` and `z`. An absent
/// component is `missing`, or an error.
pub(super) fn vector(sink: &Sink, element: &XmlElement, missing: Option<f64>) -> Option<DVec3> {
    if let Some(value) = element.attribute("value") {
        if let Some(mixed) = ["x", "y", "z"]
            .iter()
            .find_map(|name| element.attribute(name))
        {
            let message = "found both `value` and `x`, `y`, `z`, expected one of them";
            sink.error_at("scene::bad_value", mixed.span, message);
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
