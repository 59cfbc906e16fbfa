//! Colors, numbers and opacities of a material, with their textures.

use super::super::description::{WHITE, as_color};
use super::super::parameters::Numbers;
use super::document::Document;
use super::images::Content;
use super::json::Json;
use super::textures::{Textures, VertexInputs};
use manylight::bsdf::{Bitangent, Material};
use manylight::color::Rgb;
use manylight::ids::TextureId;
use manylight::texture::{ColorInput, FloatInput};

/// Base color and its parameters before extensions change them.
pub(super) struct Base {
    pub(super) color: ColorInput,
    pub(super) opacity: ColorInput,
    pub(super) metallic: FloatInput,
    pub(super) roughness: FloatInput,
    /// Reflectance of the dielectric at normal incidence, if the workflow gives it.
    pub(super) f0: Option<f32>,
}

impl Default for Base {
    /// White metal of roughness 1: the defaults of the specification.
    fn default() -> Self {
        Base {
            color: WHITE,
            opacity: WHITE,
            metallic: FloatInput::Constant(1.0),
            roughness: FloatInput::Constant(1.0),
            f0: None,
        }
    }
}

/// Reads one material.
pub(super) struct MaterialReader<'a, 'm> {
    pub(super) document: &'m Document<'a>,
    pub(super) json: &'m Json<'a>,
    pub(super) vertices: &'m VertexInputs<'m>,
    pub(super) list: &'m mut Vec<Material>,
    pub(super) textures: &'m mut Textures,
    /// The bitangent of normal textures.
    pub(super) bitangent: Bitangent,
}

impl<'a> MaterialReader<'a, '_> {
    /// The texture `name` of `json`.
    pub(super) fn texture(
        &mut self,
        json: &Json<'a>,
        name: &str,
        content: Content,
    ) -> Option<TextureId> {
        let info = json.member(name)?;
        self.textures
            .bitmap(self.document, &info, content, self.vertices)
    }

    /// A color factor times a texture of colors.
    pub(super) fn color(&mut self, json: &Json<'a>, texture: &str, factor: Rgb) -> ColorInput {
        let factor = ColorInput::Constant(factor);
        match self.texture(json, texture, Content::Color) {
            Some(id) => self.textures.product(factor, ColorInput::Texture(id)),
            None => factor,
        }
    }

    /// Opacity by the alpha mode; white for opaque materials.
    pub(super) fn opacity(
        &mut self,
        json: &Json<'a>,
        texture: &str,
        factor: f32,
        mode: &str,
    ) -> ColorInput {
        match mode {
            "OPAQUE" => WHITE,
            "MASK" => {
                let cutoff = self.json.float("alphaCutoff", 0.5);
                let texture = self.texture(json, texture, Content::Opacity);
                let mut opacity = as_color(self.textures.scaled(factor, texture));
                if let Some(of_vertices) = self.textures.vertex_opacity(self.vertices) {
                    opacity = self.textures.product(opacity, of_vertices);
                }
                self.textures.step(opacity, cutoff)
            }
            "BLEND" => {
                let texture = self.texture(json, texture, Content::Opacity);
                as_color(self.textures.scaled(factor, texture))
            }
            other => {
                let message = format!("found `{other}`, expected `OPAQUE`, `MASK` or `BLEND`");
                self.json.error_at("alphaMode", message);
                WHITE
            }
        }
    }
}

/// A color factor of a reflectance, clamped to [0, 1].
pub(super) fn reflectance(factor: [f32; 3]) -> Rgb {
    Rgb::from(factor).map(|v| v.clamp(0.0, 1.0))
}
