//! Sums and colored mixtures of materials, of which PBRT v3 makes its surfaces.

use super::super::super::description::{Additions, WHITE, as_float, product};
use super::super::super::parameters::Parameters;
use super::super::super::sink::Problem;
use super::super::builder::Builder;
use super::super::entities::Entity;
use manylight::bsdf::Material;
use manylight::bsdf::material::{ColorShift, Roughness};
use manylight::color::Rgb;
use manylight::ids::{MaterialId, TextureId};
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, FloatInput, Texture};
use std::collections::HashSet;

/// Most nodes of a material that is copied for a colored mixture: mixtures of mixtures double at
/// every level.
const MAX_PARTS: usize = 64;

/// A part of a sum.
pub(super) struct Part {
    pub(super) material: Material,
    /// Whether it reflects on both sides alike.
    pub(super) is_two_sided: bool,
}

impl Part {
    /// Of a surface that reflects.
    pub(super) fn reflecting(material: Material) -> Self {
        Part {
            material,
            is_two_sided: true,
        }
    }

    /// Of a surface that transmits.
    pub(super) fn transmitting(material: Material) -> Self {
        Part {
            material,
            is_two_sided: false,
        }
    }
}

impl Builder<'_> {
    /// The sum of scattering functions: a blend of n parts of equal weights, each with n times its
    /// colors.
    pub(super) fn sum(&mut self, parts: Vec<Part>) -> MaterialId {
        let factor = ColorInput::Constant(Rgb::splat(parts.len() as f32));
        let mut sum = None;
        for (i, mut part) in parts.into_iter().enumerate() {
            self.multiply(&mut part.material, factor);
            let part = match part.is_two_sided {
                true => self.both_sides(part.material),
                false => self.desc.add(part.material),
            };
            sum = Some(match sum {
                Some(sum) => self.blend(FloatInput::Constant(1.0 / (i + 1) as f32), sum, part),
                None => part,
            });
        }
        sum.unwrap_or_else(|| self.diffuse(ColorInput::Constant(Rgb::BLACK)))
    }

    /// Multiplies the scattering function of a material without wrappers by a color. `false` if
    /// the material has no such factor.
    fn multiply(&mut self, material: &mut Material, color: ColorInput) -> bool {
        let textures = &mut self.desc.textures;
        let mut times = |input: &mut ColorInput| *input = product(textures, *input, color);
        match material {
            Material::Diffuse { reflectance } | Material::RoughDiffuse { reflectance, .. } => {
                times(reflectance)
            }
            Material::DiffuseTransmitter { transmittance, .. } => times(transmittance),
            Material::Conductor {
                specular_reflectance,
                ..
            } => times(specular_reflectance),
            Material::Dielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            }
            | Material::ThinDielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            } => {
                times(specular_reflectance);
                times(specular_transmittance);
            }
            Material::Plastic {
                diffuse_reflectance,
                specular_reflectance,
                color_shift: ColorShift::Linear,
                ..
            } => {
                times(diffuse_reflectance);
                times(specular_reflectance);
            }
            _ => return false,
        }
        true
    }

    /// A material times a color. `None` if a part of it has no such factor, or if there are more
    /// parts than `left`.
    fn times_color(
        &mut self,
        id: MaterialId,
        color: ColorInput,
        left: &mut usize,
    ) -> Option<MaterialId> {
        *left = left.checked_sub(1)?;
        let mut material = self.desc.materials[id.index()].clone();
        match &mut material {
            Material::Null => material = clear_film(color),
            Material::Mask { opacity, inner } => {
                let inner = self.times_color(*inner, color, left)?;
                let opacity = *opacity;
                let film = self.desc.add(clear_film(color));
                return Some(self.blend(opacity, film, inner));
            }
            Material::TwoSided { front, back } => {
                let is_one = front == back;
                *front = self.times_color(*front, color, left)?;
                *back = match is_one {
                    true => *front,
                    false => self.times_color(*back, color, left)?,
                };
            }
            Material::Blend { first, second, .. } | Material::Sum { first, second } => {
                *first = self.times_color(*first, color, left)?;
                *second = self.times_color(*second, color, left)?;
            }
            Material::BumpMap { inner, .. } | Material::NormalMap { inner, .. } => {
                *inner = self.times_color(*inner, color, left)?;
            }
            model => {
                if !self.multiply(model, color) {
                    return None;
                }
            }
        }
        Some(self.desc.add(material))
    }

    /// `mix` of PBRT v3: the first material times the color `amount`, plus the second one times
    /// one minus that.
    pub(super) fn v3_mix(
        &mut self,
        entity: &Entity<'_>,
        first: MaterialId,
        second: MaterialId,
    ) -> MaterialId {
        let amount = self.reflectance(entity, "amount", 0.5);
        if let ColorInput::Constant(color) = amount
            && !color.is_gray()
        {
            let twice = |color: Rgb| ColorInput::Constant(color * 2.0);
            let mut left = MAX_PARTS;
            let parts = (
                self.times_color(first, twice(color), &mut left),
                self.times_color(second, twice(one_minus(color)), &mut left),
            );
            if let (Some(first), Some(second)) = parts {
                return self.blend(FloatInput::Constant(0.5), first, second);
            }
            let message = format!(
                "a colored `amount` of {} is replaced by its luminance",
                entity.params.describe()
            );
            entity.params.unsupported("colored amount", message);
        }
        let weight = self.gray_input(entity, "amount", amount);
        self.blend(weight, second, first)
    }

    /// The color of the parameter `name` as a number. Colored textures are reported once they are
    /// loaded.
    fn gray_input(
        &mut self,
        entity: &Entity<'_>,
        name: &'static str,
        color: ColorInput,
    ) -> FloatInput {
        match (color, entity.params.get(name)) {
            (ColorInput::Constant(color), _) if !color.is_gray() => {
                FloatInput::Constant(color.luminance())
            }
            (ColorInput::Texture(texture), Some(param)) => {
                let what = format!("`{name}` of {}", entity.params.describe());
                self.gray_colors.push((param.span, texture, what));
                FloatInput::Texture(texture)
            }
            _ => as_float(color),
        }
    }

    /// `parts` times `opacity`, with one minus that as straight-through transmission.
    pub(super) fn with_opacity(&mut self, entity: &Entity<'_>, mut parts: Vec<Part>) -> MaterialId {
        let opacity = self.reflectance(entity, "opacity", 1.0);
        if let ColorInput::Constant(color) = opacity
            && !color.is_gray()
        {
            for part in &mut parts {
                self.multiply(&mut part.material, opacity);
            }
            let rest = ColorInput::Constant(one_minus(color));
            parts.push(Part::transmitting(clear_film(rest)));
            return self.sum(parts);
        }
        let opacity = self.gray_input(entity, "opacity", opacity);
        let sum = self.sum(parts);
        self.masked(sum, opacity)
    }

    /// Warns about colors that are read as numbers but are not gray. For images that have been
    /// loaded.
    pub(in super::super) fn check_gray_colors(&self) {
        for (span, texture, what) in &self.gray_colors {
            if !is_gray_texture(&self.desc, *texture) {
                let message = format!("{what} is colored; its luminance is used");
                let problem = Problem::new("scene::unsupported", *span, message);
                self.sink.warn_once("colored weight", problem);
            }
        }
    }

    /// A surface that reflects by Fresnel's equations for a dielectric of index `eta`, and transmits
    /// nothing. It is a conductor without extinction (`k` = 0).
    pub(super) fn dielectric_reflection(
        eta: f32,
        color: ColorInput,
        roughness: Option<Roughness>,
    ) -> Material {
        Material::Conductor {
            eta: ColorInput::Constant(Rgb::splat(eta)),
            k: ColorInput::Constant(Rgb::BLACK),
            specular_reflectance: color,
            roughness,
        }
    }
}

