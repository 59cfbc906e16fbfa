//! What is painted on surfaces.

mod bitmap;

pub use bitmap::{Bitmap, Filtering, Wrap};

use crate::color::Rgb;
use crate::ids::TextureId;
use crate::math::{Mat3, Vec2};

/// A function of the surface's uv coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// An image.
    Bitmap(Bitmap),
    /// Two colours in a checker pattern: one period per unit of (transformed) uv.
    Checkerboard {
        /// On the cells where floor(2u) + floor(2v) is even, as Mitsuba lays them.
        color0: Rgb,
        /// On the others.
        color1: Rgb,
        /// Applied to (u, v, 1).
        uv_transform: Mat3,
    },
}

impl Texture {
    /// Value at `uv`, filtered.
    pub fn eval(&self, _uv: Vec2) -> Rgb {
        todo!()
    }

    /// Derivatives of the first channel by u and v at `uv`, for bump maps; texel-wise as Mitsuba's `eval_1_grad`.
    pub fn gradient(&self, _uv: Vec2) -> Vec2 {
        todo!()
    }
}

/// A colour that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorInput {
    /// The same everywhere.
    Constant(Rgb),
    /// A texture.
    Texture(TextureId),
}

/// A number that may vary over the surface; a texture gives its luminance, as Mitsuba's `eval_1` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// The same everywhere.
    Constant(f32),
    /// A texture.
    Texture(TextureId),
}

impl ColorInput {
    /// Value at `uv`.
    #[inline]
    pub fn eval(&self, uv: Vec2, textures: &[Texture]) -> Rgb {
        match *self {
            ColorInput::Constant(c) => c,
            ColorInput::Texture(id) => textures[id.index()].eval(uv),
        }
    }
}

impl FloatInput {
    /// Value at `uv`.
    #[inline]
    pub fn eval(&self, uv: Vec2, textures: &[Texture]) -> f32 {
        match *self {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => textures[id.index()].eval(uv).luminance(),
        }
    }
}
