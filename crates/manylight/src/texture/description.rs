//! Textures as a scene describes them.

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
    /// 1 where a number is at least a threshold, else 0.
    Step {
        /// The texture that gives the number.
        base: TextureId,
        /// The threshold.
        threshold: f32,
    },
    /// Another texture at transformed coordinates: transforms of one image share its pixels.
    Transformed {
        /// Transform of (u, v, 1).
        uv_transform: Mat3,
        /// The texture.
        inner: TextureId,
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
            | Texture::Step { .. }
            | Texture::Transformed { .. }
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
            | Texture::Power { base: inner, .. }
            | Texture::Step { base: inner, .. }
            | Texture::Transformed { inner, .. } => [Some(*inner), None, None],
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
