//! Textures, and material inputs that are constant or textured.

mod bitmap;
mod evaluate;
mod inputs;
#[cfg(test)]
mod lanes_tests;
mod noise;
mod point;
mod solid;
#[cfg(test)]
mod tests;

pub use bitmap::{Bitmap, Filtering, Wrap};
pub use inputs::{ColorInput, FloatInput};
pub use point::{TexturePoint, VertexValues};
pub use solid::{Pattern, Projection, ProjectionKind, Solid};

use crate::color::Rgb;
use crate::geometry::SurfacePoints;
use crate::ids::TextureId;
use crate::lanes::{Pair, Vector, Width};
use crate::math::{Mat3, Vec2, Vec3};
use evaluate::Lookup;
use point::TexturePoints;

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
    /// Filtered color at a point. `textures` are all textures of the scene, for nested ones.
    pub fn eval(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> Rgb {
        let at = at.into();
        self.lookup(at.in_lane(&at.reference()), textures)
            .color()
            .into()
    }

    /// Filtered luminance at a point, for float parameters; of a product, the product of the luminances.
    ///
    /// As in Mitsuba 3.9.1's `eval_1`, the cells of a checkerboard are swapped against [`Texture::eval`].
    pub fn eval_float(&self, at: impl Into<TexturePoint>, textures: &[Texture]) -> f32 {
        let at = at.into();
        let value = self.lookup(at.in_lane(&at.reference()), textures).value();
        value.get()
    }

    /// Derivatives of [`Texture::eval_float`] by u and by v, for bump maps. `dp` are those of the position. As in Mitsuba's `eval_1_grad`, from
    /// the four texels of the lookup; 0 for checkerboards, dots and values of vertices. Products and mixtures follow the rules of derivatives.
    pub fn gradient(
        &self,
        at: impl Into<TexturePoint>,
        dp: [Vec3; 2],
        textures: &[Texture],
    ) -> Vec2 {
        let at = at.into();
        let reference = at.reference();
        let lookup = self.lookup(at.in_lane(&reference), textures);
        let gradient = lookup.gradient(dp.map(Vector::from));
        Vec2::new(gradient.x.get(), gradient.y.get())
    }

    /// [`Texture::gradient`] in each lane.
    #[inline(always)]
    pub(crate) fn gradient_each<S: Width>(
        &self,
        x: &SurfacePoints<S>,
        textures: &[Texture],
    ) -> Pair<S> {
        self.lookup(x.into(), textures).gradient([x.dp_du, x.dp_dv])
    }

    #[inline(always)]
    fn lookup<'a, S: Width>(
        &'a self,
        at: TexturePoints<'a, S>,
        textures: &'a [Texture],
    ) -> Lookup<'a, S> {
        Lookup {
            texture: self,
            at,
            textures,
        }
    }

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
                let bounds = bounds.map(|color| color.max_luminance(textures));
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
                let bounds = bounds.map(|color| color.max_channel(textures));
                bounds.reduce(f32::max).unwrap_or(0.0)
            }
            Texture::Product { first, second } => {
                first.max_channel(textures) * second.max_channel(textures)
            }
            Texture::VertexColors(colors) => {
                let channels = colors.values.iter().map(|color| color.max_channel());
                channels.fold(0.0, f32::max)
            }
            Texture::Solid(solid) => solid.max_channel(|color| color.max_channel(textures)),
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
            Texture::OtherUv { inner, .. }
            | Texture::Projected { inner, .. }
            | Texture::Power { base: inner, .. } => [Some(*inner), None, None],
            Texture::Dots {
                inside, outside, ..
            } => [of_color(inside), of_color(outside), None],
            Texture::Solid(solid) => {
                let [a, b] = solid.inputs().map(|input| of_color(&input?));
                [a, b, None]
            }
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
