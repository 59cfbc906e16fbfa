//! Materials: the metallic-roughness model, mapped to the principled model of the renderer.
//!
//! | glTF | here |
//! |---|---|
//! | base color, metallic, roughness | the parameters of the same names; alpha = roughness², with the layers of glTF |
//! | F0 by ior and specular | eta with this reflectance |
//! | alpha mode | a mask |
//! | emission | an area emitter, which the mesh refers to |
//!
//! `scattering` puts the scattering models together.

use super::super::description::{add, add_front_alone, add_two_sided, as_float};
use super::super::names::name_material;
use super::super::options::GltfOptions;
use super::super::parameters::Numbers;
use super::document::Document;
use super::extensions::Lobes;
use super::glass::absorption_coefficient;
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader, reflectance};
use super::scattering::{Surfaces, principled};
use super::specular_glossiness::specular_glossiness;
use super::textures::{Bitangents, Textures, VertexInputs};
use crate::suggest::with_list;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::scene::MediumDesc;
use manylight::texture::{ColorInput, FloatInput};
use std::collections::HashMap;

/// No light.
const BLACK: ColorInput = ColorInput::Constant(Rgb::BLACK);

/// The materials of a scene, made when a mesh needs them.
#[derive(Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    /// Names, by the same indices.
    pub(super) names: Vec<String>,
    pub(super) textures: Textures,
    /// Materials without vertex attributes, which meshes share: by index, primary set of texture
    /// coordinates, bits of the scale, whether the mesh is a body, and the sign of the bitangents.
    shared: HashMap<(Option<usize>, usize, u32, bool, u32), SurfaceMaterial>,
    /// Absorption coefficients inside of bodies, in 1/m.
    absorption: HashMap<MaterialId, Rgb>,
}

/// What a surface is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMaterial {
    pub(super) id: MaterialId,
    /// The material of the second surface of one that emits on both sides, which is turned over.
    pub(super) back: MaterialId,
    /// Radiance in W/(m² sr); `None` if it does not emit.
    pub(super) radiance: Option<ColorInput>,
    /// Whether it emits on both sides.
    pub(super) double_sided: bool,
    /// Whether its opacity is 1.
    pub(super) is_opaque: bool,
    /// Absorption coefficient inside, in 1/m.
    absorption: Option<Rgb>,
}

impl Materials {
    /// The material of this index for a mesh with these vertices; `None`: the default of glTF.
    pub(super) fn material(
        &mut self,
        document: &Document<'_>,
        index: Option<usize>,
        vertices: &VertexInputs<'_>,
    ) -> SurfaceMaterial {
        let signs = match vertices.bitangents {
            Bitangents::ByTextureCoordinates => Some(0),
            Bitangents::OneSign(sign) => Some(sign.to_bits()),
            Bitangents::Signs(_) => None,
        };
        let is_shared = vertices.colors.is_empty() && vertices.uvs.is_empty() && signs.is_some();
        let key = (
            index,
            vertices.primary,
            vertices.scale.to_bits(),
            vertices.is_body,
            signs.unwrap_or_default(),
        );
        if let Some(material) = self.shared.get(&key).filter(|_| is_shared) {
            return *material;
        }
        let material = match index {
            Some(index) => MaterialReader {
                document,
                json: &document.materials[index],
                vertices,
                list: &mut self.list,
                bitangent: self.textures.bitangent(vertices),
                textures: &mut self.textures,
            }
            .surface(),
            None => self.default_material(vertices),
        };
        if let Some(absorption) = material.absorption {
            self.absorption.insert(material.id, absorption);
        }
        if let Some(index) = index {
            let name = document.materials[index].string("name");
            let name = name.map_or_else(|| format!("material_{index}"), str::to_owned);
            name_material(&mut self.names, material.id, &name);
        }
        if is_shared {
            self.shared.insert(key, material);
        }
        material
    }

    /// The media inside of bodies, in the order of materials.
    pub(super) fn media(&self) -> Vec<MediumDesc> {
        let absorption = self.absorption.iter();
        let mut media: Vec<MediumDesc> = absorption
            .map(|(&material, &absorption)| MediumDesc {
                material,
                absorption,
            })
            .collect();
        media.sort_unstable_by_key(|medium| medium.material);
        media
    }

    /// The default of the specification.
    fn default_material(&mut self, vertices: &VertexInputs<'_>) -> SurfaceMaterial {
        let mut base = Base::default();
        if let Some(color) = self.textures.vertex_color(vertices) {
            base.color = color;
        }
        let inner = add(
            &mut self.list,
            principled(&base, &Lobes::default(), FloatInput::Constant(1.0)),
        );
        let id = add_two_sided(&mut self.list, inner);
        SurfaceMaterial {
            id,
            back: id,
            radiance: None,
            double_sided: false,
            is_opaque: true,
            absorption: None,
        }
    }
}

