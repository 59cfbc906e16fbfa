//! Textures as a scene describes them, with bounds of their values.

use super::bitmap::Bitmap;
use super::inputs::{ColorInput, FloatInput};
use super::point::VertexValues;
use super::solid::{Projection, Solid};
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
        /// Color of the cells in which the fractions of u and v are both up to 1/2 or both above.
        /// Nested textures get the untransformed uv.
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
    /// Another texture at other texture coordinates than those of the mesh. Only materials of this
    /// mesh may use it.
    OtherUv {
        /// The texture coordinates.
        uvs: VertexValues<Vec2>,
        /// The texture.
        inner: TextureId,
    },
    /// Discs in some of the unit squares.
    Dots {
        /// Color of the discs. Nested textures get the untransformed uv.
        inside: ColorInput,
        /// Color around them.
        outside: ColorInput,
        /// Transform of (u, v, 1).
        uv_transform: Mat3,
    },
    /// A power of another texture, of which negative values count as 0.
    Power {
        /// The base.
        base: TextureId,
        /// The exponent.
        exponent: f32,
    },
    /// A pattern in space.
    Solid(Solid),
    /// Another texture at texture coordinates by position.
    Projected {
        /// The texture coordinates.
        projection: Projection,
        /// The texture.
        inner: TextureId,
    },
}

impl Texture {
    /// The colors between which the texture chooses or interpolates.
    fn alternatives(&self) -> Option<[&ColorInput; 2]> {
        match self {
            Texture::Checkerboard { color0, color1, .. } => Some([color0, color1]),
            Texture::Dots {
                inside, outside, ..
            } => Some([inside, outside]),
            Texture::Mix { first, second, .. } => Some([first, second]),
            _ => None,
        }
    }

    /// Upper bound of the luminance over all uv.
    pub fn max_luminance(&self, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.max_luminance(),
            Texture::Checkerboard { .. } | Texture::Dots { .. } | Texture::Mix { .. } => {
                let bounds = self.alternatives().into_iter().flatten();
                let bounds = bounds.map(|color| max_luminance(color, textures));
                bounds.reduce(f32::max).unwrap_or(0.0)
            }
            Texture::VertexColors(colors) => {
                let luminances = colors.values.iter().map(|color| color.luminance());
                luminances.fold(0.0, f32::max)
            }
            Texture::OtherUv { inner, .. } | Texture::Projected { inner, .. } => {
                textures[inner.index()].max_luminance(textures)
            }
            Texture::Product { .. } | Texture::Solid(_) | Texture::Power { .. } => {
                self.max_channel(textures)
            }
        }
    }

    /// Upper bound of every channel over all uv.
    fn max_channel(&self, textures: &[Texture]) -> f32 {
        match self {
            Texture::Bitmap(bitmap) => bitmap.image.data.iter().copied().fold(0.0, f32::max),
            Texture::Checkerboard { .. } | Texture::Dots { .. } | Texture::Mix { .. } => {
                let bounds = self.alternatives().into_iter().flatten();
                let bounds = bounds.map(|color| max_channel(color, textures));
                bounds.reduce(f32::max).unwrap_or(0.0)
            }
            Texture::Product { first, second } => {
                max_channel(first, textures) * max_channel(second, textures)
            }
            Texture::VertexColors(colors) => {
                let channels = colors.values.iter().map(|color| color.max_channel());
                channels.fold(0.0, f32::max)
            }
            Texture::Solid(solid) => solid.max_channel(|color| max_channel(color, textures)),
            Texture::Power { base, exponent } => textures[base.index()]
                .max_channel(textures)
                .max(0.0)
                .powf(*exponent),
            Texture::OtherUv { inner, .. } | Texture::Projected { inner, .. } => {
                textures[inner.index()].max_channel(textures)
            }
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
            | Texture::Mix { .. }
            | Texture::Dots { .. }
            | Texture::Power { .. }
            | Texture::Solid(_)
            | Texture::Projected { .. } => true,
        }
    }

    /// Ids of the nested textures.
    pub(crate) fn nested(&self) -> impl Iterator<Item = TextureId> {
        let ids = match self {
            Texture::Bitmap(_) | Texture::VertexColors(_) => [None; 3],
            Texture::Checkerboard { color0, color1, .. } => {
                [color0.texture(), color1.texture(), None]
            }
            Texture::Product { first, second } => [first.texture(), second.texture(), None],
            Texture::OtherUv { inner, .. }
            | Texture::Projected { inner, .. }
            | Texture::Power { base: inner, .. } => [Some(*inner), None, None],
            Texture::Dots {
                inside, outside, ..
            } => [inside.texture(), outside.texture(), None],
            Texture::Solid(solid) => {
                let [a, b] = solid.inputs().map(|input| input?.texture());
                [a, b, None]
            }
            Texture::Mix {
                first,
                second,
                weight,
            } => [first.texture(), second.texture(), weight.texture()],
        };
        ids.into_iter().flatten()
    }
}

/// Upper bound of every channel of an input over all uv.
fn max_channel(input: &ColorInput, textures: &[Texture]) -> f32 {
    match *input {
        ColorInput::Constant(c) => c.max_channel(),
        ColorInput::Texture(id) => textures[id.index()].max_channel(textures),
    }
}

/// Upper bound of the luminance of an input over all uv.
fn max_luminance(input: &ColorInput, textures: &[Texture]) -> f32 {
    match *input {
        ColorInput::Constant(c) => c.luminance(),
        ColorInput::Texture(id) => textures[id.index()].max_luminance(textures),
    }
}
