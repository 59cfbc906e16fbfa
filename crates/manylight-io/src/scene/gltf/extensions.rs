//! The KHR_materials extensions: further lobes, other interfaces, and the specular-glossiness
//! model.

use super::super::description::WHITE;
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
const DEFAULT_IOR: f32 = 1.5;

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
    /// Roughness, if anisotropy changes it.
    pub(super) roughness: Option<FloatInput>,
    pub(super) anisotropic: f32,
    pub(super) sheen: f32,
    pub(super) clearcoat: FloatInput,
    pub(super) clearcoat_gloss: f32,
}

impl Default for Lobes {
    fn default() -> Self {
        Lobes {
            ior: DEFAULT_IOR,
            f0: normal_reflectance(DEFAULT_IOR),
            roughness: None,
            anisotropic: 0.0,
            sheen: 0.0,
            clearcoat: FloatInput::Constant(0.0),
            clearcoat_gloss: 1.0,
        }
    }
}

fn normal_reflectance(ior: f32) -> f32 {
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
            lobes.f0 *= specular(&extension);
        }
        if let Some(extension) = json.extension("KHR_materials_anisotropy") {
            lobes.set_anisotropy(&extension, base);
        }
        if let Some(extension) = json.extension("KHR_materials_sheen") {
            lobes.set_sheen(&extension);
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

    /// The strength makes alpha along the tangent `mix(alpha, 1, strength²)`; alpha across stays.
    /// The principled model has `alpha / aspect` and `alpha aspect` with
    /// `aspect² = 1 - 0.9 anisotropic`.
    fn set_anisotropy(&mut self, json: &Json<'_>, base: &Base) {
        /// Smallest ratio of the two alphas: that of the principled model for `anisotropic` = 1.
        const SMALLEST_RATIO: f32 = 0.1;
        /// Largest angle in radians between the direction and an axis of the tangent frame that
        /// counts as none.
        const ALIGNED: f32 = 0.01;
        let strength = json.fraction("anisotropyStrength", 0.0);
        let rotation = json.float("anisotropyRotation", 0.0);
        if strength == 0.0 {
            return;
        }
        let quarter =
            (rotation.rem_euclid(std::f32::consts::PI) / std::f32::consts::FRAC_PI_2).round();
        let off_axis = (rotation.rem_euclid(std::f32::consts::PI)
            - quarter * std::f32::consts::FRAC_PI_2)
            .abs();
        if off_axis > ALIGNED {
            let message = "directions of anisotropy between the axes of the tangent frame are replaced by the nearest axis";
            json.warn_once("anisotropy rotation", message);
        }
        for (present, what) in [
            (
                json.has("anisotropyTexture"),
                "textures of anisotropy are ignored",
            ),
            (
                base.has_roughness_texture,
                "with anisotropy, textures of roughness are ignored",
            ),
        ] {
            if present {
                json.warn_once(what, what);
            }
        }
        let alpha = (base.roughness_factor * base.roughness_factor).max(1e-3);
        let along = alpha + (1.0 - alpha) * strength * strength;
        let ratio = (alpha / along).max(SMALLEST_RATIO);
        let mean = (along * along * ratio).sqrt();
        self.roughness = Some(FloatInput::Constant(mean.sqrt()));
        let is_across = quarter == 1.0;
        self.anisotropic = (1.0 - if is_across { ratio.recip() } else { ratio }) / 0.9;
    }

    fn set_sheen(&mut self, json: &Json<'_>) {
        let color = Rgb::from(json.floats("sheenColorFactor", [0.0; 3]));
        self.sheen = color.max_channel();
        if self.sheen > 0.0 {
            json.warn_once(
                "sheen",
                "sheen is approximated by the white sheen of the principled model; its color, roughness and textures are ignored",
            );
        }
    }

    fn set_clearcoat<'a>(&mut self, reader: &mut MaterialReader<'a, '_>, json: &Json<'a>) {
        /// Alphas of the principled model's clear coat for a gloss of 0 and of 1.
        const ALPHAS: [f32; 2] = [0.1, 0.001];
        let factor = json.fraction("clearcoatFactor", 0.0);
        if factor == 0.0 {
            return;
        }
        let texture = reader.texture(json, "clearcoatTexture", Content::Channel(0));
        self.clearcoat = reader.textures.scaled(factor, texture);
        let roughness = json.fraction("clearcoatRoughnessFactor", 0.0);
        let alpha = roughness * roughness;
        self.clearcoat_gloss = ((ALPHAS[0] - alpha) / (ALPHAS[0] - ALPHAS[1])).clamp(0.0, 1.0);
        if alpha > ALPHAS[0] {
            let message = "clear coats are at most of roughness 0.316 here; rougher ones are replaced by this one";
            json.warn_once("clearcoat roughness", message);
        }
        if json.has("clearcoatRoughnessTexture") || json.has("clearcoatNormalTexture") {
            let message = "textures of the roughness and of the normal of clear coats are ignored";
            json.warn_once("clearcoat textures", message);
        }
    }
}

