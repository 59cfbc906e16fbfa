//! Inputs of materials and of nested textures: constant or textured.

use crate::color::Rgb;
use crate::ids::TextureId;

/// A color that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorInput {
    /// Constant value.
    Constant(Rgb),
    /// A texture.
    Texture(TextureId),
}

/// A number that may vary over the surface. A texture gives its luminance, as in Mitsuba's
/// `eval_1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// Constant value.
    Constant(f32),
    /// A texture.
    Texture(TextureId),
}

impl ColorInput {
    /// The texture, if there is one.
    pub(crate) fn texture(self) -> Option<TextureId> {
        match self {
            ColorInput::Constant(_) => None,
            ColorInput::Texture(id) => Some(id),
        }
    }
}

impl FloatInput {
    /// The texture, if there is one.
    pub(crate) fn texture(self) -> Option<TextureId> {
        match self {
            FloatInput::Constant(_) => None,
            FloatInput::Texture(id) => Some(id),
        }
    }
}
