//! BSDF plugins.

mod ior;
mod nested;
mod roughness;

use super::super::description::{Additions, WHITE, scaled};
use super::super::names::name_material;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::{DescBuilder, PlainMaterial, Substitute};
use super::colors::ColorUse;
use super::family::PluginFamily;
use super::props::Props;
use super::values::ObjectId;
use manylight::bsdf::Material;
use manylight::bsdf::material::{
    ColorShift, ConstantRoughness, OrenNayarVariant, PrincipledMaterial, PrincipledThinMaterial,
    Roughness, WardVariant,
};
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

pub(super) const SUPPORTED: &[&str] = &[
    "blendbsdf",
    "bumpmap",
    "circular",
    "conductor",
    "dielectric",
    "diffuse",
    "mask",
    "normalmap",
    "null",
    "phong",
    "plastic",
    "polarizer",
    "principled",
    "principledthin",
    "retarder",
    "roughconductor",
    "roughdielectric",
    "roughdiffuse",
    "roughplastic",
    "thindielectric",
    "twosided",
    "ward",
];

/// Plugins that exist only in 0.x.
const ONLY_V0: [&str; 3] = ["phong", "roughdiffuse", "ward"];

const GRAY: &str = "it is replaced by gray diffuse";
const NESTED: &str = "it is replaced by the nested bsdf";

/// Part of unpolarized light that a filter for linear or circular polarization transmits.
const FILTERED: f32 = 0.5;

const SUBSTITUTES: &[Substitute] = &[
    ("hair", GRAY),
    ("measured", GRAY),
    ("measured_polarized", GRAY),
    ("pplastic", GRAY),
    ("difftrans", GRAY),
    ("hk", GRAY),
    ("irawan", GRAY),
    ("merl", GRAY),
    ("coating", NESTED),
    ("roughcoating", NESTED),
    ("mixturebsdf", NESTED),
];

/// Index of refraction that replaces 1 where `principled` transmits, because transmission without
/// refraction is degenerate; as in Mitsuba.
const MIN_ETA_OF_TRANSMISSION: f32 = 1.001;
/// Value of `specular` that replaces 0 for the same reason.
const MIN_SPECULAR_OF_TRANSMISSION: f32 = 1e-3;

