//! Materials: the metallic-roughness model, mapped to the principled model of the renderer.
//!
//! | glTF | here |
//! |---|---|
//! | base color, metallic, roughness | the parameters of the same names; alpha = roughness², `layered` |
//! | F0 by ior and specular | eta with this reflectance |
//! | normal texture | a normal map with the tangents of MikkTSpace |
//! | alpha mode | a mask |
//! | emission | an area emitter, which the mesh refers to |
//!
//! `extensions` reads the lobes and interfaces of the KHR_materials extensions.

use super::super::names::name_material;
use super::document::Document;
use super::extensions::{Glass, Lobes};
use super::images::Content;
use super::json::Json;
use super::textures::{Textures, VertexInputs, as_float};
use manylight::bsdf::material::PrincipledMaterial;
use manylight::bsdf::{Bitangent, Material};
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};
use std::collections::HashMap;

/// The materials of a scene, made when a mesh needs them.
#[derive(Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    /// Names, by the same indices.
    pub(super) names: Vec<String>,
    pub(super) textures: Textures,
    /// Materials without vertex attributes, which meshes share: by index and primary set of texture coordinates.
    shared: HashMap<(Option<usize>, usize), SurfaceMaterial>,
}

/// What a surface is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMaterial {
    pub(super) id: MaterialId,
    /// Radiance in W/(m² sr); `None` if it does not emit.
    pub(super) radiance: Option<ColorInput>,
    /// Whether it emits on both sides.
    pub(super) double_sided: bool,
}

/// Base color and its parameters before extensions change them.
pub(super) struct Base {
    pub(super) color: ColorInput,
    pub(super) opacity: ColorInput,
    pub(super) metallic: FloatInput,
    pub(super) roughness: FloatInput,
    pub(super) roughness_factor: f32,
    /// Whether roughness is textured.
    pub(super) has_roughness_texture: bool,
    /// Reflectance of the dielectric at normal incidence, if the workflow gives it.
    pub(super) f0: Option<f32>,
}

impl Materials {
    fn add(&mut self, material: Material) -> MaterialId {
        self.list.push(material);
        MaterialId::from(self.list.len() - 1)
    }