/// Straight-through transmission of a color: a pane whose index is that of its surroundings.
fn clear_film(color: ColorInput) -> Material {
    Material::ThinDielectric {
        eta: 1.0,
        specular_reflectance: WHITE,
        specular_transmittance: color,
        roughness: None,
    }
}

/// Whether a color is black everywhere.
pub(super) fn is_black(color: ColorInput) -> bool {
    matches!(color, ColorInput::Constant(color) if color.is_black())
}

fn one_minus(color: Rgb) -> Rgb {
    color.map(|v| 1.0 - v)
}

/// Whether a texture has no colors, as far as its inputs say.
fn is_gray_texture(desc: &SceneDesc, texture: TextureId) -> bool {
    let mut seen = HashSet::new();
    let mut pending = vec![ColorInput::Texture(texture)];
    while let Some(input) = pending.pop() {
        let id = match input {
            ColorInput::Constant(color) if color.is_gray() => continue,
            ColorInput::Constant(_) => return false,
            ColorInput::Texture(id) => id,
        };
        if !seen.insert(id) {
            continue;
        }
        match &desc.textures[id.index()] {
            Texture::Bitmap(bitmap) => {
                let image = &bitmap.image;
                let mut pixels = image.data.chunks_exact(image.channels.max(1));
                if image.channels >= 3 && !pixels.all(|p| p[0] == p[1] && p[1] == p[2]) {
                    return false;
                }
            }
            Texture::Product { first, second } | Texture::Mix { first, second, .. } => {
                pending.extend([*first, *second]);
            }
            Texture::Checkerboard { color0, color1, .. } => pending.extend([*color0, *color1]),
            Texture::Dots {
                inside, outside, ..
            } => pending.extend([*inside, *outside]),
            Texture::OtherUv { inner, .. }
            | Texture::Projected { inner, .. }
            | Texture::Power { base: inner, .. } => pending.push(ColorInput::Texture(*inner)),
            _ => {}
        }
    }
    true
}