impl DescBuilder<'_> {
    /// The material of a bsdf, added at its first use.
    pub(super) fn material(&mut self, id: ObjectId) -> MaterialId {
        let key = self.scoped(id);
        if let Some(material) = self.made.materials.get(&key) {
            return *material;
        }
        let props = self.props(id);
        let material = match self.bsdf(&props) {
            Some(material) => {
                props.ignore(&["id"]);
                props.finish();
                self.desc.add(material)
            }
            None => self.substitute(&props),
        };
        self.made.materials.insert(key, material);
        let names = &mut self.desc.material_names;
        name_material(names, material, &props.object().id);
        material
    }

    /// The replacement of a plugin that is not supported, which is reported.
    fn substitute(&mut self, props: &Props<'_>) -> MaterialId {
        self.unsupported(props, SUPPORTED, SUBSTITUTES);
        let substitute = SUBSTITUTES
            .iter()
            .find(|(name, _)| *name == props.plugin().value)
            .map(|(_, what)| *what);
        match (substitute, props.objects(PluginFamily::Bsdf).first()) {
            (Some(NESTED), Some((inner, _))) => self.material(*inner),
            _ => self.plain_material(PlainMaterial::Gray),
        }
    }

    /// The material of a supported plugin, else `None`.
    fn bsdf(&mut self, props: &Props<'_>) -> Option<Material> {
        let plugin = props.plugin().value.as_str();
        if ONLY_V0.contains(&plugin) {
            self.require_v0(props, "use `principled`, `roughconductor` or `diffuse`");
        }
        Some(match plugin {
            "diffuse" => Material::Diffuse {
                reflectance: self.reflectance(props, "reflectance", 0.5),
            },
            "roughdiffuse" => self.rough_diffuse(props),
            "conductor" => self.conductor(props, None),
            "roughconductor" => {
                let roughness = self.roughness(props);
                self.conductor(props, Some(roughness))
            }
            "dielectric" => self.dielectric(props, None),
            "roughdielectric" => {
                let roughness = self.roughness(props);
                self.dielectric(props, Some(roughness))
            }
            "thindielectric" => Material::ThinDielectric {
                eta: self.relative_ior(props, "bk7"),
                specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
                specular_transmittance: self.reflectance(props, "specular_transmittance", 1.0),
                roughness: None,
            },
            "plastic" => self.plastic(props, None),
            "roughplastic" => {
                props.ignore(&["sample_visible"]);
                let distribution = self.distribution(props);
                let alpha = roughness::isotropic_alpha(props);
                let roughness = ConstantRoughness {
                    distribution,
                    alpha,
                };
                self.plastic(props, Some(roughness))
            }
            "phong" => self.phong(props),
            "ward" => self.ward(props),
            "principled" => self.principled(props),
            "principledthin" => self.principled_thin(props),
            "blendbsdf" => self.blend(props),
            "mask" => Material::Mask {
                opacity: self.float_input(props, "opacity", 0.5),
                inner: self.inner(props),
            },
            "null" => Material::Null,
            "polarizer" | "circular" => self.polarizer(props, FILTERED),
            "retarder" => self.polarizer(props, 1.0),
            "twosided" => self.two_sided(props),
            "bumpmap" => self.bump_map(props),
            "normalmap" => self.normal_map(props),
            _ => return None,
        })
    }

    /// A filter of polarized light, by what it does to unpolarized light: straight-through
    /// transmission of `part` times its transmittance.
    fn polarizer(&mut self, props: &Props<'_>, part: f32) -> Material {
        props.ignore(&["theta", "delta", "polarizing", "left_handed"]);
        let transmittance = self.reflectance(props, "transmittance", 1.0);
        Material::ThinDielectric {
            eta: 1.0,
            specular_reflectance: WHITE,
            specular_transmittance: scaled(&mut self.desc.textures, transmittance, part),
            roughness: None,
        }
    }

    /// A reflectance or transmittance parameter.
    fn reflectance(&mut self, props: &Props<'_>, name: &'static str, default: f32) -> ColorInput {
        self.color_input(props, name, default, ColorUse::Reflectance)
    }

    fn rough_diffuse(&mut self, props: &Props<'_>) -> Material {
        Material::RoughDiffuse {
            reflectance: self.reflectance(props, "reflectance", 0.5),
            alpha: self.float_input(props, "alpha", 0.2),
            variant: match props.boolean("use_fast_approx", false) {
                true => OrenNayarVariant::Qualitative,
                false => OrenNayarVariant::Full,
            },
        }
    }

    fn conductor(&mut self, props: &Props<'_>, roughness: Option<Roughness>) -> Material {
        let named = self.named_metal(props);
        let (eta, k) = match named {
            Some((eta, k)) => (ColorInput::Constant(eta), ColorInput::Constant(k)),
            None => (
                self.color_input(props, "eta", 0.0, ColorUse::Coefficient),
                self.color_input(props, "k", 1.0, ColorUse::Coefficient),
            ),
        };
        props.ignore(&["eta", "k"]);
        let outside = if props.is_v0() {
            self.ior(props, "ext_eta", None)
        } else {
            1.0
        };
        let mut relative = |input| scaled(&mut self.desc.textures, input, outside.recip());
        let (eta, k) = (relative(eta), relative(k));
        Material::Conductor {
            eta,
            k,
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            roughness,
        }
    }

    fn dielectric(&mut self, props: &Props<'_>, roughness: Option<Roughness>) -> Material {
        Material::Dielectric {
            eta: self.relative_ior(props, "bk7"),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            specular_transmittance: self.reflectance(props, "specular_transmittance", 1.0),
            roughness,
        }
    }

    fn plastic(&mut self, props: &Props<'_>, roughness: Option<ConstantRoughness>) -> Material {
        Material::Plastic {
            eta: self.relative_ior(props, "polypropylene"),
            diffuse_reflectance: self.reflectance(props, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            color_shift: match props.boolean("nonlinear", false) {
                true => ColorShift::Nonlinear,
                false => ColorShift::Linear,
            },
            roughness,
        }
    }

    fn phong(&mut self, props: &Props<'_>) -> Material {
        props.ignore(&["specular_sampling_weight"]);
        Material::Phong {
            diffuse_reflectance: self.reflectance(props, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 0.2),
            exponent: self.float_input(props, "exponent", 30.0),
        }
    }

    fn ward(&mut self, props: &Props<'_>) -> Material {
        let variants = [
            ("ward", WardVariant::Ward),
            ("ward-duer", WardVariant::WardDuer),
            ("balanced", WardVariant::Balanced),
        ];
        props.ignore(&["specular_sampling_weight"]);
        Material::Ward {
            variant: props.choice("variant", WardVariant::Balanced, &variants),
            diffuse_reflectance: self.reflectance(props, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 0.2),
            alpha_u: self.float_input(props, "alpha_u", 0.1),
            alpha_v: self.float_input(props, "alpha_v", 0.1),
        }
    }

    fn principled(&mut self, props: &Props<'_>) -> Material {
        let spec_trans = self.float_input(props, "spec_trans", 0.0);
        Material::Principled(Box::new(PrincipledMaterial {
            base_color: self.reflectance(props, "base_color", 0.5),
            roughness: self.float_input(props, "roughness", 0.5),
            anisotropic: self.float_input(props, "anisotropic", 0.0),
            metallic: self.float_input(props, "metallic", 0.0),
            spec_trans,
            eta: self.principled_eta(props, spec_trans != FloatInput::Constant(0.0)),
            spec_tint: self.float_input(props, "spec_tint", 0.0),
            sheen: self.float_input(props, "sheen", 0.0),
            sheen_tint: self.float_input(props, "sheen_tint", 0.0),
            flatness: self.float_input(props, "flatness", 0.0),
            clearcoat: self.float_input(props, "clearcoat", 0.0),
            clearcoat_gloss: self.float_input(props, "clearcoat_gloss", 0.0),
            layers: None,
            diffuse_reflectance_sampling_rate: props
                .float("diffuse_reflectance_sampling_rate", 1.0),
            main_specular_sampling_rate: props.float("main_specular_sampling_rate", 1.0),
            clearcoat_sampling_rate: props.float("clearcoat_sampling_rate", 1.0),
        }))
    }

    fn principled_thin(&mut self, props: &Props<'_>) -> Material {
        // Sampling rates have no effect on the converged image.
        props.ignore(&[
            "diffuse_reflectance_sampling_rate",
            "diffuse_transmittance_sampling_rate",
            "specular_reflectance_sampling_rate",
            "specular_transmittance_sampling_rate",
        ]);
        Material::PrincipledThin(Box::new(PrincipledThinMaterial {
            base_color: self.reflectance(props, "base_color", 0.5),
            roughness: self.float_input(props, "roughness", 0.5),
            anisotropic: self.float_input(props, "anisotropic", 0.0),
            spec_trans: self.float_input(props, "spec_trans", 0.0),
            eta: self.float_input(props, "eta", 1.5),
            spec_tint: self.float_input(props, "spec_tint", 0.0),
            sheen: self.float_input(props, "sheen", 0.0),
            sheen_tint: self.float_input(props, "sheen_tint", 0.0),
            flatness: self.float_input(props, "flatness", 0.0),
            diff_trans: self.float_input(props, "diff_trans", 0.0),
        }))
    }

    /// The parameter `eta`, or the index of refraction with the reflectance 0.08 `specular` at
    /// normal incidence.
    fn principled_eta(&self, props: &Props<'_>, transmits: bool) -> f32 {
        if let Some(param) = props.get("eta") {
            if props.has("specular") {
                let message = format!("{} has both `eta` and `specular`", props.describe());
                let problem = Problem::new("scene::bad_value", param.span, message);
                self.sink.error(problem.help("expected one of them"));
                props.ignore(&["specular"]);
            }
            let eta = props.float_where("eta", 1.5, |eta| eta > 0.0, "positive");
            return if transmits && eta == 1.0 {
                MIN_ETA_OF_TRANSMISSION
            } else {
                eta
            };
        }
        let specular = props.float_where("specular", 0.5, |specular| specular >= 0.0, "at least 0");
        let specular = if transmits && specular == 0.0 {
            MIN_SPECULAR_OF_TRANSMISSION
        } else {
            specular
        };
        2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
    }
}
