//! What is painted on surfaces.

mod bitmap;
#[cfg(test)]
mod tests;

pub use bitmap::{Bitmap, Filtering, Wrap};

use crate::color::Rgb;
use crate::ids::TextureId;
use crate::math::{Mat3, Vec2};

/// A function of the surface's uv coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// An image.
    Bitmap(Bitmap),
    /// Two colors in a checker pattern: one period per unit of (transformed) uv.
    Checkerboard {
        /// Where the fractions of u and v are both up to 1/2 or both above. Nested textures see the surface's uv.
        color0: ColorInput,
        /// On the other cells.
        color1: ColorInput,
        /// Applied to (u, v, 1).
        uv_transform: Mat3,
    },
}

impl Texture {
    /// Color at `uv`, filtered. `textures` are those of the scene, among which nested ones are found.
    pub fn eval(&self, uv: Vec2, textures: &[Texture]) -> Rgb {
        match self {
            Texture::Bitmap(bitmap) => bitmap.eval(uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let color = if is_main_cell(*uv_transform, uv) {
                    color0
                } else {
                    color1
                };
                color.eval(uv, textures)
            }
        }
    }

    /// Asks for the memory that evaluation at `uv` will read; nested textures are left out.
    #[inline]
    pub fn prefetch(&self, uv: Vec2) {
        if let Texture::Bitmap(bitmap) = self {
            bitmap.prefetch(uv);
        }
    }

    /// Luminance at `uv`, filtered: what float parameters see.
    ///
    /// As Mitsuba 3.9.1's `eval_1`, which lays the two values of a checkerboard the other way round than `eval` does.
    pub fn eval_float(&self, uv: Vec2, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.eval_float(uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let color = if is_main_cell(*uv_transform, uv) {
                    color1
                } else {
                    color0
                };
                color.eval_float(uv, textures)
            }
        }
    }

    /// Derivatives of [`Texture::eval_float`] by u and v at `uv`, for bump maps; texel-wise as Mitsuba's `eval_1_grad`.
    pub fn gradient(&self, uv: Vec2) -> Vec2 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.gradient(uv),
            Texture::Checkerboard { .. } => Vec2::ZERO,
        }
    }

    /// An upper bound of the luminance anywhere.
    pub fn max_luminance(&self, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.max_luminance(),
            Texture::Checkerboard { color0, color1, .. } => {
                let [a, b] = [color0, color1].map(|color| color.max_luminance(textures));
                a.max(b)
            }
        }
    }

    /// The textures that this one is made of.
    pub(crate) fn nested(&self) -> impl Iterator<Item = TextureId> {
        let inputs = match self {
            Texture::Bitmap(_) => [None, None],
            Texture::Checkerboard { color0, color1, .. } => [Some(*color0), Some(*color1)],
        };
        inputs
            .into_iter()
            .flatten()
            .filter_map(|input| match input {
                ColorInput::Texture(id) => Some(id),
                ColorInput::Constant(_) => None,
            })
    }
}

fn is_main_cell(uv_transform: Mat3, uv: Vec2) -> bool {
    let p = uv_transform.transform_point2(uv);
    let upper = (p - p.floor()).cmpgt(Vec2::splat(0.5));
    upper.x == upper.y
}

/// A color that may vary over the surface.
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
            ColorInput::Texture(id) => textures[id.index()].eval(uv, textures),
        }
    }

    /// As [`Texture::expect`].
    #[inline]
    pub fn prefetch(&self, uv: Vec2, textures: &[Texture]) {
        if let ColorInput::Texture(id) = self {
            textures[id.index()].prefetch(uv);
        }
    }

    /// Luminance at `uv`: what float parameters see.
    fn eval_float(&self, uv: Vec2, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.luminance(),
            ColorInput::Texture(id) => textures[id.index()].eval_float(uv, textures),
        }
    }

    fn max_luminance(&self, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.luminance(),
            ColorInput::Texture(id) => textures[id.index()].max_luminance(textures),
        }
    }
}

impl FloatInput {
    /// Value at `uv`.
    #[inline]
    pub fn eval(&self, uv: Vec2, textures: &[Texture]) -> f32 {
        match *self {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => textures[id.index()].eval_float(uv, textures),
        }
    }
}
