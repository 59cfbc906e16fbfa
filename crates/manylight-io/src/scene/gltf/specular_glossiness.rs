//! The extension KHR_materials_pbrSpecularGlossiness, converted to the metallic-roughness model.

use super::extensions::{DEFAULT_IOR, normal_reflectance};
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader, reflectance};
use manylight::texture::{ColorInput, FloatInput};

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
        f0: Some(f0),
    }
}
