//! The KHR_materials extensions: further lobes and other interfaces.

use super::super::description::{WHITE, as_color, as_float};
use super::super::parameters::Numbers;
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader, reflectance};
use super::origin::Origin;
use manylight::bsdf::Material;
use manylight::bsdf::material::{Distribution, Roughness};
use manylight::color::Rgb;
use manylight::texture::{ColorInput, FloatInput};

/// The index of refraction of a dielectric by default.
pub(super) const DEFAULT_IOR: f32 = 1.5;

/// Roughness alpha up to which glass is smooth.
const SMOOTH_ALPHA: f32 = 1e-3;

/// Extensions that are ignored, and what they would do.
const IGNORED: [(&str, &str, &str); 3] = [
    (
        "KHR_materials_iridescence",
        "iridescenceFactor",
        "thin-film interference",
    ),
    ("KHR_materials_dispersion", "dispersion", "dispersion"),
    (
        "KHR_materials_diffuse_transmission",
        "diffuseTransmissionFactor",
        "diffuse transmission",
    ),
];

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
        }
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
        for (name, factor, what) in IGNORED {
            if let Some(extension) = json.extension(name).filter(|e| e.float(factor, 0.0) != 0.0) {
                extension.warn_once(name, format!("{what} ({name}) is ignored"));
            }
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

    /// A coat with the normals of what is below.
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
        let image = |json: &Json<'_>, name: &str| {
            let info = json.member(name)?;
            info.unsigned("index")
        };
        let of_base = image(reader.json, "normalTexture");
        if image(json, "clearcoatNormalTexture") != of_base {
            let message = "clear coats have the normals of the surface below: `clearcoatNormalTexture` is not read, or `normalTexture` tilts the coat";
            json.warn_once("clearcoat normals", message);
        }
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

/// The transmitting part of a material.
pub(super) struct Glass {
    pub(super) material: Material,
    /// Fraction of the light that does not enter the opaque part.
    pub(super) weight: FloatInput,
}

impl Glass {
    /// By KHR_materials_transmission: a thin pane, or with KHR_materials_volume a solid body.
    pub(super) fn read(reader: &mut MaterialReader<'_, '_>, base: &Base, ior: f32) -> Option<Self> {
        let json = reader.json.extension("KHR_materials_transmission")?;
        let factor = json.fraction("transmissionFactor", 0.0);
        if factor == 0.0 {
            return None;
        }
        let texture = reader.texture(&json, "transmissionTexture", Content::Channel(0));
        let opaque = match base.metallic {
            FloatInput::Constant(metallic) => factor * (1.0 - metallic),
            FloatInput::Texture(_) => factor,
        };
        if opaque == 0.0 {
            return None;
        }
        let weight = reader.textures.scaled(opaque, texture);
        let coat = reader.json.extension("KHR_materials_clearcoat");
        if let Some(coat) = coat.filter(|coat| coat.float("clearcoatFactor", 0.0) > 0.0) {
            let message = "the clear coat of what transmits light is ignored";
            coat.warn_once("clearcoat on glass", message);
        }
        let volume = reader.json.extension("KHR_materials_volume");
        let volume = volume.filter(|volume| volume.float("thicknessFactor", 0.0) > 0.0);
        // Transmission in Blender refracts; its exporter says so by a thickness only if the user
        // gives one.
        let is_solid = volume.is_some() || reader.document.is_by_blender();
        if !is_solid && reader.document.origin == Origin::Replaced {
            let message = "the program that rewrote this file has removed the name of its exporter; transmission without a thickness (KHR_materials_volume) is that of thin panes. If the scene is from Blender, it is meant to be solid";
            json.warn_once("thin transmission", message);
        }
        let eta = if ior >= 1.001 { ior } else { DEFAULT_IOR };
        let roughness = roughness(reader, base);
        let material = if is_solid {
            let transmittance = volume.map_or(Rgb::WHITE, |volume| {
                absorption(&volume, reader.vertices.scale)
            });
            solid(reader, transmittance, base, eta, roughness)
        } else {
            thin(&json, base, eta, roughness)
        };
        Some(Glass { material, weight })
    }
}

/// The roughness of glass; `None`: smooth.
fn roughness(reader: &mut MaterialReader<'_, '_>, base: &Base) -> Option<Roughness> {
    let alpha = reader.textures.power(base.roughness, 2.0);
    let is_smooth = matches!(alpha, FloatInput::Constant(alpha) if alpha <= SMOOTH_ALPHA);
    (!is_smooth).then_some(Roughness {
        distribution: Distribution::Ggx,
        alpha_u: alpha,
        alpha_v: alpha,
    })
}

/// A pane without refraction. Its base color tints transmitted light.
fn thin(json: &Json<'_>, base: &Base, eta: f32, roughness: Option<Roughness>) -> Material {
    let Some(roughness) = roughness else {
        return Material::ThinDielectric {
            eta,
            specular_reflectance: WHITE,
            specular_transmittance: base.color,
        };
    };
    json.warn_once(
        "rough panes",
        "rough thin transmission is replaced by a rough interface, which refracts",
    );
    Material::Dielectric {
        eta,
        specular_reflectance: WHITE,
        specular_transmittance: base.color,
        roughness: Some(roughness),
    }
}

/// A body that refracts. Its base color, and the absorption over its thickness, tint the light that
/// passes both of its sides: half of them at each.
fn solid(
    reader: &mut MaterialReader<'_, '_>,
    transmittance: Rgb,
    base: &Base,
    eta: f32,
    roughness: Option<Roughness>,
) -> Material {
    let tint = match base.color {
        ColorInput::Constant(color) => {
            ColorInput::Constant(color.zip(transmittance, |a, b| a * b).map(f32::sqrt))
        }
        textured => {
            let half = ColorInput::Constant(transmittance.map(f32::sqrt));
            reader.textures.product(half, textured)
        }
    };
    Material::Dielectric {
        eta,
        specular_reflectance: WHITE,
        specular_transmittance: tint,
        roughness,
    }
}

/// Transmittance over the thickness of a volume, which is given in the space of its mesh, while the
/// distance of attenuation is given in the world.
fn absorption(volume: &Json<'_>, scale: f32) -> Rgb {
    let color = reflectance(volume.floats("attenuationColor", [1.0; 3]));
    let positive = |v: f32| v > 0.0;
    let distance = volume.float_where("attenuationDistance", f32::INFINITY, positive, "positive");
    if color == Rgb::WHITE || !distance.is_finite() {
        return Rgb::WHITE;
    }
    volume.warn_once(
        "absorption",
        "absorption along paths in a volume is not simulated; the color over its `thicknessFactor` tints its surface",
    );
    let thickness = volume.float("thicknessFactor", 0.0) * scale;
    color.map(|v| v.powf(thickness / distance))
}
