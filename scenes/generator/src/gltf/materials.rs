//! Metallic-roughness materials.

use super::number;
use crate::fresnel::Coat;
use crate::material::{LinearRgb, Material, Reflectance};
use crate::png::PngImage;
use crate::scene::{MaterialId, Scene};
use serde_json::{Value, json};

/// Index of refraction of glTF's dielectrics without the extension KHR_materials_ior.
const DEFAULT_IOR: f64 = 1.5;

/// The materials of a file, with their textures.
#[derive(Debug, Default)]
pub(super) struct MaterialList {
    pub(super) materials: Vec<Value>,
    pub(super) images: Vec<(String, PngImage)>,
    pub(super) extensions: Vec<&'static str>,
    known: Vec<(MaterialId, Option<LinearRgb>)>,
}

/// The parameters of an opaque material.
#[derive(Clone, Copy, Debug)]
struct Opaque<'a> {
    /// Factor of the texture, or the color without one.
    color: LinearRgb,
    texture: Option<&'a str>,
    metallic: f64,
    /// Root of alpha.
    roughness: f64,
    /// Index of refraction of the dielectric; `None` without reflection.
    ior: Option<f64>,
}

impl MaterialList {
    /// Index of a material with this emission, added at its first use.
    pub(super) fn add(
        &mut self,
        scene: &Scene,
        id: MaterialId,
        emission: Option<LinearRgb>,
    ) -> usize {
        if let Some(known) = self.known.iter().position(|known| *known == (id, emission)) {
            return known;
        }
        let (name, material) = &scene.materials[id.0];
        let mut value = match material {
            Material::Glass { ior } => self.glass(*ior),
            Material::Mixed {
                first,
                second,
                weight,
            } => self.mixed(scene, name, [opaque(first), opaque(second)], weight),
            _ => {
                let opaque = opaque(material);
                let mut value = self.opaque(&opaque);
                if let Some(texture) = opaque.texture {
                    let texture = self.image(texture, scene);
                    value["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
                }
                value
            }
        };
        value["name"] = json!(name);
        if let Some(radiance) = emission {
            self.emit(&mut value, radiance);
        }
        self.materials.push(value);
        self.known.push((id, emission));
        self.materials.len() - 1
    }

    fn opaque(&mut self, opaque: &Opaque<'_>) -> Value {
        let [r, g, b] = opaque.color.map(number);
        let mut value = json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": number(opaque.metallic),
                "roughnessFactor": number(opaque.roughness),
            },
        });
        match opaque.ior {
            None => {
                let none = json!({ "specularFactor": 0.0 });
                self.extend(&mut value, "KHR_materials_specular", none);
            }
            Some(ior) if ior != DEFAULT_IOR => {
                self.extend(
                    &mut value,
                    "KHR_materials_ior",
                    json!({ "ior": number(ior) }),
                );
            }
            Some(_) => {}
        }
        value
    }

    /// Solid glass.
    fn glass(&mut self, ior: f64) -> Value {
        let mut value = json!({
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        });
        self.extend(
            &mut value,
            "KHR_materials_ior",
            json!({ "ior": number(ior) }),
        );
        let transmission = json!({ "transmissionFactor": 1.0 });
        self.extend(&mut value, "KHR_materials_transmission", transmission);
        let volume = json!({ "thicknessFactor": 0.01 });
        self.extend(&mut value, "KHR_materials_volume", volume);
        value
    }

    /// A mixture by textures of color, roughness and metallicity. The index of refraction is that
    /// of the first part.
    fn mixed(&mut self, scene: &Scene, name: &str, parts: [Opaque<'_>; 2], weight: &str) -> Value {
        let image = |name: &str| scene.textures.iter().find(|(known, _)| *known == name);
        let Some((_, weight)) = image(weight) else {
            return self.opaque(&parts[0]);
        };
        let color = |part: &Opaque<'_>, u: f64, v: f64| {
            let texel = part
                .texture
                .and_then(image)
                .map_or([1.0; 3], |(_, image)| image.value(u, v));
            std::array::from_fn(|c| texel[c] * part.color[c])
        };
        let mix = |a: f64, b: f64, u: f64, v: f64| a + (b - a) * weight.value(u, v)[0];
        let [a, b] = &parts;
        let size = parts
            .iter()
            .filter_map(|part| image(part.texture?))
            .map(|(_, image)| image.size)
            .chain([weight.size])
            .max()
            .unwrap_or(weight.size);
        let colors = PngImage::from_colors(size, |u, v| {
            let (a, b): ([f64; 3], [f64; 3]) = (color(a, u, v), color(b, u, v));
            std::array::from_fn(|c| mix(a[c], b[c], u, v))
        });
        let finish = PngImage::from_values(size, |u, v| {
            let roughness = mix(a.roughness, b.roughness, u, v);
            [0.0, roughness, mix(a.metallic, b.metallic, u, v)]
        });
        let mut value = self.opaque(&Opaque {
            color: [1.0; 3],
            metallic: 1.0,
            roughness: 1.0,
            ..*a
        });
        self.images.push((format!("{name}_color"), colors));
        self.images.push((format!("{name}_finish"), finish));
        let first = self.images.len() - 2;
        let textures = &mut value["pbrMetallicRoughness"];
        textures["baseColorTexture"] = json!({ "index": first });
        textures["metallicRoughnessTexture"] = json!({ "index": first + 1 });
        value
    }

    /// Index of a texture of the scene, added at its first use.
    fn image(&mut self, name: &str, scene: &Scene) -> usize {
        if let Some(known) = self.images.iter().position(|(known, _)| known == name) {
            return known;
        }
        let image = scene.textures.iter().find(|(known, _)| *known == name);
        self.images
            .extend(image.map(|(name, image)| ((*name).to_owned(), image.clone())));
        self.images.len() - 1
    }

    /// Adds the emission of `radiance` in W/(m² sr).
    fn emit(&mut self, value: &mut Value, radiance: LinearRgb) {
        let strength = radiance.into_iter().fold(0.0, f64::max);
        if strength <= 0.0 {
            return;
        }
        value["emissiveFactor"] = radiance.map(|v| number(v / strength)).to_vec().into();
        let strength = json!({ "emissiveStrength": number(strength) });
        self.extend(value, "KHR_materials_emissive_strength", strength);
    }

    fn extend(&mut self, material: &mut Value, name: &'static str, content: Value) {
        if material["extensions"].is_null() {
            material["extensions"] = json!({});
        }
        material["extensions"][name] = content;
        self.extensions.push(name);
    }
}

