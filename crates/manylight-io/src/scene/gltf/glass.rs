//! The part of a material that transmits light by refraction: panes and solid bodies.

use super::super::description::WHITE;
use super::super::parameters::Numbers;
use super::extensions::{DEFAULT_IOR, Lobes};
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader, reflectance};
use super::origin::Origin;
use super::textures::VertexInputs;
use manylight::bsdf::Material;
use manylight::bsdf::material::{Distribution, Roughness};
use manylight::color::Rgb;
use manylight::texture::{ColorInput, FloatInput};

/// Roughness alpha up to which glass is smooth.
const SMOOTH_ALPHA: f32 = 1e-3;
/// Smallest index of refraction of glass: an interface of index 1 would not refract.
const SMALLEST_IOR: f32 = 1.001;

/// The transmitting part of a material.
pub(super) struct Glass {
    /// The interfaces, which are added: a single one, or with dispersion one for each channel.
    pub(super) parts: Vec<Material>,
    /// Fraction of the light that does not enter the opaque part.
    pub(super) weight: FloatInput,
}

impl Glass {
    /// By KHR_materials_transmission: a thin pane, or with KHR_materials_volume a solid body.
    pub(super) fn read(
        reader: &mut MaterialReader<'_, '_>,
        base: &Base,
        lobes: &Lobes,
    ) -> Option<Self> {
        let dispersion = dispersion(reader.json);
        let json = reader.json.extension("KHR_materials_transmission")?;
        let factor = json.fraction("transmissionFactor", 0.0);
        if factor == 0.0 {
            return None;
        }
        let texture = reader.texture(&json, "transmissionTexture", Content::Channel(0));
        let transmitting = match base.metallic {
            FloatInput::Constant(metallic) => factor * (1.0 - metallic),
            FloatInput::Texture(_) => factor,
        };
        if transmitting == 0.0 {
            return None;
        }
        let weight = reader.textures.scaled(transmitting, texture);
        let coat = reader.json.extension("KHR_materials_clearcoat");
        if let Some(coat) = coat.filter(|coat| coat.float("clearcoatFactor", 0.0) > 0.0) {
            let message = "the clear coat of what transmits light is ignored";
            coat.warn_once("clearcoat on glass", message);
        }
        if lobes.film.is_some() {
            let message =
                "the thin film (KHR_materials_iridescence) of what transmits light is ignored";
            json.warn_once("iridescence on glass", message);
        }
        let volume = thick_volume(reader.json);
        // Transmission in Blender refracts; its exporter says so by a thickness only if the user
        // gives one.
        let is_solid = volume.is_some() || reader.document.is_by_blender();
        if !is_solid && reader.document.origin == Origin::Replaced {
            let message = "the program that rewrote this file has removed the name of its exporter; transmission without a thickness (KHR_materials_volume) is that of thin panes. If the scene is from Blender, it is meant to be solid";
            json.warn_once("thin transmission", message);
        }
        let eta = match lobes.ior {
            ior if ior >= SMALLEST_IOR => ior,
            _ => DEFAULT_IOR,
        };
        let roughness = roughness(reader, base);
        let parts = if is_solid {
            let transmittance = volume.map_or(Rgb::WHITE, |volume| {
                surface_transmittance(&volume, reader.vertices)
            });
            let tint = tint(reader, transmittance, base);
            // A scattering function has four leaves at most.
            let has_space = weight == FloatInput::Constant(1.0) || lobes.is_one_leaf();
            if dispersion > 0.0 && !has_space {
                let message = "the dispersion (KHR_materials_dispersion) of glass that is mixed with a base of several layers is ignored";
                json.warn_once("dispersion of mixed glass", message);
            }
            match dispersion > 0.0 && has_space {
                true => dispersing(reader, tint, iors(eta, dispersion), roughness),
                false => vec![interface(eta, WHITE, tint, roughness)],
            }
        } else {
            vec![thin(base, eta, roughness)]
        };
        Some(Glass { parts, weight })
    }
}

/// The parameter of KHR_materials_dispersion: 20 over Abbe's number.
fn dispersion(json: &Json<'_>) -> f32 {
    json.extension("KHR_materials_dispersion")
        .map_or(0.0, |extension| {
            extension.float_where("dispersion", 0.0, |v| v >= 0.0, "at least 0")
        })
}

