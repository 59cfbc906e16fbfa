//! Inputs of materials and of nested textures: constant or textured.

use super::{Texture, TexturePoint};
use crate::color::Rgb;
use crate::geometry::SurfacePoints;
use crate::ids::TextureId;
use crate::lanes::{Color, Float, Width};

/// A color that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorInput {
    /// Constant value.
    Constant(Rgb),
    /// A texture.
    Texture(TextureId),
}

/// A number that may vary over the surface. A texture gives its luminance, as in Mitsuba's `eval_1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// Constant value.
    Constant(f32),
    /// A texture.
    Texture(TextureId),
}

impl ColorInput {
    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        match *self {
            ColorInput::Constant(c) => c,
            ColorInput::Texture(id) => textures[id.index()].eval(at, textures),
        }
    }

    /// Value in each lane.
    #[inline(always)]
    pub(crate) fn eval_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Color<S> {
        match *self {
            ColorInput::Constant(c) => Color::splat(x.offset.width(), c),
            ColorInput::Texture(id) => {
                let texture = &textures[id.index()];
                texture.lookup(x.into(), textures).color()
            }
        }
    }

    pub(super) fn max_channel(&self, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.max_channel(),
            ColorInput::Texture(id) => textures[id.index()].max_channel(textures),
        }
    }

    pub(super) fn max_luminance(&self, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.luminance(),
            ColorInput::Texture(id) => textures[id.index()].max_luminance(textures),
        }
    }
}

impl FloatInput {
    /// Value in each lane.
    #[inline(always)]
    pub(crate) fn eval_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Float<S> {
        match *self {
            FloatInput::Constant(c) => Float::splat(x.offset.width(), c),
            FloatInput::Texture(id) => {
                let texture = &textures[id.index()];
                texture.lookup(x.into(), textures).value()
            }
        }
    }

    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        match *self {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => textures[id.index()].eval_float(at, textures),
        }
    }
}
