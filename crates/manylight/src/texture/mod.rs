//! Textures, and material inputs that are constant or textured.

mod bitmap;
mod point;
#[cfg(test)]
mod tests;

pub use bitmap::{Bitmap, Filtering, Wrap};
pub use point::{TexturePoint, VertexValues};

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
        /// The one factor.
        first: ColorInput,
        /// The other factor.
        second: ColorInput,
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
    /// Colors of the vertices of one mesh. Only materials of this mesh may use it.
    VertexColors(VertexValues<Rgb>),
    /// Another texture at other texture coordinates than those of the mesh. Only materials of this mesh may use it.
    OtherUv {
        /// The texture coordinates.
        uvs: VertexValues<Vec2>,
        /// The texture.
        inner: TextureId,
    },
}

impl Texture {
    /// Filtered color at a point. `textures` are all textures of the scene, for nested ones.
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        let at = at.into();
        match self {
            Texture::Bitmap(bitmap) => bitmap.eval(at.uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let color = if is_main_cell(*uv_transform, at.uv) {
                    color0
                } else {
                    color1
                };
                color.eval(at, textures)
            }
            Texture::Product { first, second } => {
                let (a, b) = (first.eval(at, textures), second.eval(at, textures));
                a.zip(b, |a, b| a * b)
            }
            Texture::VertexColors(colors) => colors.at(at),
            Texture::OtherUv { uvs, inner } => {
                let uv = uvs.at(at);
                textures[inner.index()].eval(TexturePoint { uv, ..at }, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = mixing_weight(weight, at, textures);
                first.eval(at, textures).lerp(second.eval(at, textures), w)
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

    /// Filtered luminance at a point, for float parameters; of a product, the product of the luminances.
    ///
    /// As in Mitsuba 3.9.1's `eval_1`, the cells of a checkerboard are swapped against [`Texture::eval`].
    pub fn eval_float(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        let at = at.into();
        match self {
            Texture::Bitmap(bitmap) => bitmap.eval_float(at.uv),
            Texture::Checkerboard {
                color0,
                color1,
                uv_transform,
            } => {
                let color = if is_main_cell(*uv_transform, at.uv) {
                    color1
                } else {
                    color0
                };
                color.eval_float(at, textures)
            }
            Texture::Product { first, second } => {
                first.eval_float(at, textures) * second.eval_float(at, textures)
            }
            Texture::VertexColors(colors) => colors.at(at).luminance(),
            Texture::OtherUv { uvs, inner } => {
                let uv = uvs.at(at);
                textures[inner.index()].eval_float(TexturePoint { uv, ..at }, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let w = mixing_weight(weight, at, textures);
                first.eval_float(at, textures) * (1.0 - w) + second.eval_float(at, textures) * w
            }
        }
    }

    /// Derivatives of [`Texture::eval_float`] by u and by v at `uv`, for bump maps. As in Mitsuba's `eval_1_grad`, from the four texels of the
    /// lookup; 0 for checkerboards and values of vertices. Products and mixtures follow the rules of derivatives.
    pub fn gradient(&self, uv: Vec2, textures: &[Texture]) -> Vec2 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.gradient(uv),
            Texture::Checkerboard { .. } | Texture::VertexColors(_) | Texture::OtherUv { .. } => {
                Vec2::ZERO
            }
            Texture::Product { first, second } => {
                let at = TexturePoint::from(uv);
                first.gradient(uv, textures) * second.eval_float(at, textures)
                    + second.gradient(uv, textures) * first.eval_float(at, textures)
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => {
                let at = TexturePoint::from(uv);
                let w = mixing_weight(weight, at, textures);
                let slope = match weight {
                    FloatInput::Constant(_) => Vec2::ZERO,
                    FloatInput::Texture(id) => textures[id.index()].gradient(uv, textures),
                };
                let step = second.eval_float(at, textures) - first.eval_float(at, textures);
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
            Texture::Product { first, second } => {
                let [a, b] = [first, second].map(|color| color.max_channel(textures));
                a * b
            }
            Texture::Mix { first, second, .. } => {
                let [a, b] = [first, second].map(|color| color.max_luminance(textures));
                a.max(b)
            }
            Texture::VertexColors(colors) => {
                let luminances = colors.values.iter().map(|color| color.luminance());
                luminances.fold(0.0, f32::max)
            }
            Texture::OtherUv { inner, .. } => textures[inner.index()].max_luminance(textures),
        }
    }

    /// Upper bound of every channel over all uv.
    fn max_channel(&self, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.image.data.iter().copied().fold(0.0, f32::max),
            Texture::Checkerboard { color0, color1, .. } => {
                let [a, b] = [color0, color1].map(|color| color.max_channel(textures));
                a.max(b)
            }
            Texture::Product { first, second } => {
                first.max_channel(textures) * second.max_channel(textures)
            }
            Texture::Mix { first, second, .. } => {
                let [a, b] = [first, second].map(|color| color.max_channel(textures));
                a.max(b)
            }
            Texture::VertexColors(colors) => {
                let channels = colors.values.iter().map(|color| color.max_channel());
                channels.fold(0.0, f32::max)
            }
            Texture::OtherUv { inner, .. } => textures[inner.index()].max_channel(textures),
        }
    }

    /// Whether all indices of vertex values are valid.
    pub(crate) fn has_valid_indices(&self) -> bool {
        match self {
            Texture::VertexColors(colors) => colors.is_valid(),
            Texture::OtherUv { uvs, .. } => uvs.is_valid(),
            Texture::Bitmap(_)
            | Texture::Checkerboard { .. }
            | Texture::Product { .. }
            | Texture::Mix { .. } => true,
        }
    }

    /// Ids of the nested textures.
    pub(crate) fn nested(&self) -> impl Iterator<Item = TextureId> {
        let of_color = |input: &ColorInput| match *input {
            ColorInput::Texture(id) => Some(id),
            ColorInput::Constant(_) => None,
        };
        let ids = match self {
            Texture::Bitmap(_) | Texture::VertexColors(_) => [None; 3],
            Texture::Checkerboard { color0, color1, .. } => {
                [of_color(color0), of_color(color1), None]
            }
            Texture::Product { first, second } => [of_color(first), of_color(second), None],
            Texture::OtherUv { inner, .. } => [Some(*inner), None, None],
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

/// Weight of the second input of a mixture, in [0, 1].
fn mixing_weight(weight: &FloatInput, at: TexturePoint, textures: &[Texture]) -> f32 {
    weight.eval(at, textures).clamp(0.0, 1.0)
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
    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        match *self {
            ColorInput::Constant(c) => c,
            ColorInput::Texture(id) => textures[id.index()].eval(at, textures),
        }
    }

    /// [`Texture::prefetch`] of a textured input.
    #[inline]
    pub fn prefetch(&self, uv: Vec2, textures: &[Texture]) {
        if let ColorInput::Texture(id) = self {
            textures[id.index()].prefetch(uv);
        }
    }

    /// Luminance at a point, for float parameters.
    fn eval_float(&self, at: TexturePoint, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.luminance(),
            ColorInput::Texture(id) => textures[id.index()].eval_float(at, textures),
        }
    }

    fn max_channel(&self, textures: &[Texture]) -> f32 {
        match *self {
            ColorInput::Constant(c) => c.max_channel(),
            ColorInput::Texture(id) => textures[id.index()].max_channel(textures),
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
    /// Value at a point.
    #[inline]
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        match *self {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => textures[id.index()].eval_float(at, textures),
        }
    }
}