/// The volume of a body with a thickness, by KHR_materials_volume.
pub(super) fn thick_volume<'a>(json: &Json<'a>) -> Option<Json<'a>> {
    let volume = json.extension("KHR_materials_volume");
    volume.filter(|volume| volume.float("thicknessFactor", 0.0) > 0.0)
}

/// Indices of refraction in red, green and blue, by the formula of KHR_materials_dispersion.
fn iors(ior: f32, dispersion: f32) -> [f32; 3] {
    let half_spread = (ior - 1.0) * 0.025 * dispersion;
    [ior - half_spread, ior, ior + half_spread].map(|ior| ior.max(SMALLEST_IOR))
}

/// An interface for each channel.
fn dispersing(
    reader: &mut MaterialReader<'_, '_>,
    tint: ColorInput,
    iors: [f32; 3],
    roughness: Option<Roughness>,
) -> Vec<Material> {
    let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let parts = iors.into_iter().zip(channels);
    let part = |(ior, channel): (f32, [f32; 3])| {
        let channel = ColorInput::Constant(Rgb::from(channel));
        let transmittance = reader.textures.product(channel, tint);
        interface(ior, channel, transmittance, roughness)
    };
    parts.map(part).collect()
}

/// An interface that refracts.
fn interface(
    eta: f32,
    specular_reflectance: ColorInput,
    specular_transmittance: ColorInput,
    roughness: Option<Roughness>,
) -> Material {
    Material::Dielectric {
        eta,
        specular_reflectance,
        specular_transmittance,
        roughness,
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
fn thin(base: &Base, eta: f32, roughness: Option<Roughness>) -> Material {
    Material::ThinDielectric {
        eta,
        specular_reflectance: WHITE,
        specular_transmittance: base.color,
        roughness,
    }
}

/// The tint of each side of a body. Its base color, and the absorption over its thickness, tint the
/// light that passes both of its sides: half of them at each.
fn tint(reader: &mut MaterialReader<'_, '_>, transmittance: Rgb, base: &Base) -> ColorInput {
    match base.color {
        ColorInput::Constant(color) => {
            ColorInput::Constant(color.zip(transmittance, |a, b| a * b).map(f32::sqrt))
        }
        textured => {
            let half = ColorInput::Constant(transmittance.map(f32::sqrt));
            reader.textures.product(half, textured)
        }
    }
}

/// Color and distance in m of the attenuation in a volume; `None` if it absorbs nothing.
fn attenuation(volume: &Json<'_>) -> Option<(Rgb, f32)> {
    let color = reflectance(volume.floats("attenuationColor", [1.0; 3]));
    let positive = |v: f32| v > 0.0;
    let distance = volume.float_where("attenuationDistance", f32::INFINITY, positive, "positive");
    (color != Rgb::WHITE && distance.is_finite()).then_some((color, distance))
}

/// Absorption coefficient in 1/m inside of the body of a mesh; `None` if the mesh is no body, or
/// absorbs nothing.
pub(super) fn absorption_coefficient(
    material: &Json<'_>,
    vertices: &VertexInputs<'_>,
) -> Option<Rgb> {
    let volume = thick_volume(material).filter(|_| vertices.is_body)?;
    let (color, distance) = attenuation(&volume)?;
    // Finite where a channel of the color is 0, or the distance is tiny.
    let most = f32::MAX;
    Some(color.map(|v| (-v.max(f32::MIN_POSITIVE).ln() / distance).min(most)))
}

/// Transmittance that the surface of a volume has in the place of its inside: that over the
/// thickness, where the surface is not that of a body. The thickness is given in the space of the
/// mesh, the distance of attenuation in the world.
pub(super) fn surface_transmittance(volume: &Json<'_>, vertices: &VertexInputs<'_>) -> Rgb {
    if vertices.is_body {
        return Rgb::WHITE;
    }
    let Some((color, distance)) = attenuation(volume) else {
        return Rgb::WHITE;
    };
    volume.warn_once(
        "absorption",
        "absorption along paths in a volume whose surface is not closed is not simulated; the color over its `thicknessFactor` tints its surface",
    );
    let thickness = volume.float("thicknessFactor", 0.0) * vertices.scale;
    color.map(|v| v.powf(thickness / distance))
}
