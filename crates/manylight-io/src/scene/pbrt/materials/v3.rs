//! Materials of PBRT v3, each as the material that comes nearest. One warning names it.

use super::super::super::description::{Additions, WHITE, scaled};
use super::super::super::parameters::Parameters;
use super::super::super::sink::{Problem, Text};
use super::super::builder::Builder;
use super::super::entities::Entity;
use super::conductors::mirror;
use manylight::bsdf::Material;
use manylight::bsdf::material::{Distribution, PrincipledMaterial};
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

/// Names that only PBRT v3 has, and what they become.
const MATERIALS: [(&str, &str); 11] = [
    ("disney", "the model of the same name"),
    ("fourier", "gray `conductor`"),
    ("glass", "`dielectric`"),
    ("kdsubsurface", "`coateddiffuse`"),
    ("matte", "`diffuse`"),
    ("metal", "`conductor`"),
    ("mirror", "`conductor` of constant reflectance"),
    ("plastic", "`coateddiffuse`"),
    ("substrate", "`coateddiffuse`"),
    ("translucent", "`diffusetransmission`"),
    (
        "uber",
        "`coateddiffuse`, blended with `dielectric` and a mirror",
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
                let roughness = self.roughness(entity, "", 0.01);
                let mut metal = self.conductor(entity, "");
                if let Material::Conductor { roughness: own, .. } = &mut metal {
                    *own = roughness;
                }
                self.both_sides(metal)
            }
            "mirror" => {
                let reflectance = self.reflectance(entity, "Kr", 0.9);
                self.both_sides(mirror(reflectance, None))
            }
            "plastic" | "uber" => self.uber(entity),
            "substrate" => self.substrate(entity),
            "translucent" => self.translucent(entity),
            "disney" => self.disney(entity),
            "kdsubsurface" => {
                let reflectance = self.reflectance(entity, "Kd", 0.5);
                entity.params.ignore_all();
                let material = self.coat(entity, reflectance, WHITE, 1.3, 0.0);
                self.both_sides(material)
            }
            _ => {
                entity.params.ignore_all();
                let gray = ColorInput::Constant(Rgb::splat(0.5));
                self.both_sides(mirror(gray, None))
            }
        }
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
                    full: false,
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
        let roughness = roughness.map(|alpha| (Distribution::Ggx, self.one_alpha(entity, &alpha)));
        Material::Plastic {
            eta,
            diffuse_reflectance: base,
            specular_reflectance: specular,
            nonlinear: false,
            roughness,
        }
    }

    /// `plastic`, and `uber` with mirror reflection, transmission and opacity.
    fn uber(&mut self, entity: &Entity<'_>) -> MaterialId {
        let base = self.reflectance(entity, "Kd", 0.25);
        let specular = self.reflectance(entity, "Ks", 0.25);
        let index = self.eta(entity, "index", 1.5);
        let eta = self.eta(entity, "eta", index);
        let coat = self.coat(entity, base, specular, eta, 0.1);
        let mut material = self.both_sides(coat);
        let mirror_part = self.reflectance(entity, "Kr", 0.0);
        let clear_part = self.reflectance(entity, "Kt", 0.0);
        if let ColorInput::Constant(color) = mirror_part
            && !color.is_black()
        {
            let second = self.both_sides(mirror(WHITE, None));
            material = self.blend(FloatInput::Constant(color.max_channel()), material, second);
        }
        if let ColorInput::Constant(color) = clear_part
            && !color.is_black()
        {
            let second = self.desc.add(Material::Dielectric {
                eta,
                specular_reflectance: WHITE,
                specular_transmittance: ColorInput::Constant(color / color.max_channel()),
                roughness: None,
            });
            material = self.blend(FloatInput::Constant(color.max_channel()), material, second);
        }
        let opacity = match self.reflectance(entity, "opacity", 1.0) {
            ColorInput::Constant(color) => FloatInput::Constant(color.luminance()),
            ColorInput::Texture(id) => FloatInput::Texture(id),
        };
        self.masked(material, opacity)
    }

    /// A coat whose reflectance at normal incidence is `Ks`.
    fn substrate(&mut self, entity: &Entity<'_>) -> MaterialId {
        /// Largest reflectance of a coat, as a bound of its index of refraction.
        const MAX_REFLECTANCE: f32 = 0.9;
        let base = self.reflectance(entity, "Kd", 0.5);
        let specular = self.luminance(entity, "Ks");
        let root = specular.clamp(0.0, MAX_REFLECTANCE).sqrt();
        let eta = ((1.0 + root) / (1.0 - root)).max(1.01);
        let coat = self.coat(entity, base, WHITE, eta, 0.1);
        self.both_sides(coat)
    }

    fn translucent(&mut self, entity: &Entity<'_>) -> MaterialId {
        let base = self.reflectance(entity, "Kd", 0.25);
        entity.params.ignore(&["Ks", "roughness", "remaproughness"]);
        let reflect = self.luminance(entity, "reflect");
        let transmit = self.luminance(entity, "transmit");
        let reflectance = scaled(&mut self.desc.textures, base, reflect);
        let transmittance = scaled(&mut self.desc.textures, base, transmit);
        self.transmitting_diffuse(reflectance, transmittance)
    }

    /// The luminance of a reflectance, 0.5 by default and of textures.
    fn luminance(&mut self, entity: &Entity<'_>, name: &'static str) -> f32 {
        match self.reflectance(entity, name, 0.5) {
            ColorInput::Constant(color) => color.luminance(),
            ColorInput::Texture(_) => 0.5,
        }
    }

    fn disney(&mut self, entity: &Entity<'_>) -> MaterialId {
        entity
            .params
            .ignore(&["scatterdistance", "thin", "difftrans"]);
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
}
