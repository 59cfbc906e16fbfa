//! Declared types and values of parameters.

use super::super::sink::{FileSpan, Text};

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Numbers(Vec<f32>),
    Integers(Vec<i32>),
    Strings(Vec<Text>),
    Bools(Vec<bool>),
}

impl Values {
    /// Number of values.
    pub(super) fn len(&self) -> usize {
        match self {
            Values::Numbers(values) => values.len(),
            Values::Integers(values) => values.len(),
            Values::Strings(values) => values.len(),
            Values::Bools(values) => values.len(),
        }
    }
}

/// A declared type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParamType {
    Integer,
    Float,
    Point2,
    Point3,
    Vector2,
    Vector3,
    Normal,
    Spectrum,
    Rgb,
    Xyz,
    Blackbody,
    Bool,
    String,
    Texture,
}

/// Names of types; those of PBRT v3 last.
pub(super) const TYPE_NAMES: [(&str, ParamType); 19] = [
    ("integer", ParamType::Integer),
    ("float", ParamType::Float),
    ("point2", ParamType::Point2),
    ("point3", ParamType::Point3),
    ("vector2", ParamType::Vector2),
    ("vector3", ParamType::Vector3),
    ("normal", ParamType::Normal),
    ("spectrum", ParamType::Spectrum),
    ("rgb", ParamType::Rgb),
    ("blackbody", ParamType::Blackbody),
    ("bool", ParamType::Bool),
    ("string", ParamType::String),
    ("texture", ParamType::Texture),
    ("point", ParamType::Point3),
    ("vector", ParamType::Vector3),
    ("normal3", ParamType::Normal),
    ("color", ParamType::Rgb),
    ("xyz", ParamType::Xyz),
    ("point4", ParamType::Float),
];

impl ParamType {
    /// The current name of the type.
    pub(super) fn name(self) -> &'static str {
        TYPE_NAMES
            .iter()
            .find(|(_, ty)| *ty == self)
            .map_or("", |(name, _)| *name)
    }

    /// Number of values of one element.
    pub(super) fn arity(self) -> usize {
        match self {
            ParamType::Point2 | ParamType::Vector2 => 2,
            ParamType::Point3
            | ParamType::Vector3
            | ParamType::Normal
            | ParamType::Rgb
            | ParamType::Xyz => 3,
            _ => 1,
        }
    }
}

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub(super) ty: ParamType,
    pub(super) name: Text,
    pub(super) values: Values,
    /// Location of the value.
    pub(super) span: FileSpan,
}
