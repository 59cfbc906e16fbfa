//! Bounds of the values of textures.

use super::{ColorInput, Texture};
use crate::ids::TextureId;
use std::sync::OnceLock;

/// Upper bounds of textures over all texture coordinates. Each texture is scanned once, whatever
/// number of emitters and triangles asks for it.
pub(crate) struct TextureBounds<'t> {
    textures: &'t [Texture],
    /// By texture.
    luminances: Vec<OnceLock<f32>>,
    channels: Vec<OnceLock<f32>>,
}

impl<'t> TextureBounds<'t> {
    /// Without a scan.
    pub(crate) fn new(textures: &'t [Texture]) -> Self {
        let slots = vec![OnceLock::new(); textures.len()];
        TextureBounds {
            textures,
            luminances: slots.clone(),
            channels: slots,
        }
    }

    /// All textures.
    pub(crate) fn textures(&self) -> &'t [Texture] {
        self.textures
    }

    /// Upper bound of the luminance of a texture.
    pub(crate) fn luminance(&self, id: TextureId) -> f32 {
        let slot = &self.luminances[id.index()];
        *slot.get_or_init(|| self.luminance_of(&self.textures[id.index()]))
    }

    /// Upper bound of every channel of a texture.
    fn channel(&self, id: TextureId) -> f32 {
        let slot = &self.channels[id.index()];
        *slot.get_or_init(|| self.channel_of(&self.textures[id.index()]))
    }

    pub(super) fn luminance_of(&self, texture: &Texture) -> f32 {
        let of_input = |input: &ColorInput| match *input {
            ColorInput::Constant(color) => color.luminance(),
            ColorInput::Texture(id) => self.luminance(id),
        };
        match texture {
            Texture::Bitmap(bitmap) => bitmap.max_luminance(),
            Texture::VertexColors(colors) => {
                let luminances = colors.values.iter().map(|color| color.luminance());
                luminances.fold(0.0, f32::max)
            }
            Texture::OtherUv { inner, .. }
            | Texture::Transformed { inner, .. }
            | Texture::Projected { inner, .. } => self.luminance(*inner),
            _ => match alternatives(texture) {
                Some([a, b]) => of_input(a).max(of_input(b)),
                None => self.channel_of(texture),
            },
        }
    }

    fn channel_of(&self, texture: &Texture) -> f32 {
        let of_input = |input: &ColorInput| match *input {
            ColorInput::Constant(color) => color.max_channel(),
            ColorInput::Texture(id) => self.channel(id),
        };
        match texture {
            Texture::Bitmap(bitmap) => bitmap.image.data.iter().copied().fold(0.0, f32::max),
            Texture::Checkerboard { .. } | Texture::Dots { .. } | Texture::Mix { .. } => {
                let bounds = alternatives(texture).into_iter().flatten().map(of_input);
                bounds.reduce(f32::max).unwrap_or(0.0)
            }
            Texture::Product { first, second } => of_input(first) * of_input(second),
            Texture::VertexColors(colors) => {
                let channels = colors.values.iter().map(|color| color.max_channel());
                channels.fold(0.0, f32::max)
            }
            Texture::Solid(solid) => solid.max_channel(of_input),
            Texture::Power { base, exponent } => self.channel(*base).max(0.0).powf(*exponent),
            Texture::Step { .. } => 1.0,
            Texture::OtherUv { inner, .. }
            | Texture::Transformed { inner, .. }
            | Texture::Projected { inner, .. } => self.channel(*inner),
        }
    }
}

/// The colors between which a texture chooses or interpolates.
fn alternatives(texture: &Texture) -> Option<[&ColorInput; 2]> {
    match texture {
        Texture::Checkerboard { color0, color1, .. } => Some([color0, color1]),
        Texture::Dots {
            inside, outside, ..
        } => Some([inside, outside]),
        Texture::Mix { first, second, .. } => Some([first, second]),
        _ => None,
    }
}