/// Factor of the reflectance at normal incidence by KHR_materials_specular.
fn specular(json: &Json<'_>) -> f32 {
    let factor = json.fraction("specularFactor", 1.0);
    let color = Rgb::from(json.floats("specularColorFactor", [1.0; 3]));
    let is_gray = color.r == color.g && color.g == color.b;
    if !is_gray || json.has("specularColorTexture") || json.has("specularTexture") {
        json.warn_once(
            "specular",
            "the color and the textures of the dielectric reflection (KHR_materials_specular) are replaced by its mean",
        );
    }
    factor * color.mean()
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
            let transmittance = volume.map_or(Rgb::WHITE, |volume| absorption(&volume));
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

/// Transmittance over the thickness of a volume.
fn absorption(volume: &Json<'_>) -> Rgb {
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
    let thickness = volume.float("thicknessFactor", 0.0);
    color.map(|v| v.powf(thickness / distance))
}

/// The specular-glossiness model, converted to the metallic-roughness model.
pub(super) fn specular_glossiness<'a>(
    reader: &mut MaterialReader<'a, '_>,
    json: &Json<'a>,
    mode: &str,
) -> Base {
    /// Reflectance from which on a specular color is that of a metal.
    const METAL: f32 = 0.25;
    json.warn_once(
        "specular-glossiness",
        "the specular-glossiness model (KHR_materials_pbrSpecularGlossiness) is converted to the metallic-roughness model: above a reflectance of 0.25 as a metal, else as a dielectric of the mean reflectance",
    );
    let [r, g, b, a] = json.floats("diffuseFactor", [1.0; 4]);
    let diffuse = reflectance([r, g, b]);
    let specular = reflectance(json.floats("specularFactor", [1.0; 3]));
    let glossiness = json.fraction("glossinessFactor", 1.0);
    let name = "specularGlossinessTexture";
    let opacity = reader.opacity(json, "diffuseTexture", a, mode);
    let gloss = Content::OneMinusOpacity { factor: glossiness };
    let texture = reader.texture(json, name, gloss);
    let has_roughness_texture = texture.is_some();
    let is_metal = specular.max_channel() > METAL && !has_roughness_texture;
    if has_roughness_texture {
        json.warn_once(
            "specular textures",
            "the specular colors of `specularGlossinessTexture` are replaced by a reflectance of 0.04; its glossiness is used",
        );
    }
    // The brighter of both colors is that of the surface; a metal has no diffuse color.
    let color = if is_metal {
        ColorInput::Constant(specular)
    } else {
        reader.color(json, "diffuseTexture", diffuse)
    };
    let f0 = if is_metal || has_roughness_texture {
        normal_reflectance(DEFAULT_IOR)
    } else {
        specular.mean()
    };
    Base {
        color,
        opacity,
        metallic: FloatInput::Constant(if is_metal { 1.0 } else { 0.0 }),
        roughness: reader.textures.scaled(
            if has_roughness_texture {
                1.0
            } else {
                1.0 - glossiness
            },
            texture,
        ),
        roughness_factor: 1.0 - glossiness,
        has_roughness_texture,
        f0: Some(f0),
    }
}
