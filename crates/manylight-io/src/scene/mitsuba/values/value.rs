//! Values of parameters.

use super::super::super::motion::KeyFrame;
use super::super::super::sink::Text;
use glam::{DMat4, DVec3};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) enum Value {
    Float(f64),
    Integer(i64),
    Boolean(bool),
    String(Text),
    Vector(DVec3),
    Rgb([f64; 3]),
    Spectrum(Spectrum),
    Transform(DMat4),
    /// Key frames of a transform, at least one.
    Animation(Vec<KeyFrame>),
    Object(ObjectId),
    /// An invalid value. It has been reported, so reading it reports nothing.
    Broken,
}

/// Index of an object in the tree of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in super::super) struct ObjectId(pub(in super::super) usize);

/// A spectrum, a function of the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) enum Spectrum {
    /// Constant over all wavelengths.
    Uniform(f32),
    /// Pairs of wavelength in nm and value, linearly interpolated.
    Sampled(Vec<(f32, f32)>),
    /// Emission of a black body of this temperature in kelvin, times `scale`.
    Blackbody { temperature: f32, scale: f32 },
}

impl Value {
    /// The type of the value, for messages.
    pub(in super::super) fn describe(&self) -> &'static str {
        match self {
            Value::Float(_) => "a number",
            Value::Integer(_) => "an integer",
            Value::Boolean(_) => "a boolean",
            Value::String(_) => "a string",
            Value::Vector(_) => "a vector",
            Value::Rgb(_) => "a color",
            Value::Spectrum(_) => "a spectrum",
            Value::Transform(_) => "a transform",
            Value::Animation(_) => "an animation",
            Value::Object(_) => "an object",
            Value::Broken => "nothing",
        }
    }
}
