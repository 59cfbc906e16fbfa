//! Texture classes. Textures without a counterpart become constants, with one warning each.

mod image_map;
mod solid;

use super::super::description::{Additions, as_color, as_float, product};
use super::super::parameters::{Numbers, Parameters, unresolved};
use super::super::sink::{Problem, Text};
use super::builder::Builder;
use super::colors::ColorUse;
use super::entities::{Entity, Named, TextureEntity};
use super::param_types::{Param, ParamType, Values};
use manylight::color::Rgb;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use manylight::texture::{Bitmap, ColorInput, Filtering, FloatInput, Pattern, Texture, Wrap};
use std::collections::HashMap;

pub(super) const SUPPORTED: &[&str] = &[
    "bilerp",
    "checkerboard",
    "constant",
    "dots",
    "fbm",
    "imagemap",
    "marble",
    "mix",
    "scale",
    "windy",
    "wrinkled",
];

/// Classes that are replaced by the mean of their values, with equal weights.
const SUBSTITUTES: [&str; 2] = ["directionmix", "ptex"];

impl Builder<'_> {
    /// Defines a texture.
    pub(super) fn texture(&mut self, named: &Named<TextureEntity<'_>>) {
        let TextureEntity {
            is_spectrum,
            entity,
        } = &named.value;
        let input = self.texture_input(entity, *is_spectrum);
        entity.params.finish(self.is_v3);
        let name = named.name.value.clone();
        if *is_spectrum {
            self.made.spectrum_textures.insert(name, input);
        } else {
            self.made.float_textures.insert(name, as_float(input));
        }
    }

    fn texture_input(&mut self, entity: &Entity<'_>, is_spectrum: bool) -> ColorInput {
        let params = &entity.params;
        let mut input = |name, default| self.nested_input(entity, is_spectrum, name, default);
        match params.plugin.value.as_str() {
            "constant" => input("value", 1.0),
            "scale" => {
                // The factor of PBRT v4; v3 multiplies `tex1` and `tex2`.
                let (first, second) = if params.has("tex1") || params.has("tex2") {
                    (input("tex1", 1.0), input("tex2", 1.0))
                } else {
                    let first = input("tex", 1.0);
                    (first, as_color(self.float_input(entity, "scale", 1.0)))
                };
                product(&mut self.desc.textures, first, second)
            }
            "mix" => {
                let (first, second) = (input("tex1", 0.0), input("tex2", 1.0));
                let weight = self.float_input(entity, "amount", 0.5);
                ColorInput::Texture(self.desc.add(Texture::Mix {
                    first,
                    second,
                    weight,
                }))
            }
            "checkerboard" => self.checkerboard(entity, is_spectrum),
            "bilerp" => self.bilerp(entity, is_spectrum),
            "imagemap" => self
                .image_map(entity, is_spectrum)
                .unwrap_or(ColorInput::Constant(Rgb::splat(0.5))),
            "dots" => self.dots(entity, is_spectrum),
            _ => match self.noise(entity) {
                Some(noise) => noise,
                None => self.constant_texture(entity, is_spectrum),
            },
        }
    }

    /// The value of a texture's parameter: a number, a color or another texture.
    fn nested_input(
        &mut self,
        entity: &Entity<'_>,
        is_spectrum: bool,
        name: &'static str,
        default: f32,
    ) -> ColorInput {
        if is_spectrum {
            self.color_input(entity, name, ColorUse::Reflectance)
                .unwrap_or(ColorInput::Constant(Rgb::splat(default)))
        } else {
            as_color(self.float_input(entity, name, default))
        }
    }

    fn checkerboard(&mut self, entity: &Entity<'_>, is_spectrum: bool) -> ColorInput {
        let first = self.nested_input(entity, is_spectrum, "tex1", 1.0);
        let second = self.nested_input(entity, is_spectrum, "tex2", 0.0);
        // Evaluation as a number swaps the cells of checkerboards in the plane.
        let dimension = entity.params.integer("dimension", 2, 2);
        if dimension == 3 {
            let cells = Pattern::Cells {
                color0: first,
                color1: second,
            };
            return self.solid(entity, 1.0, cells);
        }
        // PBRT's cells have edges of 1, ours of 1/2.
        let mapping = self.mapping(entity);
        let uv_transform = Mat3::from_diagonal(Vec3::new(0.5, 0.5, 1.0)) * mapping.uv_transform;
        let (color0, color1) = if is_spectrum {
            (first, second)
        } else {
            (second, first)
        };
        let board = self.desc.add(Texture::Checkerboard {
            color0,
            color1,
            uv_transform,
        });
        ColorInput::Texture(self.at_mapped_uv(mapping, board))
    }

    /// Four values at the corners of the unit square, as an image of 2 x 2 texels.
    fn bilerp(&mut self, entity: &Entity<'_>, is_spectrum: bool) -> ColorInput {
        let corners = [("v00", 0.0), ("v10", 0.0), ("v01", 1.0), ("v11", 1.0)];
        let mut data = Vec::new();
        for (name, default) in corners {
            match self.nested_input(entity, is_spectrum, name, default) {
                ColorInput::Constant(color) => data.extend(color.to_array()),
                ColorInput::Texture(_) => data.extend([default; 3]),
            }
        }
        let mapping = self.mapping(entity);
        // The centers of the texels are the corners of the square.
        let centers = Mat3::from_cols(Vec3::X * 0.5, Vec3::Y * 0.5, Vec3::new(0.25, 0.25, 1.0));
        let bitmap = Bitmap {
            image: Image {
                width: 2,
                height: 2,
                channels: 3,
                data,
            },
            filtering: Filtering::Bilinear,
            wrap: [Wrap::Clamp; 2],
            uv_transform: centers * mapping.uv_transform,
        };
        let square = self.desc.add(Texture::Bitmap(bitmap));
        ColorInput::Texture(self.at_mapped_uv(mapping, square))
    }

    /// The substitute of a class that is not supported: the mean of its inputs, with one warning.
    /// Unknown classes are reported.
    fn constant_texture(&mut self, entity: &Entity<'_>, is_spectrum: bool) -> ColorInput {
        let params = &entity.params;
        if !SUBSTITUTES.contains(&params.plugin.value.as_str()) {
            let known = SUPPORTED.iter().chain(&SUBSTITUTES);
            self.unknown_plugin(entity, known.copied());
            return ColorInput::Constant(Rgb::splat(0.5));
        }
        let first = self.nested_input(entity, is_spectrum, "tex1", 0.0);
        let second = self.nested_input(entity, is_spectrum, "tex2", 1.0);
        params.ignore_all();
        let message = format!(
            "{} is not supported; it is replaced by its mean",
            params.describe()
        );
        let problem = Problem::new("scene::unsupported", params.plugin.span, message);
        self.sink
            .warn_once(params.describe(), problem.label("not supported"));
        if let (ColorInput::Constant(a), ColorInput::Constant(b)) = (first, second) {
            return ColorInput::Constant(a.lerp(b, 0.5));
        }
        ColorInput::Texture(self.desc.add(Texture::Mix {
            first,
            second,
            weight: FloatInput::Constant(0.5),
        }))
    }

    /// The texture that `param` names. `None` if there is none, which is reported.
    fn referenced<T: Copy>(
        &self,
        param: &Param,
        textures: &HashMap<String, T>,
        kind: &str,
    ) -> Option<T> {
        let Values::Strings(names) = &param.values else {
            return None;
        };
        let [name] = names.as_slice() else {
            let message = format!("`{}` must be the name of one texture", param.name.value);
            self.sink.error_at("scene::bad_value", param.span, message);
            return None;
        };
        let found = textures.get(&name.value);
        if found.is_none() {
            self.unknown_texture(name, textures.keys().map(String::as_str), kind);
        }
        found.copied()
    }

    fn unknown_texture<'n>(&self, name: &Text, known: impl Iterator<Item = &'n str>, kind: &str) {
        let other_kind = match kind {
            "float" => self.made.spectrum_textures.contains_key(&name.value),
            _ => self.made.float_textures.contains_key(&name.value),
        };
        let message = format!("no {kind} texture has the name `{}`", name.value);
        let problem = unresolved(name, message, known);
        self.sink.error(if other_kind {
            problem.help("the texture with this name has the other type")
        } else {
            problem
        });
    }

    /// The parameter `name` as a color or texture, if it is given.
    pub(super) fn color_input(
        &mut self,
        entity: &Entity<'_>,
        name: &'static str,
        color_use: ColorUse,
    ) -> Option<ColorInput> {
        let param = entity.params.get(name)?;
        if param.ty == ParamType::Texture {
            return self.referenced(param, &self.made.spectrum_textures, "spectrum");
        }
        entity.color(name, color_use).map(ColorInput::Constant)
    }

    /// The parameter `name` as a number or texture, if it is given.
    pub(super) fn maybe_float_input(
        &self,
        entity: &Entity<'_>,
        name: &'static str,
    ) -> Option<FloatInput> {
        let param = entity.params.get(name)?;
        if param.ty == ParamType::Texture {
            return self.referenced(param, &self.made.float_textures, "float");
        }
        let value = entity.params.maybe_float(name);
        value.map(FloatInput::Constant)
    }

    pub(super) fn float_input(
        &self,
        entity: &Entity<'_>,
        name: &'static str,
        default: f32,
    ) -> FloatInput {
        self.maybe_float_input(entity, name)
            .unwrap_or(FloatInput::Constant(default))
    }
}