    /// The material of this index for a mesh with these vertices; `None`: the default of glTF.
    pub(super) fn material(
        &mut self,
        document: &Document<'_>,
        index: Option<usize>,
        vertices: &VertexInputs<'_>,
    ) -> SurfaceMaterial {
        let is_shared = vertices.colors.is_empty() && vertices.uvs.is_empty();
        let key = (index, vertices.primary);
        if let Some(material) = self.shared.get(&key).filter(|_| is_shared) {
            return *material;
        }
        let material = match index {
            Some(index) => MaterialReader {
                document,
                json: &document.materials[index],
                vertices,
                materials: self,
            }
            .surface(),
            None => self.default_material(vertices),
        };
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

    /// White metal of roughness 1: the defaults of the specification.
    fn default_material(&mut self, vertices: &VertexInputs<'_>) -> SurfaceMaterial {
        let color = self.textures.vertex_color(vertices);
        let base = Base {
            color: color.unwrap_or(ColorInput::Constant(Rgb::WHITE)),
            opacity: ColorInput::Constant(Rgb::WHITE),
            metallic: FloatInput::Constant(1.0),
            roughness: FloatInput::Constant(1.0),
            roughness_factor: 1.0,
            has_roughness_texture: false,
            f0: None,
        };
        let principled = principled(&base, &Lobes::default());
        let inner = self.add(principled);
        SurfaceMaterial {
            id: self.two_sided(inner),
            radiance: None,
            double_sided: false,
        }
    }

    /// The material on both sides of a surface.
    fn two_sided(&mut self, inner: MaterialId) -> MaterialId {
        self.add(Material::TwoSided {
            front: inner,
            back: inner,
        })
    }
}

/// The opaque part of a material.
fn principled(base: &Base, lobes: &Lobes) -> Material {
    let constant = FloatInput::Constant;
    Material::Principled(Box::new(PrincipledMaterial {
        base_color: base.color,
        roughness: lobes.roughness.unwrap_or(base.roughness),
        anisotropic: constant(lobes.anisotropic),
        metallic: base.metallic,
        spec_trans: constant(0.0),
        eta: eta_of_reflectance(base.f0.unwrap_or(lobes.f0)),
        spec_tint: constant(0.0),
        sheen: constant(lobes.sheen),
        sheen_tint: constant(0.0),
        flatness: constant(0.0),
        clearcoat: lobes.clearcoat,
        clearcoat_gloss: constant(lobes.clearcoat_gloss),
        layered: true,
        diffuse_reflectance_sampling_rate: 1.0,
        main_specular_sampling_rate: 1.0,
        clearcoat_sampling_rate: 1.0,
    }))
}

/// The index of refraction with the reflectance `f0` at normal incidence.
fn eta_of_reflectance(f0: f32) -> f32 {
    /// Largest reflectance of a dielectric here: that of an index of refraction of 199.
    const LARGEST: f32 = 0.98;
    /// Smallest index of refraction: an interface without reflection would have none.
    const SMALLEST_ETA: f32 = 1.001;
    let root = f0.clamp(0.0, LARGEST).sqrt();
    ((1.0 + root) / (1.0 - root)).max(SMALLEST_ETA)
}

/// Reads one material.
pub(super) struct MaterialReader<'a, 'm> {
    pub(super) document: &'m Document<'a>,
    pub(super) json: &'m Json<'a>,
    pub(super) vertices: &'m VertexInputs<'m>,
    pub(super) materials: &'m mut Materials,
}

impl<'a> MaterialReader<'a, '_> {
    /// The texture `name` of `json`.
    pub(super) fn texture(
        &mut self,
        json: &Json<'a>,
        name: &str,
        content: Content,
    ) -> Option<manylight::ids::TextureId> {
        let info = json.member(name)?;
        let textures = &mut self.materials.textures;
        textures.bitmap(self.document, &info, content, self.vertices)
    }

    /// A color factor times a texture of colors.
    pub(super) fn color(&mut self, json: &Json<'a>, texture: &str, factor: Rgb) -> ColorInput {
        let factor = ColorInput::Constant(factor);
        match self.texture(json, texture, Content::Color) {
            Some(id) => {
                let textures = &mut self.materials.textures;
                textures.product(factor, ColorInput::Texture(id))
            }
            None => factor,
        }
    }

    fn surface(mut self) -> SurfaceMaterial {
        let double_sided = self.json.boolean("doubleSided");
        let mode = self.json.string("alphaMode").unwrap_or("OPAQUE");
        let base = self.base(mode);
        if self.json.extension("KHR_materials_unlit").is_some() {
            return self.unlit(&base, mode);
        }
        let lobes = Lobes::read(&mut self, &base);
        let mut inner = self.materials.add(principled(&base, &lobes));
        inner = self.normal_mapped(inner);
        inner = self.materials.two_sided(inner);
        if let Some(glass) = Glass::read(&mut self, &base, lobes.ior) {
            inner = self.with_glass(inner, glass);
        }
        SurfaceMaterial {
            id: self.masked(inner, &base, mode),
            radiance: self.radiance(),
            double_sided,
        }
    }

    /// A mixture of an opaque material and glass.
    fn with_glass(&mut self, opaque: MaterialId, glass: Glass) -> MaterialId {
        let id = self.materials.add(glass.material);
        let second = self.normal_mapped(id);
        match glass.weight {
            FloatInput::Constant(1.0) => second,
            weight => self.materials.add(Material::Blend {
                weight,
                first: opaque,
                second,
            }),
        }
    }

