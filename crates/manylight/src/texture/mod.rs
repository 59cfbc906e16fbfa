//! Textures, and material inputs that are constant or textured.

mod bitmap;
#[cfg(test)]
mod tests;

pub use bitmap::{Bitmap, Filtering, Wrap};

use crate::color::Rgb;
use crate::ids::TextureId;
use crate::math::{Mat3, Vec2};

/// A color as a function of texture coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// An image.
    Bitmap(Bitmap),
    /// A checkerboard of two colors, with one period per unit of transformed uv.
    Checkerboard {
        /// Color of the cells in which the fractions of u and v are both up to 1/2 or both above. Nested textures get the untransformed uv.
        color0: ColorInput,
        /// Color of the other cells.
        color1: ColorInput,
        /// Transform of (u, v, 1).
        uv_transform: Mat3,
    },
}

impl Texture {
    /// Filtered color at `uv`. `textures` are all textures of the scene, for nested ones.
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

    /// Prefetches the memory that evaluation at `uv` reads, without nested textures.
    #[inline]
    pub fn prefetch(&self, uv: Vec2) {
        if let Texture::Bitmap(bitmap) = self {
            bitmap.prefetch(uv);
        }
    }

    /// Filtered luminance at `uv`, for float parameters.
    ///
    /// As in Mitsuba 3.9.1's `eval_1`, the cells of a checkerboard are swapped against [`Texture::eval`].
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

    /// Derivatives of [`Texture::eval_float`] by u and by v at `uv`, for bump maps. As in Mitsuba's `eval_1_grad`, from the four texels of the
    /// lookup; 0 for checkerboards.
    pub fn gradient(&self, uv: Vec2) -> Vec2 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.gradient(uv),
            Texture::Checkerboard { .. } => Vec2::ZERO,
        }
    }

    /// Upper bound of the luminance over all uv.
    pub fn max_luminance(&self, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.max_luminance(),
            Texture::Checkerboard { color0, color1, .. } => {
                let [a, b] = [color0, color1].map(|color| color.max_luminance(textures));
                a.max(b)
            }
        }
    }

    /// Ids of the nested textures.
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

/// Whether `uv` lies in a cell of `color0`.
fn is_main_cell(uv_transform: Mat3, uv: Vec2) -> bool {
    let p = uv_transform.transform_point2(uv);
    let upper = (p - p.floor()).cmpgt(Vec2::splat(0.5));
    upper.x == upper.y
}

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
    /// Value at `uv`.
    #[inline]
    pub fn eval(&self, uv: Vec2, textures: &[Texture]) -> Rgb {
        match *self {
            ColorInput::Constant(c) => c,
            ColorInput::Texture(id) => textures[id.index()].eval(uv, textures),
        }
    }

    /// [`Texture::prefetch`] of a textured input.
    #[inline]
    pub fn prefetch(&self, uv: Vec2, textures: &[Texture]) {
        if let ColorInput::Texture(id) = self {
            textures[id.index()].prefetch(uv);
        }
    }

    /// Luminance at `uv`, for float parameters.
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
