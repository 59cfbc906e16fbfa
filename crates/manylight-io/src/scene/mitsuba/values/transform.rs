//! Values that are transforms.

use super::super::super::motion::KeyFrame;
use super::super::super::sink::{Problem, Sink, Text};
use super::super::xml::{Dialect, XmlElement};
use super::numbers::{number, numbers, vector};
use crate::suggest::similar;
use glam::{DMat3, DMat4, DVec3, DVec4};

/// Tags of the elements in `<transform>`.
pub(super) const STEP_TAGS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The matrix of a `<transform>`: its steps in order, the first applied first.
pub(super) fn matrix_of(sink: &Sink, element: &XmlElement) -> Option<DMat4> {
    let mut result = Some(DMat4::IDENTITY);
    for step in &element.children {
        let matrix = step_matrix(sink, step);
        result = matrix.zip(result).map(|(matrix, result)| matrix * result);
    }
    result
}

/// The key frames of an `<animation>`: transforms with times in s.
pub(super) fn key_frames(sink: &Sink, element: &XmlElement) -> Option<Vec<KeyFrame>> {
    let key = |child: &XmlElement| {
        if child.tag.value != "transform" {
            let message = format!("<{}> cannot be nested in <animation>", child.tag.value);
            sink.error_at("scene::unexpected_element", child.tag.span, message);
            return None;
        }
        child.check_attributes(sink, &["time"]);
        let time = number(sink, child.required(sink, "time")?);
        time.zip(matrix_of(sink, child))
    };
    if element.children.is_empty() {
        let problem = Problem::new(
            "scene::bad_value",
            element.tag.span,
            "an animation is empty",
        );
        sink.error(problem.help("expected <transform> elements, each with a `time`"));
        return None;
    }
    let keys: Vec<Option<KeyFrame>> = element.children.iter().map(key).collect();
    keys.into_iter().collect()
}

/// The matrix of one step.
fn step_matrix(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
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
            let help = match similar(&name, STEP_TAGS) {
                Some(similar) => format!("did you mean <{similar}>?"),
                None => format!("expected one of {}", STEP_TAGS.join(", ")),
            };
            let message = format!("unknown element <{}> in a transform", step.tag.value);
            sink.error(Problem::new("scene::unknown_element", step.tag.span, message).help(help));
            return None;
        }
    };
    step.check_attributes(sink, attributes);
    matrix
}

/// A rotation by `angle` in degrees. Version 3 uses the axis without normalizing it.
fn rotation(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let axis = vector(sink, step, Some(0.0))?;
    let angle = number(sink, step.required(sink, "angle")?)?;
    if axis == DVec3::ZERO {
        let message = "the axis of this rotation is zero";
        let problem = Problem::new("scene::bad_value", step.tag.span, message);
        sink.error(problem.help("expected a nonzero axis, for example `y=\"1\"`"));
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

/// Warns about an axis that is not a unit vector: since version 3 it is not normalized, so the
/// matrix also scales and shears.
fn warn_unless_unit(sink: &Sink, step: &XmlElement, axis: DVec3) {
    /// Tolerated deviation of the length from 1.
    const TOLERANCE: f64 = 0.01;
    let length = axis.length();
    if (length - 1.0).abs() > TOLERANCE {
        let message = format!("the axis of this rotation has length {length:.3}, not 1");
        let help =
            "as in Mitsuba 3, the axis is not normalized, so the transform is not a rotation";
        sink.warn(Problem::new("scene::axis_length", step.tag.span, message).help(help));
    }
}

/// Rodrigues' formula `cosθ I + (1 - cosθ) a aᵀ + sinθ [a]×` for an axis of any length and an angle
/// in radians.
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

/// The frame with z towards `target`, y near `up` and x to the left.
fn look_at(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let point = |text: &Text| {
        numbers(sink, text, &[3], "three numbers").map(|values| DVec3::from_slice(&values))
    };
    let origin = point(step.required(sink, "origin")?)?;
    let target = point(step.required(sink, "target")?)?;
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
        let message = "this lookat defines no view";
        let help = "expected `target` different from `origin`, and `up` not parallel to the view direction";
        sink.error(Problem::new("scene::bad_value", step.tag.span, message).help(help));
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

/// A matrix of 9 or 16 numbers, row by row.
fn matrix(sink: &Sink, step: &XmlElement) -> Option<DMat4> {
    let text = step.required(sink, "value")?;
    let values = numbers(sink, text, &[9, 16], "9 or 16 numbers")?;
    let size = if values.len() == 16 { 4 } else { 3 };
    let mut result = DMat4::IDENTITY;
    for (index, value) in values.iter().enumerate() {
        result.col_mut(index % size)[index / size] = *value;
    }
    if result.row(3) != DVec4::W {
        let message =
            "the last row of the matrix is not `0 0 0 1`; projective transforms are not supported";
        sink.error_at("scene::bad_value", text.span, message);
        return None;
    }
    Some(result)
}
