//! Materials. Surfaces that do not transmit light scatter it on both sides, as in PBRT.

mod conductors;
mod roughness;
mod sums;
mod v3;

use super::super::assets::Channel;
use super::super::description::{Additions, WHITE, add_two_sided, bitmap, flip_v, scaled};
use super::super::parameters::{Numbers, Parameters, unresolved};
use super::super::sink::{Problem, Text};
use super::bindings::{NameSpace, Place};
use super::builder::Builder;
use super::colors::ColorUse;
use super::entities::{Entity, MaterialRef};
use super::param_types::{ParamType, Values};
use crate::image::Transfer;
use manylight::bsdf::Material;
use manylight::bsdf::material::{Bitangent, ColorShift};
use manylight::color::Rgb;
use manylight::ids::{MaterialId, TextureId};
use manylight::texture::{ColorInput, Filtering, FloatInput, Wrap};
pub(super) use v3::is_v3_material;

pub(super) const SUPPORTED: &[&str] = &[
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "interface",
    "mix",
    "thindielectric",
];

/// Plugins that are replaced, and by what.
const SUBSTITUTES: [(&str, &str); 3] = [
    ("hair", "it is replaced by diffuse of its color"),
    ("measured", "it is replaced by gray diffuse"),
    ("subsurface", "it is replaced by `coateddiffuse`"),
];

/// Whether only PBRT v4 has a material with this name.
pub(super) fn is_v4_material(name: &str) -> bool {
    name != "mix" && SUPPORTED.contains(&name)
}