impl<'a> MaterialReader<'a, '_> {
    fn surface(mut self) -> SurfaceMaterial {
        let mode = self.json.string("alphaMode").unwrap_or("OPAQUE");
        let base = self.base(mode);
        let is_unlit = self.json.extension("KHR_materials_unlit").is_some();
        let radiance = match is_unlit {
            true => Some(base.color),
            false => self.radiance(),
        };
        let opacity = as_float(base.opacity);
        let radiance = radiance
            .map(|radiance| self.textures.faded_radiance(radiance, opacity))
            .filter(|radiance| *radiance != BLACK);
        let double_sided = is_unlit || self.json.boolean("doubleSided");
        let surfaces = match double_sided && radiance.is_some() {
            true => Surfaces::BackToBack,
            false => Surfaces::One,
        };
        let [front, back] = match is_unlit {
            true => [self.unlit(); 2],
            false => self.scattering(&base, surfaces),
        };
        let mut masked = |inner| self.masked(inner, opacity, surfaces);
        SurfaceMaterial {
            id: masked(front),
            back: masked(back),
            radiance,
            double_sided,
            is_opaque: opacity == FloatInput::Constant(1.0),
            absorption: absorption_coefficient(self.json, self.vertices).filter(|_| !is_unlit),
        }
    }

    /// Base color, opacity, metallic and roughness.
    fn base(&mut self, mode: &str) -> Base {
        let mut base = match self.json.extension("KHR_materials_pbrSpecularGlossiness") {
            Some(extension) => specular_glossiness(self, &extension, mode),
            None => self.metallic_roughness(mode),
        };
        let textures = &mut self.textures;
        if let Some(color) = textures.vertex_color(self.vertices) {
            base.color = textures.product(base.color, color);
        }
        if mode == "BLEND"
            && let Some(opacity) = textures.vertex_opacity(self.vertices)
        {
            base.opacity = textures.product(base.opacity, opacity);
        }
        base
    }

    fn metallic_roughness(&mut self, mode: &str) -> Base {
        let Some(json) = self.json.member("pbrMetallicRoughness") else {
            return Base::default();
        };
        let [r, g, b, a] = json.floats("baseColorFactor", [1.0; 4]);
        let color = self.color(&json, "baseColorTexture", reflectance([r, g, b]));
        let opacity = self.opacity(&json, "baseColorTexture", a, mode);
        let roughness_factor = json.fraction("roughnessFactor", 1.0);
        let metallic_factor = json.fraction("metallicFactor", 1.0);
        let name = "metallicRoughnessTexture";
        let mut scaled = |factor: f32, channel: usize| {
            let texture = match factor {
                0.0 => None,
                _ => self.texture(&json, name, Content::Channel(channel)),
            };
            self.textures.scaled(factor, texture)
        };
        Base {
            color,
            opacity,
            roughness: scaled(roughness_factor, 1),
            metallic: scaled(metallic_factor, 2),
            f0: None,
        }
    }

    /// The material with its opacity.
    fn masked(&mut self, inner: MaterialId, opacity: FloatInput, surfaces: Surfaces) -> MaterialId {
        if opacity == FloatInput::Constant(1.0) {
            return inner;
        }
        let masked = add(self.list, Material::Mask { opacity, inner });
        match surfaces {
            Surfaces::One => masked,
            Surfaces::BackToBack => add_front_alone(self.list, masked),
        }
    }

    /// Emitted radiance in W/(m² sr); `None` if it is black.
    fn radiance(&mut self) -> Option<ColorInput> {
        let json = self.json;
        let factor = json.floats("emissiveFactor", [0.0; 3]);
        if let Some(negative) = factor.iter().find(|v| **v < 0.0) {
            json.unexpected("emissiveFactor", negative, "at least 0");
            return None;
        }
        let strength = json
            .extension("KHR_materials_emissive_strength")
            .map_or(1.0, |extension| {
                extension.float_where("emissiveStrength", 1.0, |v| v >= 0.0, "at least 0")
            });
        let factor = Rgb::from(factor) * strength;
        (!factor.is_black()).then(|| self.color(json, "emissiveTexture", factor))
    }

    /// A surface that shows its base color whatever light falls on it: an emitter that reflects
    /// nothing.
    fn unlit(&mut self) -> MaterialId {
        self.json.warn_once(
            "unlit",
            "unlit materials (KHR_materials_unlit) are replaced by emission of their base color, which lights other surfaces too",
        );
        let reflectance = BLACK;
        add(self.list, Material::Diffuse { reflectance })
    }
}

/// The index of the variant that the options name; `None` for the materials of the meshes. Unknown
/// names are reported.
pub(super) fn chosen_variant(root: &Json<'_>, options: &GltfOptions) -> Option<usize> {
    let wanted = options.variant.as_deref()?;
    let variants = root
        .extension("KHR_materials_variants")
        .map_or_else(Vec::new, |extension| extension.objects("variants"));
    let names: Vec<&str> = variants
        .iter()
        .map(|variant| variant.string("name").unwrap_or_default())
        .collect();
    let found = names.iter().position(|name| *name == wanted);
    if found.is_none() {
        let known = match names.as_slice() {
            [] => "the file has no variants".to_owned(),
            names => format!("variants of the file: {}", names.join(", ")),
        };
        let help = with_list(wanted, names.iter().copied(), known);
        let message = format!("the file has no material variant `{wanted}`");
        let reporter = root.reporter();
        reporter.error_with_help("/extensions/KHR_materials_variants", &message, help);
    }
    found
}

/// The index of the material of a primitive, by the extension KHR_materials_variants.
pub(super) fn material_of(
    primitive: &Json<'_>,
    variant: Option<usize>,
    count: usize,
) -> Option<usize> {
    let mappings = variant
        .and_then(|_| primitive.extension("KHR_materials_variants"))
        .map_or_else(Vec::new, |extension| extension.objects("mappings"));
    let is_chosen = |mapping: &&Json<'_>| {
        let variants = mapping.items("variants");
        let mut indices = variants.iter().filter_map(Json::as_unsigned);
        indices.any(|index| Some(index as usize) == variant)
    };
    match mappings.iter().find(is_chosen) {
        Some(mapping) => mapping.index("material", "materials", count),
        None => primitive.index("material", "materials", count),
    }
}
