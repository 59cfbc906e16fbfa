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
    /// The product of two colors.
    Product {
        /// The first color.
        input: ColorInput,
        /// The second color.
        factor: ColorInput,
    },
    /// `first` with weight 1 - w, `second` with weight w.
    Mix {
        /// At w = 0.
        first: ColorInput,
        /// At w = 1.
        second: ColorInput,
        /// w, clamped to [0, 1].
        weight: FloatInput,
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
            Texture::Product { input, factor } => {
                input.eval(uv, textures) * factor.eval(uv, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = weight.eval(uv, textures).clamp(0.0, 1.0);
                first.eval(uv, textures).lerp(second.eval(uv, textures), w)
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
    /// As in Mitsuba 3.9.1's `eval_1`, the cells of a checkerboard are swapped against [`Texture::eval`]. The value of a product is the
    /// product of the values, which equals the luminance of the product if one factor is gray.
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
            Texture::Product { input, factor } => {
                input.eval_float(uv, textures) * factor.eval_float(uv, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = weight.eval(uv, textures).clamp(0.0, 1.0);
                first.eval_float(uv, textures) * (1.0 - w) + second.eval_float(uv, textures) * w
            }
        }
    }

    /// Derivatives of [`Texture::eval_float`] by u and by v at `uv`, for bump maps. As in Mitsuba's `eval_1_grad`, from the four texels of the
    /// lookup; 0 for checkerboards. Products and mixtures follow the rules of derivatives.
    pub fn gradient(&self, uv: Vec2, textures: &[Texture]) -> Vec2 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.gradient(uv),
            Texture::Checkerboard { .. } => Vec2::ZERO,
            Texture::Product { input, factor } => {
                input.gradient(uv, textures) * factor.eval_float(uv, textures)
                    + factor.gradient(uv, textures) * input.eval_float(uv, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = weight.eval(uv, textures).clamp(0.0, 1.0);
                let slope = match weight {
                    FloatInput::Constant(_) => Vec2::ZERO,
                    FloatInput::Texture(id) => textures[id.index()].gradient(uv, textures),
                };
                let step = second.eval_float(uv, textures) - first.eval_float(uv, textures);
                first.gradient(uv, textures) * (1.0 - w)
                    + second.gradient(uv, textures) * w
                    + slope * step
            }
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
            Texture::Product { input, factor } => {
                let bound = |constant: Rgb, other: &ColorInput| {
                    constant.max_channel() * other.max_luminance(textures)
                };
                match (input, factor) {
                    (ColorInput::Constant(c), other) | (other, ColorInput::Constant(c)) => {
                        bound(*c, other)
                    }
                    _ => {
                        // A channel is at most the luminance over its weight.
                        let widest: f32 = Rgb::LUMINANCE.iter().map(|w| 1.0 / w).sum();
                        input.max_luminance(textures) * factor.max_luminance(textures) * widest
                    }
                }
            }
            Texture::Mix { first, second, .. } => {
                let [a, b] = [first, second].map(|color| color.max_luminance(textures));
                a.max(b)
            }
        }
    }

    /// Ids of the nested textures.
    pub(crate) fn nested(&self) -> impl Iterator<Item = TextureId> {
        let of_color = |input: &ColorInput| match *input {
            ColorInput::Texture(id) => Some(id),
            ColorInput::Constant(_) => None,
        };
        let ids = match self {
            Texture::Bitmap(_) => [None; 3],
            Texture::Checkerboard { color0, color1, .. } => {
                [of_color(color0), of_color(color1), None]
            }
            Texture::Product { input, factor } => [of_color(input), of_color(factor), None],
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let weight = match *weight {
                    FloatInput::Texture(id) => Some(id),
                    FloatInput::Constant(_) => None,
                };
                [of_color(first), of_color(second), weight]
            }
        };
        ids.into_iter().flatten()
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

    /// [`Texture::gradient`] of a textured input, else 0.
    fn gradient(&self, uv: Vec2, textures: &[Texture]) -> Vec2 {
        match *self {
            ColorInput::Constant(_) => Vec2::ZERO,
            ColorInput::Texture(id) => textures[id.index()].gradient(uv, textures),
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