    /// Base color, opacity, metallic and roughness.
    fn base(&mut self, mode: &str) -> Base {
        let mut base = match self.json.extension("KHR_materials_pbrSpecularGlossiness") {
            Some(extension) => self.specular_glossiness(&extension, mode),
            None => self.metallic_roughness(mode),
        };
        let textures = &mut self.materials.textures;
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
            let white = ColorInput::Constant(Rgb::WHITE);
            return Base {
                color: white,
                opacity: white,
                metallic: FloatInput::Constant(1.0),
                roughness: FloatInput::Constant(1.0),
                roughness_factor: 1.0,
                has_roughness_texture: false,
                f0: None,
            };
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
            self.materials.textures.scaled(factor, texture)
        };
        Base {
            color,
            opacity,
            roughness: scaled(roughness_factor, 1),
            metallic: scaled(metallic_factor, 2),
            roughness_factor,
            has_roughness_texture: json.has(name),
            f0: None,
        }
    }

    /// Opacity by the alpha mode; white for opaque materials.
    pub(super) fn opacity(
        &mut self,
        json: &Json<'a>,
        texture: &str,
        factor: f32,
        mode: &str,
    ) -> ColorInput {
        let visible = |is_visible: bool| {
            ColorInput::Constant(if is_visible { Rgb::WHITE } else { Rgb::BLACK })
        };
        match mode {
            "OPAQUE" => visible(true),
            "MASK" => {
                let cutoff = self.json.float("alphaCutoff", 0.5);
                match self.texture(json, texture, Content::CutOut { factor, cutoff }) {
                    Some(id) => ColorInput::Texture(id),
                    None => visible(factor >= cutoff),
                }
            }
            "BLEND" => {
                let texture = self.texture(json, texture, Content::Opacity);
                match self.materials.textures.scaled(factor, texture) {
                    FloatInput::Constant(v) => ColorInput::Constant(Rgb::splat(v)),
                    FloatInput::Texture(id) => ColorInput::Texture(id),
                }
            }
            other => {
                let message = format!("found `{other}`, expected `OPAQUE`, `MASK` or `BLEND`");
                self.json.error_at("alphaMode", message);
                visible(true)
            }
        }
    }

    /// The material with its opacity.
    fn masked(&mut self, inner: MaterialId, base: &Base, mode: &str) -> MaterialId {
        match (mode, base.opacity) {
            ("OPAQUE", _) | (_, ColorInput::Constant(Rgb::WHITE)) => inner,
            (_, opacity) => self.materials.add(Material::Mask {
                opacity: as_float(opacity),
                inner,
            }),
        }
    }

    /// The material in the frame of the normal texture.
    fn normal_mapped(&mut self, inner: MaterialId) -> MaterialId {
        let json = self.json;
        let Some(info) = json.member("normalTexture") else {
            return inner;
        };
        let Some(texture) = self.texture(json, "normalTexture", Content::Raw) else {
            return inner;
        };
        self.materials.add(Material::NormalMap {
            texture,
            scale: info.float("scale", 1.0),
            bitangent: Bitangent::AgainstV,
            inner,
        })
    }

    /// Emitted radiance in W/(m² sr); `None` if it is black.
    fn radiance(&mut self) -> Option<ColorInput> {
        let json = self.json;
        let factor = json.floats("emissiveFactor", [0.0; 3]);
        if let Some(negative) = factor.iter().find(|v| **v < 0.0) {
            json.error_at(
                "emissiveFactor",
                format!("found {negative}, expected at least 0"),
            );
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

    /// A surface that shows its base color whatever light falls on it: an emitter that reflects nothing.
    fn unlit(mut self, base: &Base, mode: &str) -> SurfaceMaterial {
        self.json.warn_once(
            "unlit",
            "unlit materials (KHR_materials_unlit) are replaced by emission of their base color, which lights other surfaces too",
        );
        let black = self.materials.add(Material::Diffuse {
            reflectance: ColorInput::Constant(Rgb::BLACK),
        });
        SurfaceMaterial {
            id: self.masked(black, base, mode),
            radiance: Some(base.color),
            double_sided: true,
        }
    }
}

/// A color factor of a reflectance, clamped to [0, 1].
pub(super) fn reflectance(factor: [f32; 3]) -> Rgb {
    Rgb::from(factor).map(|v| v.clamp(0.0, 1.0))
}
