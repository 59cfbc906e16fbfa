//! Materials of PBRT v3, each as the material that comes nearest. One warning names it.

use super::super::super::description::{Additions, WHITE, product};
use super::super::super::parameters::Parameters;
use super::super::super::sink::{Problem, Text};
use super::super::builder::Builder;
use super::super::entities::Entity;
use super::conductors::mirror;
use super::sums::{Part, is_black};
use manylight::bsdf::Material;
use manylight::bsdf::material::{
    ColorShift, OrenNayarVariant, PrincipledMaterial, PrincipledThinMaterial,
};
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

/// Index of refraction of PBRT v3's `plastic` and `translucent`.
const COAT_INDEX: f32 = 1.5;

/// Names that only PBRT v3 has, and what they become.
const MATERIALS: [(&str, &str); 11] = [
    ("disney", "the model of the same name"),
    ("fourier", "gray `diffuse`; its table is not read"),
    ("glass", "`dielectric`"),
    ("kdsubsurface", "`coateddiffuse`"),
    ("matte", "`diffuse`"),
    ("metal", "`conductor`"),
    ("mirror", "`conductor` of constant reflectance"),
    ("plastic", "the sum of `diffuse` and microfacets"),
    ("substrate", "the model of the same name"),
    (
        "translucent",
        "the sum of `diffusetransmission` and rough `dielectric`",
    ),
    (
        "uber",
        "the sum of `diffuse`, microfacets and smooth `dielectric`",
    ),
];

/// The names of [`MATERIALS`].
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    MATERIALS.iter().map(|(name, _)| *name)
}

/// Whether only PBRT v3 has a material with this name.
pub(in super::super) fn is_v3_material(name: &str) -> bool {
    names().any(|known| known == name)
}

