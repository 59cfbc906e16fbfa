//! The KHR_materials extensions of the opaque part: further lobes and other interfaces.

use super::super::description::{WHITE, as_color, as_float};
use super::super::parameters::Numbers;
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader, reflectance};
use manylight::bsdf::material::{CoatReflection, ThinFilm};
use manylight::color::Rgb;
use manylight::texture::{ColorInput, FloatInput};

/// The index of refraction of a dielectric by default.
pub(super) const DEFAULT_IOR: f32 = 1.5;

/// What extensions add to the opaque part of a material.
pub(super) struct Lobes {
    pub(super) ior: f32,
    /// Reflectance at normal incidence.
    pub(super) f0: f32,
    /// Factor of the reflectance at normal incidence.
    pub(super) specular_tint: ColorInput,
    /// Roughness, if anisotropy changes it.
    pub(super) roughness: Option<FloatInput>,
    pub(super) anisotropic: FloatInput,
    pub(super) sheen: FloatInput,
    pub(super) clearcoat: FloatInput,
    pub(super) coat_roughness: FloatInput,
    /// `Apart`: the coat has other normals than what is below.
    pub(super) coat_reflection: CoatReflection,
    pub(super) film: Option<ThinFilm>,
    pub(super) transmission: Option<DiffuseTransmission>,
}

/// Light that passes the surface diffusely.
#[derive(Clone, Copy, Debug)]
pub(super) struct DiffuseTransmission {
    /// Fraction of the light below the dielectric interface.
    pub(super) weight: FloatInput,
    pub(super) color: ColorInput,
}

impl Default for Lobes {
    fn default() -> Self {
        let none = FloatInput::Constant(0.0);
        Lobes {
            ior: DEFAULT_IOR,
            f0: normal_reflectance(DEFAULT_IOR),
            specular_tint: WHITE,
            roughness: None,
            anisotropic: none,
            sheen: none,
            clearcoat: none,
            coat_roughness: none,
            coat_reflection: CoatReflection::Here,
            film: None,
            transmission: None,
        }
    }
}

impl Lobes {
    /// Whether the opaque part is one scattering model.
    pub(super) fn is_one_leaf(&self) -> bool {
        self.coat_reflection == CoatReflection::Here && self.transmission.is_none()
    }
}