impl Builder<'_> {
    /// A material that scatters on both sides.
    fn both_sides(&mut self, material: Material) -> MaterialId {
        let inner = self.desc.add(material);
        add_two_sided(&mut self.desc.materials, inner)
    }

    /// Diffuse on both sides.
    pub(super) fn diffuse(&mut self, reflectance: ColorInput) -> MaterialId {
        self.both_sides(Material::Diffuse { reflectance })
    }

    /// The id of a material, which is reserved if the material is defined later.
    pub(super) fn resolve_material(&mut self, material: &MaterialRef) -> MaterialId {
        match material {
            MaterialRef::Default => self.diffuse_default(),
            MaterialRef::Index(index) => self.made.materials[*index],
            MaterialRef::Named(name, place) => self.named_material(name, *place),
        }
    }

    /// The material that `name` has at `place`.
    fn named_material(&mut self, name: &Text, place: Place) -> MaterialId {
        let known = &self.made.material_names;
        let index = self.definition(NameSpace::Material, name, place, known);
        let found = index.and_then(|index| self.made.named_materials.get(index));
        if let Some(Some(material)) = found {
            if self.made.textured.contains(material) {
                self.note_texture();
            }
            return *material;
        }
        // Old files name the absence of a material in this way.
        if name.value.is_empty() || name.value == "none" {
            return self.clear();
        }
        let message = format!("no material has the name `{}`", name.value);
        let known = known.keys().map(String::as_str);
        self.sink.error(unresolved(name, message, known));
        self.diffuse_default()
    }

    /// The material of shapes without one.
    fn diffuse_default(&mut self) -> MaterialId {
        if let Some(material) = self.made.default_material {
            return material;
        }
        let material = self.diffuse(ColorInput::Constant(Rgb::splat(0.5)));
        self.made.default_material = Some(material);
        material
    }

    /// No surface.
    pub(super) fn clear(&mut self) -> MaterialId {
        self.desc.add(Material::Null)
    }

    /// Adds a material: the plugin `kind` with the parameters of `entity`.
    pub(super) fn material(&mut self, entity: &Entity<'_>, kind: &Text) -> MaterialId {
        let uses = self.texture_uses.get();
        let material = match kind.value.as_str() {
            "diffuse" => {
                let reflectance = self.reflectance(entity, "reflectance", 0.5);
                self.diffuse(reflectance)
            }
            "conductor" => {
                let material = self.conductor(entity, "");
                self.both_sides(material)
            }
            "coateddiffuse" => {
                let material = self.coated_diffuse(entity);
                self.both_sides(material)
            }
            "coatedconductor" => self.coated_conductor(entity),
            "dielectric" => {
                let roughness = self.roughness(entity, "", 0.0);
                let eta = self.eta(entity, "eta", 1.5);
                self.desc.add(Material::Dielectric {
                    eta,
                    specular_reflectance: WHITE,
                    specular_transmittance: WHITE,
                    roughness,
                })
            }
            "thindielectric" => {
                let eta = self.eta(entity, "eta", 1.5);
                self.desc.add(Material::ThinDielectric {
                    eta,
                    specular_reflectance: WHITE,
                    specular_transmittance: WHITE,
                    roughness: None,
                })
            }
            "diffusetransmission" => self.diffuse_transmission(entity),
            "mix" => self.mix(entity),
            "interface" | "none" | "" => self.clear(),
            _ => self.other_material(entity, kind),
        };
        let material = self.with_relief(entity, material);
        entity.params.finish(self.is_v3);
        if self.texture_uses.get() != uses {
            self.made.textured.insert(material);
        }
        material
    }

    /// A reflectance or transmittance.
    fn reflectance(&mut self, entity: &Entity<'_>, name: &'static str, default: f32) -> ColorInput {
        self.color_input(entity, name, ColorUse::Reflectance)
            .unwrap_or(ColorInput::Constant(Rgb::splat(default)))
    }

    /// An index of refraction. Spectra are replaced by their luminance.
    fn eta(&mut self, entity: &Entity<'_>, name: &'static str, default: f32) -> f32 {
        let params = &entity.params;
        let Some(param) = params.get(name) else {
            return default;
        };
        let eta = match param.ty {
            ParamType::Texture => {
                let message = format!(
                    "a texture for `{name}` of {} is not supported; {default} is used",
                    params.describe()
                );
                self.sink.unsupported("textured eta", param.span, message);
                Some(default)
            }
            ParamType::Float => params.maybe_float(name),
            _ => {
                let color = entity.color(name, ColorUse::Coefficient);
                color.map(|color| color.luminance())
            }
        };
        match eta {
            Some(eta) if eta > 0.0 => eta,
            Some(_) => {
                params.refuse(param, "positive");
                default
            }
            None => default,
        }
    }

    fn coated_diffuse(&mut self, entity: &Entity<'_>) -> Material {
        self.ignore_layers(entity);
        let diffuse_reflectance = self.reflectance(entity, "reflectance", 0.5);
        let eta = self.eta(entity, "eta", 1.5);
        let roughness = self.roughness(entity, "", 0.0);
        let roughness = roughness.map(|rough| self.constant_roughness(entity, &rough));
        Material::Plastic {
            eta,
            diffuse_reflectance,
            specular_reflectance: WHITE,
            color_shift: ColorShift::Nonlinear,
            roughness,
        }
    }

    /// Parameters of the random walk between two layers. Their medium is left out.
    fn ignore_layers(&self, entity: &Entity<'_>) {
        let params = &entity.params;
        params.ignore(&["thickness", "maxdepth", "nsamples", "g"]);
        if let Some(param) = params.get("albedo") {
            let object = params.describe();
            let message = format!("the medium between the layers of {object} is ignored");
            self.sink
                .unsupported("medium between layers", param.name.span, message);
        }
    }

    fn diffuse_transmission(&mut self, entity: &Entity<'_>) -> MaterialId {
        let reflectance = self.reflectance(entity, "reflectance", 0.25);
        let transmittance = self.reflectance(entity, "transmittance", 0.25);
        let scale = entity.params.float("scale", 1.0);
        let reflectance = scaled(&mut self.desc.textures, reflectance, scale);
        let transmittance = scaled(&mut self.desc.textures, transmittance, scale);
        self.transmitting_diffuse(reflectance, transmittance)
    }

    /// Diffuse reflection and transmission: a blend, in which each part has half of the weight and
    /// thus twice its value.
    fn transmitting_diffuse(
        &mut self,
        reflectance: ColorInput,
        transmittance: ColorInput,
    ) -> MaterialId {
        let reflectance = scaled(&mut self.desc.textures, reflectance, 2.0);
        let first = self.diffuse(reflectance);
        let transmittance = scaled(&mut self.desc.textures, transmittance, 2.0);
        let second = self.desc.add(Material::DiffuseTransmitter {
            transmittance,
            below: None,
        });
        self.blend(FloatInput::Constant(0.5), first, second)
    }

    /// A mixture, in which the second material has this weight.
    fn blend(&mut self, weight: FloatInput, first: MaterialId, second: MaterialId) -> MaterialId {
        let blend = Material::Blend {
            weight,
            first,
            second,
        };
        self.desc.add(blend)
    }

    /// The material with straight-through transmission, by `opacity`.
    pub(super) fn masked(&mut self, inner: MaterialId, opacity: FloatInput) -> MaterialId {
        if opacity == FloatInput::Constant(1.0) {
            return inner;
        }
        self.desc.add(Material::Mask { opacity, inner })
    }

    fn mix(&mut self, entity: &Entity<'_>) -> MaterialId {
        let params = &entity.params;
        let (names, amount_of_first) = if params.has("namedmaterial1") {
            let name = |name| params.string(name).cloned();
            ([name("namedmaterial1"), name("namedmaterial2")], true)
        } else {
            let names = params.strings("materials").unwrap_or_default();
            if names.len() != 2 {
                match params.get("materials") {
                    Some(param) => params.refuse(param, "two names of materials"),
                    None => params.missing("materials"),
                }
                return self.diffuse_default();
            }
            ([names.first().cloned(), names.last().cloned()], false)
        };
        let [first, second] = names.map(|name| match name {
            Some(name) => self.named_material(&name, entity.place),
            None => self.diffuse_default(),
        });
        if amount_of_first || self.is_v3 {
            return self.v3_mix(entity, first, second);
        }
        let weight = self.float_input(entity, "amount", 0.5);
        self.blend(weight, first, second)
    }

    /// Materials of PBRT v3, substitutes, and unknown ones, which are reported.
    fn other_material(&mut self, entity: &Entity<'_>, kind: &Text) -> MaterialId {
        if is_v3_material(&kind.value) {
            return self.v3_material(entity, kind);
        }
        let params = &entity.params;
        let Some((name, what)) = SUBSTITUTES.iter().find(|(name, _)| *name == kind.value) else {
            let others = SUBSTITUTES.iter().map(|(name, _)| *name);
            let known = SUPPORTED.iter().copied().chain(others).chain(v3::names());
            self.unknown_name("material", kind, known);
            params.ignore_all();
            return self.diffuse_default();
        };
        let message = format!("material `{name}` is not supported; {what}");
        let problem = Problem::new("scene::unsupported", kind.span, message);
        self.sink
            .warn_once(format!("material {name}"), problem.label("not supported"));
        let material = match *name {
            "subsurface" => {
                let material = self.coated_diffuse(entity);
                self.both_sides(material)
            }
            "hair" => {
                // The color of dark blond hair, as a substitute of absorption coefficients.
                let brown = ColorInput::Constant(Rgb::new(0.3, 0.2, 0.12));
                let color = self.color_input(entity, "color", ColorUse::Reflectance);
                self.diffuse(color.unwrap_or(brown))
            }
            _ => self.diffuse_default(),
        };
        params.ignore_all();
        material
    }

    /// The material with its normal map or bump map.
    fn with_relief(&mut self, entity: &Entity<'_>, inner: MaterialId) -> MaterialId {
        let mut material = inner;
        let params = &entity.params;
        if let Some(name) = params.string("normalmap")
            && let Some(texture) = self.normal_map(entity, name)
        {
            material = self.desc.add(Material::NormalMap {
                texture,
                scale: 1.0,
                bitangent: Bitangent::RightHanded,
                inner: material,
            });
        }
        for name in ["displacement", "bumpmap"] {
            let Some(param) = params.get(name) else {
                continue;
            };
            if let (Values::Strings(_), Some(FloatInput::Texture(texture))) =
                (&param.values, self.maybe_float_input(entity, name))
            {
                material = self.desc.add(Material::BumpMap {
                    texture,
                    scale: 1.0,
                    inner: material,
                });
            }
        }
        material
    }

    fn normal_map(&mut self, entity: &Entity<'_>, name: &Text) -> Option<TextureId> {
        let path = entity.find_file(name, "normal map")?;
        let map = bitmap(Filtering::Bilinear, [Wrap::Repeat; 2], flip_v());
        let texture = self.desc.add(map);
        self.note_texture();
        self.assets
            .add_texture_image(texture, path, Transfer::Raw, Channel::All, name.span);
        Some(texture)
    }
}