impl Builder<'_> {
    /// Adds a material of PBRT v3.
    pub(super) fn v3_material(&mut self, entity: &Entity<'_>, kind: &Text) -> MaterialId {
        let name = kind.value.as_str();
        if let Some((_, what)) = MATERIALS.iter().find(|(known, _)| *known == name) {
            let message = format!("material `{name}` of PBRT v3 is read as {what}");
            let problem = Problem::new("scene::old_name", kind.span, message);
            self.sink.warn_once(format!("v3 material {name}"), problem);
        }
        match name {
            "matte" => self.matte(entity),
            "glass" => self.glass(entity),
            "metal" => {
                let roughness = self.facets(entity, 0.01);
                let mut metal = self.conductor(entity, "");
                if let Material::Conductor { roughness: own, .. } = &mut metal {
                    *own = Some(roughness);
                }
                self.both_sides(metal)
            }
            "mirror" => {
                let reflectance = self.reflectance(entity, "Kr", 0.9);
                self.both_sides(mirror(reflectance, None))
            }
            "plastic" => self.v3_plastic(entity),
            "uber" => self.uber(entity),
            "substrate" => self.substrate(entity),
            "translucent" => self.translucent(entity),
            "disney" => self.disney(entity),
            "kdsubsurface" => {
                let reflectance = self.reflectance(entity, "Kd", 0.5);
                entity.params.ignore_all();
                let material = self.coat(entity, reflectance, WHITE, 1.3, 0.0);
                self.both_sides(material)
            }
            _ => self.fourier(entity),
        }
    }

    /// A measured material. Its file must be there, as all files that a scene names.
    fn fourier(&mut self, entity: &Entity<'_>) -> MaterialId {
        if let Some(name) = entity.params.string("bsdffile") {
            entity.find_file(name, "table of the material");
        }
        entity.params.ignore_all();
        self.diffuse(ColorInput::Constant(Rgb::splat(0.5)))
    }

    fn matte(&mut self, entity: &Entity<'_>) -> MaterialId {
        let reflectance = self.reflectance(entity, "Kd", 0.5);
        match self.float_input(entity, "sigma", 0.0) {
            FloatInput::Constant(0.0) => self.diffuse(reflectance),
            FloatInput::Constant(degrees) => {
                let alpha = std::f32::consts::SQRT_2 * degrees.clamp(0.0, 90.0).to_radians();
                self.both_sides(Material::RoughDiffuse {
                    reflectance,
                    alpha: FloatInput::Constant(alpha),
                    variant: OrenNayarVariant::Qualitative,
                })
            }
            FloatInput::Texture(_) => self.diffuse(reflectance),
        }
    }

    fn glass(&mut self, entity: &Entity<'_>) -> MaterialId {
        let roughness = self.roughness(entity, "", 0.0);
        let index = self.eta(entity, "index", 1.5);
        let eta = self.eta(entity, "eta", index);
        let specular_reflectance = self.reflectance(entity, "Kr", 1.0);
        let specular_transmittance = self.reflectance(entity, "Kt", 1.0);
        self.desc.add(Material::Dielectric {
            eta,
            specular_reflectance,
            specular_transmittance,
            roughness,
        })
    }

    /// A coat of PBRT v3, whose base does not interreflect.
    fn coat(
        &mut self,
        entity: &Entity<'_>,
        base: ColorInput,
        specular: ColorInput,
        eta: f32,
        default_roughness: f32,
    ) -> Material {
        let roughness = self.roughness(entity, "", default_roughness);
        let roughness = roughness.map(|rough| self.constant_roughness(entity, &rough));
        Material::Plastic {
            eta,
            diffuse_reflectance: base,
            specular_reflectance: specular,
            color_shift: ColorShift::Linear,
            roughness,
        }
    }

    /// The diffuse part `Kd` and the microfacets `Ks` of a surface with the index `eta`.
    fn base_and_facets(&mut self, entity: &Entity<'_>, eta: f32) -> Vec<Part> {
        let base = self.reflectance(entity, "Kd", 0.25);
        let specular = self.reflectance(entity, "Ks", 0.25);
        let facets = self.facets(entity, 0.1);
        let mut parts = Vec::new();
        if !is_black(base) {
            parts.push(Part::reflecting(Material::Diffuse { reflectance: base }));
        }
        if !is_black(specular) {
            let facets = Self::dielectric_reflection(eta, specular, Some(facets));
            parts.push(Part::reflecting(facets));
        }
        parts
    }

    fn v3_plastic(&mut self, entity: &Entity<'_>) -> MaterialId {
        let parts = self.base_and_facets(entity, COAT_INDEX);
        self.sum(parts)
    }

    /// Diffuse part and microfacets, mirror reflection and refraction, all times the opacity.
    fn uber(&mut self, entity: &Entity<'_>) -> MaterialId {
        let index = self.eta(entity, "index", COAT_INDEX);
        let eta = self.eta(entity, "eta", index);
        let mut parts = self.base_and_facets(entity, eta);
        let reflection = self.reflectance(entity, "Kr", 0.0);
        let transmission = self.reflectance(entity, "Kt", 0.0);
        if !is_black(transmission) {
            parts.push(Part::transmitting(Material::Dielectric {
                eta,
                specular_reflectance: reflection,
                specular_transmittance: transmission,
                roughness: None,
            }));
        } else if !is_black(reflection) {
            let mirror = Self::dielectric_reflection(eta, reflection, None);
            parts.push(Part::reflecting(mirror));
        }
        self.with_opacity(entity, parts)
    }

    fn substrate(&mut self, entity: &Entity<'_>) -> MaterialId {
        let diffuse_reflectance = self.reflectance(entity, "Kd", 0.5);
        let specular_reflectance = self.reflectance(entity, "Ks", 0.5);
        let roughness = self.facets(entity, 0.1);
        self.both_sides(Material::Substrate {
            diffuse_reflectance,
            specular_reflectance,
            roughness,
        })
    }

    /// Diffuse and rough reflection, both times `reflect`, and the same of transmission.
    fn translucent(&mut self, entity: &Entity<'_>) -> MaterialId {
        let base = self.reflectance(entity, "Kd", 0.25);
        let specular = self.reflectance(entity, "Ks", 0.25);
        let facets = self.facets(entity, 0.1);
        let reflect = self.reflectance(entity, "reflect", 0.5);
        let transmit = self.reflectance(entity, "transmit", 0.5);
        let mut times = |a, b| product(&mut self.desc.textures, a, b);
        let reflectance = times(base, reflect);
        let transmittance = times(base, transmit);
        let [specular_reflectance, specular_transmittance] =
            [reflect, transmit].map(|factor| times(specular, factor));
        let mut parts = Vec::new();
        if !is_black(reflectance) {
            parts.push(Part::reflecting(Material::Diffuse { reflectance }));
        }
        if !is_black(transmittance) {
            let transmitter = Material::DiffuseTransmitter {
                transmittance,
                below: None,
            };
            parts.push(Part::transmitting(transmitter));
        }
        if !is_black(specular_transmittance) {
            parts.push(Part::transmitting(Material::Dielectric {
                eta: COAT_INDEX,
                specular_reflectance,
                specular_transmittance,
                roughness: Some(facets),
            }));
        } else if !is_black(specular_reflectance) {
            let facets =
                Self::dielectric_reflection(COAT_INDEX, specular_reflectance, Some(facets));
            parts.push(Part::reflecting(facets));
        }
        self.sum(parts)
    }

    fn disney(&mut self, entity: &Entity<'_>) -> MaterialId {
        if entity.params.boolean("thin", false) {
            return self.thin_disney(entity);
        }
        if entity.params.has("scatterdistance") {
            let message = "`scatterdistance` of material `disney` is ignored";
            entity.params.unsupported("scatterdistance", message);
        }
        entity.params.ignore(&["scatterdistance", "difftrans"]);
        let base_color = self.reflectance(entity, "color", 0.5);
        let float = |name, default| self.float_input(entity, name, default);
        let principled = PrincipledMaterial {
            roughness: float("roughness", 0.5),
            anisotropic: float("anisotropic", 0.0),
            metallic: float("metallic", 0.0),
            spec_trans: float("spectrans", 0.0),
            spec_tint: float("speculartint", 0.0),
            sheen: float("sheen", 0.0),
            sheen_tint: float("sheentint", 0.5),
            flatness: float("flatness", 0.0),
            clearcoat: float("clearcoat", 0.0),
            clearcoat_gloss: float("clearcoatgloss", 1.0),
            base_color,
            eta: self.eta(entity, "eta", 1.5),
            diffuse_reflectance_sampling_rate: 1.0,
            main_specular_sampling_rate: 1.0,
            clearcoat_sampling_rate: 1.0,
            layers: None,
        };
        let transmits = principled.spec_trans != FloatInput::Constant(0.0);
        let material = Material::Principled(Box::new(principled));
        if transmits {
            self.desc.add(material)
        } else {
            self.both_sides(material)
        }
    }

    /// The model of thin surfaces.
    fn thin_disney(&mut self, entity: &Entity<'_>) -> MaterialId {
        let coat = ["scatterdistance", "clearcoat", "clearcoatgloss", "metallic"];
        entity.params.ignore(&coat);
        let base_color = self.reflectance(entity, "color", 0.5);
        let eta = self.eta(entity, "eta", 1.5);
        let float = |name, default| self.float_input(entity, name, default);
        let thin = PrincipledThinMaterial {
            roughness: float("roughness", 0.5),
            anisotropic: float("anisotropic", 0.0),
            spec_trans: float("spectrans", 0.0),
            eta: FloatInput::Constant(eta),
            spec_tint: float("speculartint", 0.0),
            sheen: float("sheen", 0.0),
            sheen_tint: float("sheentint", 0.5),
            flatness: float("flatness", 0.0),
            diff_trans: float("difftrans", 1.0),
            base_color,
        };
        self.desc.add(Material::PrincipledThin(Box::new(thin)))
    }
}
