//! Texture classes. Textures without a counterpart become constants, with one warning each.

mod image_map;
mod solid;

use super::super::description::{Additions, as_color, as_float, product};
use super::super::parameters::{Numbers, Parameters, unresolved};
use super::super::sink::Problem;
use super::bindings::{NameSpace, TextureType};
use super::builder::{Builder, Made};
use super::colors::ColorUse;
use super::entities::{Entity, Named, TextureEntity};
use super::param_types::{Param, ParamType, Values};
use manylight::color::Rgb;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use manylight::texture::{Bitmap, ColorInput, Filtering, FloatInput, Pattern, Texture, Wrap};

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
    "uv",
    "windy",
    "wrinkled",
];

/// Classes that are replaced by the mean of their values, with equal weights.
const SUBSTITUTES: [&str; 2] = ["directionmix", "ptex"];

impl Builder<'_> {
    /// Defines a texture.
    pub(super) fn texture(&mut self, named: &Named<TextureEntity<'_>>) {
        let TextureEntity { ty, entity } = &named.value;
        let input = self.texture_input(entity, *ty);
        entity.params.finish(self.is_v3);
        let index = self.made.textures.len();
        self.made.textures.push(input);
        let names = match ty {
            TextureType::Spectrum => &mut self.made.spectrum_textures,
            TextureType::Float => &mut self.made.float_textures,
        };
        let former = names.insert(named.name.value.clone(), index);
        if former.is_some() && !self.is_v3 {
            self.defined_twice("texture", &named.name);
        }
    }

    fn texture_input(&mut self, entity: &Entity<'_>, ty: TextureType) -> ColorInput {
        let params = &entity.params;
        let mut input = |name, default| self.nested_input(entity, ty, name, default);
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
            "checkerboard" => self.checkerboard(entity, ty),
            "bilerp" => self.bilerp(entity, ty),
            "imagemap" => self
                .image_map(entity, ty)
                .unwrap_or(ColorInput::Constant(Rgb::splat(0.5))),
            "dots" => self.dots(entity, ty),
            "uv" if ty == TextureType::Spectrum => self.texture_coordinates(entity),
            _ => match self.noise(entity) {
                Some(noise) => noise,
                None => self.constant_texture(entity, ty),
            },
        }
    }

    /// The value of a texture's parameter: a number, a color or another texture.
    fn nested_input(
        &mut self,
        entity: &Entity<'_>,
        ty: TextureType,
        name: &'static str,
        default: f32,
    ) -> ColorInput {
        match ty {
            TextureType::Spectrum => self
                .color_input(entity, name, ColorUse::Reflectance)
                .unwrap_or(ColorInput::Constant(Rgb::splat(default))),
            TextureType::Float => as_color(self.float_input(entity, name, default)),
        }
    }

    fn checkerboard(&mut self, entity: &Entity<'_>, ty: TextureType) -> ColorInput {
        let first = self.nested_input(entity, ty, "tex1", 1.0);
        let second = self.nested_input(entity, ty, "tex2", 0.0);
        // Evaluation as a number swaps the cells of checkerboards in the plane.
        let dimension = entity.params.integer("dimension", 2, 2);
        if dimension > 3 {
            entity.params.refuse_named("dimension", "2 or 3");
        }
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
        let (color0, color1) = match ty {
            TextureType::Spectrum => (first, second),
            TextureType::Float => (second, first),
        };
        let board = self.desc.add(Texture::Checkerboard {
            color0,
            color1,
            uv_transform,
        });
        ColorInput::Texture(self.at_mapped_uv(mapping, board))
    }

    /// Four values at the corners of the unit square, as an image of 2 x 2 texels.
    fn bilerp(&mut self, entity: &Entity<'_>, ty: TextureType) -> ColorInput {
        let corners = [("v00", 0.0), ("v10", 0.0), ("v01", 1.0), ("v11", 1.0)];
        let mut data = Vec::new();
        for (name, default) in corners {
            match self.nested_input(entity, ty, name, default) {
                ColorInput::Constant(color) => data.extend(color.to_array()),
                ColorInput::Texture(_) => {
                    let params = &entity.params;
                    params.refuse_named(name, "constant, found a texture that varies");
                    data.extend([default; 3]);
                }
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

    /// PBRT v3's `uv`: the fractions of u and v as red and green.
    fn texture_coordinates(&mut self, entity: &Entity<'_>) -> ColorInput {
        /// Steps of a fraction.
        const STEPS: usize = 4096;
        let mapping = self.mapping(entity);
        let [red, green] = [0, 1].map(|channel| {
            // The mean of two ramps is the color.
            let value = |i: usize| 2.0 * (i as f32 + 0.5) / STEPS as f32;
            let texel = |i: usize| (0..3).map(move |c| if c == channel { value(i) } else { 0.0 });
            let [width, height] = if channel == 0 { [STEPS, 1] } else { [1, STEPS] };
            let ramp = self.desc.add(Texture::Bitmap(Bitmap {
                image: Image {
                    width,
                    height,
                    channels: 3,
                    data: (0..STEPS).flat_map(texel).collect(),
                },
                filtering: Filtering::Nearest,
                wrap: [Wrap::Repeat; 2],
                uv_transform: mapping.uv_transform,
            }));
            ColorInput::Texture(ramp)
        });
        let both = self.desc.add(Texture::Mix {
            first: red,
            second: green,
            weight: FloatInput::Constant(0.5),
        });
        ColorInput::Texture(self.at_mapped_uv(mapping, both))
    }

    /// The substitute of a class that is not supported: the mean of its inputs, with one warning.
    /// Unknown classes are reported.
    fn constant_texture(&mut self, entity: &Entity<'_>, ty: TextureType) -> ColorInput {
        let params = &entity.params;
        if !SUBSTITUTES.contains(&params.plugin.value.as_str()) {
            let known = SUPPORTED.iter().chain(&SUBSTITUTES);
            self.unknown_plugin(entity, known.copied());
            return ColorInput::Constant(Rgb::splat(0.5));
        }
        let first = self.nested_input(entity, ty, "tex1", 0.0);
        let second = self.nested_input(entity, ty, "tex2", 1.0);
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
    fn referenced(
        &self,
        entity: &Entity<'_>,
        param: &Param,
        ty: TextureType,
    ) -> Option<ColorInput> {
        let Values::Strings(names) = &param.values else {
            return None;
        };
        let [name] = names.as_slice() else {
            let message = format!("`{}` must be the name of one texture", param.name.value);
            self.sink.error_at("scene::bad_value", param.span, message);
            return None;
        };
        let Made {
            float_textures,
            spectrum_textures,
            ..
        } = &self.made;
        let (known, others) = match ty {
            TextureType::Spectrum => (spectrum_textures, float_textures),
            TextureType::Float => (float_textures, spectrum_textures),
        };
        let space = NameSpace::Texture(ty);
        let found = self.definition(space, name, entity.place, known);
        // A texture that refers to itself is not there yet.
        let texture = found.and_then(|index| self.made.textures.get(index));
        if texture.is_none() {
            let kind = match ty {
                TextureType::Spectrum => "spectrum",
                TextureType::Float => "float",
            };
            let message = format!("no {kind} texture has the name `{}`", name.value);
            let problem = unresolved(name, message, known.keys().map(String::as_str));
            self.sink.error(if others.contains_key(&name.value) {
                problem.help("the texture with this name has the other type")
            } else {
                problem
            });
        }
        if let Some(ColorInput::Texture(_)) = texture {
            self.note_texture();
        }
        texture.copied()
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
            return self.referenced(entity, param, TextureType::Spectrum);
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
            let texture = self.referenced(entity, param, TextureType::Float);
            return texture.map(as_float);
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