pub(super) fn normal_reflectance(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

impl Lobes {
    pub(super) fn read<'a>(reader: &mut MaterialReader<'a, '_>, base: &Base) -> Self {
        let json = reader.json;
        let mut lobes = Lobes::default();
        if let Some(extension) = json.extension("KHR_materials_ior") {
            let valid = |v: f32| v == 0.0 || v >= 1.0;
            lobes.ior = extension.float_where("ior", DEFAULT_IOR, valid, "at least 1, or 0");
            lobes.f0 = normal_reflectance(lobes.ior);
        }
        if let Some(extension) = json.extension("KHR_materials_specular") {
            lobes.set_specular(reader, &extension);
        }
        if let Some(extension) = json.extension("KHR_materials_anisotropy") {
            lobes.set_anisotropy(reader, &extension, base);
        }
        if let Some(extension) = json.extension("KHR_materials_sheen") {
            lobes.set_sheen(reader, &extension);
        }
        if let Some(extension) = json.extension("KHR_materials_clearcoat") {
            lobes.set_clearcoat(reader, &extension);
        }
        if let Some(extension) = json.extension("KHR_materials_iridescence") {
            lobes.set_iridescence(reader, &extension);
        }
        if let Some(extension) = json.extension("KHR_materials_diffuse_transmission") {
            lobes.set_diffuse_transmission(reader, &extension);
        }
        lobes
    }

    /// A gray factor without textures changes the index of refraction, as in Blender; colors and
    /// textures tint the reflectance at normal incidence.
    fn set_specular<'a>(&mut self, reader: &mut MaterialReader<'a, '_>, json: &Json<'a>) {
        self.f0 *= json.fraction("specularFactor", 1.0);
        let color = Rgb::from(json.floats("specularColorFactor", [1.0; 3]));
        let color = color.map(|v| v.max(0.0));
        if color.is_gray() && !json.has("specularColorTexture") && !json.has("specularTexture") {
            self.f0 *= color.mean();
            return;
        }
        let tint = reader.color(json, "specularColorTexture", color);
        let factor = reader.texture(json, "specularTexture", Content::Opacity);
        let factor = as_color(reader.textures.scaled(1.0, factor));
        self.specular_tint = reader.textures.product(tint, factor);
    }

    fn set_anisotropy<'a>(
        &mut self,
        reader: &mut MaterialReader<'a, '_>,
        json: &Json<'a>,
        base: &Base,
    ) {
        let strength = json.fraction("anisotropyStrength", 0.0);
        if strength == 0.0 {
            return;
        }
        let is_across = is_across(json);
        let texture = reader.texture(json, "anisotropyTexture", Content::Channel(2));
        if texture.is_some() {
            let message = "the directions in `anisotropyTexture` are ignored; its strength is used";
            json.warn_once("anisotropy texture", message);
        }
        let strength = reader.textures.scaled(strength, texture);
        match (base.roughness, strength) {
            (FloatInput::Constant(roughness), FloatInput::Constant(strength)) => {
                self.set_constant_anisotropy(roughness, strength, is_across);
            }
            _ => self.set_textured_anisotropy(reader, base.roughness, strength, is_across),
        }
    }

    /// The strength makes alpha along the tangent `mix(alpha, 1, strength²)`; alpha across stays.
    /// The principled model has `alpha / aspect` and `alpha aspect` with
    /// `aspect² = 1 - 0.9 anisotropic`.
    fn set_constant_anisotropy(&mut self, roughness: f32, strength: f32, is_across: IsAcross) {
        /// Smallest ratio of the two alphas: that of the principled model for `anisotropic` = 1.
        const SMALLEST_RATIO: f32 = 0.1;
        let alpha = (roughness * roughness).max(1e-3);
        let along = alpha + (1.0 - alpha) * strength * strength;
        let ratio = (alpha / along).max(SMALLEST_RATIO);
        let mean = (along * along * ratio).sqrt();
        self.roughness = Some(FloatInput::Constant(mean.sqrt()));
        let aspect2 = if is_across.0 { ratio.recip() } else { ratio };
        self.anisotropic = FloatInput::Constant((1.0 - aspect2) / 0.9);
    }

    /// The same by textures: `roughness² = √(along across)`, `aspect² = across / along`.
    fn set_textured_anisotropy(
        &mut self,
        reader: &mut MaterialReader<'_, '_>,
        roughness: FloatInput,
        strength: FloatInput,
        is_across: IsAcross,
    ) {
        let textures = &mut *reader.textures;
        let alpha = textures.power(roughness, 2.0);
        let weight = textures.power(strength, 2.0);
        let along = textures.mix(as_color(alpha), WHITE, weight);
        let both = as_float(textures.product(as_color(alpha), along));
        self.roughness = Some(textures.power(both, 0.25));
        let inverse = textures.power(as_float(along), -1.0);
        let ratio = textures.product(as_color(alpha), as_color(inverse));
        let gray = |v: f32| ColorInput::Constant(Rgb::splat(v));
        let mut anisotropic = textures.mix(gray(1.0 / 0.9), gray(0.0), as_float(ratio));
        if is_across.0 {
            // 1 - 1/ρ = -(1 - ρ)/ρ for the ratio ρ.
            let inverse = textures.power(as_float(ratio), -1.0);
            let scaled = textures.product(anisotropic, as_color(inverse));
            anisotropic = textures.product(scaled, gray(-1.0));
        }
        self.anisotropic = as_float(anisotropic);
    }

    fn set_sheen<'a>(&mut self, reader: &mut MaterialReader<'a, '_>, json: &Json<'a>) {
        let color = Rgb::from(json.floats("sheenColorFactor", [0.0; 3]));
        if color.max_channel() > 0.0 {
            let texture = reader.texture(json, "sheenColorTexture", Content::Color);
            self.sheen = reader.textures.scaled(color.max_channel(), texture);
            json.warn_once(
                "sheen",
                "sheen is approximated by the white sheen of the principled model, as strong as the luminance of `sheenColorTexture`; its color, its roughness and `sheenRoughnessTexture` are ignored",
            );
        }
    }

    /// A coat. Its normals are those of the mesh, or of its own texture.
    fn set_clearcoat<'a>(&mut self, reader: &mut MaterialReader<'a, '_>, json: &Json<'a>) {
        let factor = json.fraction("clearcoatFactor", 0.0);
        if factor == 0.0 {
            return;
        }
        let mut scaled = |factor: f32, name: &str, channel: usize| {
            let texture = reader.texture(json, name, Content::Channel(channel));
            reader.textures.scaled(factor, texture)
        };
        self.clearcoat = scaled(factor, "clearcoatTexture", 0);
        let roughness = json.fraction("clearcoatRoughnessFactor", 0.0);
        self.coat_roughness = scaled(roughness, "clearcoatRoughnessTexture", 1);
        let below = reader.json.get("normalTexture");
        let above = json.get("clearcoatNormalTexture");
        let is_equal = match (&below, &above) {
            (None, None) => true,
            (Some(below), Some(above)) => below.equals(above),
            _ => false,
        };
        if !is_equal {
            self.coat_reflection = CoatReflection::Apart;
        }
    }

    fn set_iridescence<'a>(&mut self, reader: &mut MaterialReader<'a, '_>, json: &Json<'a>) {
        let factor = json.fraction("iridescenceFactor", 0.0);
        let is_index = |v: f32| v >= 1.0;
        let eta = json.float_where("iridescenceIor", 1.3, is_index, "at least 1");
        let is_length = |v: f32| v >= 0.0;
        let thickness = |name, default| {
            json.float_where(name, default, is_length, "a thickness in nm of at least 0")
        };
        let thinnest = thickness("iridescenceThicknessMinimum", 100.0);
        let thickest = thickness("iridescenceThicknessMaximum", 400.0);
        if factor == 0.0 {
            return;
        }
        let texture = reader.texture(json, "iridescenceTexture", Content::Channel(0));
        let weight = reader.textures.scaled(factor, texture);
        let name = "iridescenceThicknessTexture";
        let thickness = match reader.texture(json, name, Content::Channel(1)) {
            None => FloatInput::Constant(thickest),
            Some(id) => {
                let gray = |v: f32| ColorInput::Constant(Rgb::splat(v));
                let part = FloatInput::Texture(id);
                as_float((reader.textures).mix(gray(thinnest), gray(thickest), part))
            }
        };
        self.film = Some(ThinFilm {
            weight,
            eta,
            thickness,
        });
    }

    fn set_diffuse_transmission<'a>(
        &mut self,
        reader: &mut MaterialReader<'a, '_>,
        json: &Json<'a>,
    ) {
        let factor = json.fraction("diffuseTransmissionFactor", 0.0);
        let color = reflectance(json.floats("diffuseTransmissionColorFactor", [1.0; 3]));
        if factor == 0.0 {
            return;
        }
        let texture = reader.texture(json, "diffuseTransmissionTexture", Content::Opacity);
        self.transmission = Some(DiffuseTransmission {
            weight: reader.textures.scaled(factor, texture),
            color: reader.color(json, "diffuseTransmissionColorTexture", color),
        });
    }
}

/// Whether the direction of anisotropy is nearer to the bitangent than to the tangent.
#[derive(Clone, Copy, Debug)]
struct IsAcross(bool);

/// The axis of the tangent frame that is nearest to the direction of anisotropy.
fn is_across(json: &Json<'_>) -> IsAcross {
    /// Largest angle in radians between the direction and an axis of the tangent frame that counts
    /// as none.
    const ALIGNED: f32 = 0.01;
    let rotation = json.float("anisotropyRotation", 0.0);
    let rotation = rotation.rem_euclid(std::f32::consts::PI);
    let quarter = (rotation / std::f32::consts::FRAC_PI_2).round();
    let off_axis = (rotation - quarter * std::f32::consts::FRAC_PI_2).abs();
    if off_axis > ALIGNED {
        let message = "directions of anisotropy between the axes of the tangent frame are replaced by the nearest axis";
        json.warn_once("anisotropy rotation", message);
    }
    IsAcross(quarter == 1.0)
}