/// The parameters of a material that is neither glass nor a mixture.
fn opaque(material: &Material) -> Opaque<'_> {
    let base = |reflectance: &'_ Reflectance| match reflectance {
        Reflectance::Uniform(color) => (*color, None),
        Reflectance::Texture(name) => ([1.0; 3], Some(*name)),
    };
    match material {
        Material::Diffuse(reflectance) => {
            let (color, texture) = base(reflectance);
            Opaque {
                color,
                texture,
                metallic: 0.0,
                roughness: 1.0,
                ior: None,
            }
        }
        Material::Coated {
            base: under,
            alpha,
            ior,
        } => {
            let (color, texture) = base(under);
            let factor = Coat::new(*alpha, *ior).gltf_factor();
            Opaque {
                color: color.map(|v| v * factor),
                texture,
                metallic: 0.0,
                roughness: alpha.sqrt(),
                ior: Some(*ior),
            }
        }
        Material::Metal { metal, alpha, tint } => {
            let reflectance = metal.reflectance();
            Opaque {
                color: std::array::from_fn(|c| reflectance[c] * tint[c]),
                texture: None,
                metallic: 1.0,
                roughness: alpha.sqrt(),
                ior: Some(DEFAULT_IOR),
            }
        }
        // Parts of mixtures are opaque in all scenes; these would be white.
        Material::Glass { .. } | Material::Mixed { .. } => Opaque {
            color: [1.0; 3],
            texture: None,
            metallic: 0.0,
            roughness: 1.0,
            ior: Some(DEFAULT_IOR),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Metal, coated, coated_texture, glass, matte, metal};
    use crate::testing::small_scene;

    fn added(material: Material, emission: Option<LinearRgb>) -> (Value, MaterialList) {
        let mut scene = small_scene();
        scene.add_texture("wood", PngImage::from_colors([2, 2], |u, v| [u, v, 0.5]));
        scene.add_texture("wear", PngImage::from_weights([2, 2], |u, _| u));
        let id = scene.add_material("new", material);
        let mut list = MaterialList::default();
        let index = list.add(&scene, id, emission);
        assert_eq!(list.add(&scene, id, emission), index);
        (list.materials[index].clone(), list)
    }

    #[test]
    fn matte_reflects_like_lambert_and_metals_by_their_reflectance() {
        let (value, _) = added(matte([0.5, 0.25, 0.125]), None);
        assert_eq!(
            value["extensions"]["KHR_materials_specular"]["specularFactor"],
            json!(0.0)
        );
        let (value, _) = added(metal(Metal::Copper, 0.16), None);
        let color = value["pbrMetallicRoughness"]["baseColorFactor"][0]
            .as_f64()
            .unwrap();
        assert!(color > 0.94 && color < 0.97, "{color}");
        assert_eq!(value["pbrMetallicRoughness"]["roughnessFactor"], json!(0.4));
    }

    #[test]
    fn lamps_emit_their_radiance() {
        let (value, list) = added(matte([0.0; 3]), Some([4.0, 2.0, 1.0]));
        assert_eq!(value["emissiveFactor"], json!([1.0, 0.5, 0.25]));
        let strength = &value["extensions"]["KHR_materials_emissive_strength"];
        assert_eq!(strength["emissiveStrength"], json!(4.0));
        assert!(list.extensions.contains(&"KHR_materials_emissive_strength"));
    }

    #[test]
    fn glass_is_solid_and_coats_keep_their_textures() {
        let (value, _) = added(glass(), None);
        assert!(
            value["extensions"]["KHR_materials_volume"]["thicknessFactor"].as_f64() > Some(0.0)
        );
        let (value, list) = added(coated_texture("wood", 0.25), None);
        assert_eq!(
            value["pbrMetallicRoughness"]["baseColorTexture"]["index"],
            json!(0)
        );
        let factor = value["pbrMetallicRoughness"]["baseColorFactor"][0]
            .as_f64()
            .unwrap();
        assert!(factor > 0.6 && factor < 0.8, "{factor}");
        assert_eq!(list.images[0].0, "wood");
    }

    #[test]
    fn mixtures_are_mixed_in_textures() {
        let (value, list) = added(
            Material::Mixed {
                first: Box::new(coated([0.8; 3], 0.25)),
                second: Box::new(metal(Metal::Silver, 0.01)),
                weight: "wear",
            },
            None,
        );
        assert_eq!(
            value["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"],
            json!(1)
        );
        let [_, roughness, metallic] = list.images[1].1.value(0.75, 0.5);
        assert!((metallic - 0.75).abs() < 5e-3, "{metallic}");
        assert!(
            (roughness - (0.25 * 0.5 + 0.75 * 0.1)).abs() < 5e-3,
            "{roughness}"
        );
    }
}
