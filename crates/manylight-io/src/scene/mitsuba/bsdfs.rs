//! BSDFs.

use super::super::sink::Problem;
use super::colors::ColorUse;
use super::object::{ObjectId, PluginFamily};
use super::props::Props;
use super::values::Value;
use super::{DescBuilder, Substitute};
use crate::resolve::similar;
use crate::spectra;
use manylight::bsdf::Material;
use manylight::bsdf::material::{Distribution, PrincipledMaterial, Roughness, WardVariant};
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

pub(super) const SUPPORTED: &[&str] = &[
    "blendbsdf",
    "bumpmap",
    "conductor",
    "dielectric",
    "diffuse",
    "mask",
    "normalmap",
    "null",
    "phong",
    "plastic",
    "principled",
    "roughconductor",
    "roughdielectric",
    "roughdiffuse",
    "roughplastic",
    "thindielectric",
    "twosided",
    "ward",
];

/// These exist in 0.x only.
const ONLY_V0: [&str; 3] = ["phong", "roughdiffuse", "ward"];

const GREY: &str = "replaced by grey diffuse";
const NESTED: &str = "replaced by the bsdf inside of it";
const CLEAR: &str = "replaced by null";

const SUBSTITUTES: &[Substitute] = &[
    ("hair", GREY),
    ("measured", GREY),
    ("measured_polarized", GREY),
    ("pplastic", GREY),
    ("principledthin", GREY),
    ("difftrans", GREY),
    ("hk", GREY),
    ("irawan", GREY),
    ("merl", GREY),
    ("coating", NESTED),
    ("roughcoating", NESTED),
    ("mixturebsdf", NESTED),
    ("circular", CLEAR),
    ("polarizer", CLEAR),
    ("retarder", CLEAR),
];

/// Materials of shapes that name none.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum PlainMaterial {
    /// The default.
    Grey,
    /// The default of shapes that shine.
    Black,
    /// No surface.
    Null,
}

impl DescBuilder<'_> {
    pub(super) fn add_material(&mut self, material: Material) -> MaterialId {
        self.desc.materials.push(material);
        MaterialId::from(self.desc.materials.len() - 1)
    }

    pub(super) fn plain_material(&mut self, plain: PlainMaterial) -> MaterialId {
        if let Some(material) = self.plain_materials.get(&plain) {
            return *material;
        }
        let material = self.add_material(match plain {
            PlainMaterial::Grey => Material::default(),
            PlainMaterial::Black => Material::Diffuse {
                reflectance: ColorInput::Constant(Rgb::BLACK),
            },
            PlainMaterial::Null => Material::Null,
        });
        self.plain_materials.insert(plain, material);
        material
    }

    /// The material, made at its first use.
    pub(super) fn material(&mut self, id: ObjectId) -> MaterialId {
        if let Some(material) = self.materials.get(&id) {
            return *material;
        }
        let props = self.props(id);
        let material = match self.bsdf(&props) {
            Some(material) => {
                props.ignore(&["id"]);
                props.finish();
                self.add_material(material)
            }
            None => self.substitute(&props),
        };
        self.materials.insert(id, material);
        material
    }

    fn substitute(&mut self, props: &Props<'_>) -> MaterialId {
        self.unsupported(props, SUPPORTED, SUBSTITUTES);
        let substitute = SUBSTITUTES
            .iter()
            .find(|(name, _)| *name == props.plugin().value)
            .map(|(_, what)| *what);
        match (substitute, props.objects(PluginFamily::Bsdf).first()) {
            (Some(NESTED), Some((inner, _))) => self.material(*inner),
            (Some(CLEAR), _) => self.plain_material(PlainMaterial::Null),
            _ => self.plain_material(PlainMaterial::Grey),
        }
    }

    /// `None` if the plugin is not supported.
    fn bsdf(&mut self, props: &Props<'_>) -> Option<Material> {
        let plugin = props.plugin().value.as_str();
        if ONLY_V0.contains(&plugin) {
            self.require_v0(props, "use `principled`, `roughconductor` or `diffuse`");
        }
        Some(match plugin {
            "diffuse" => Material::Diffuse {
                reflectance: self.reflectance(props, "reflectance", 0.5),
            },
            "roughdiffuse" => Material::RoughDiffuse {
                reflectance: self.reflectance(props, "reflectance", 0.5),
                alpha: self.float_input(props, "alpha", 0.2),
                full: !props.boolean("use_fast_approx", false),
            },
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
            },
            "plastic" => self.plastic(props, None),
            "roughplastic" => {
                props.ignore(&["sample_visible"]);
                let distribution = self.distribution(props);
                let alpha = isotropic_alpha(props);
                self.plastic(props, Some((distribution, alpha)))
            }
            "phong" => self.phong(props),
            "ward" => self.ward(props),
            "principled" => self.principled(props),
            "blendbsdf" => self.blend(props),
            "mask" => Material::Mask {
                opacity: self.float_input(props, "opacity", 0.5),
                inner: self.inner(props),
            },
            "null" => Material::Null,
            "twosided" => self.two_sided(props),
            "bumpmap" => self.bump_map(props),
            "normalmap" => self.normal_map(props),
            _ => return None,
        })
    }

    fn reflectance(&mut self, props: &Props<'_>, name: &'static str, default: f32) -> ColorInput {
        self.color_input(props, name, default, ColorUse::Reflectance)
    }

    fn distribution(&self, props: &Props<'_>) -> Distribution {
        if props.is_v0()
            && let Some(text) = props.string("distribution")
            && matches!(text.value.as_str(), "phong" | "as")
        {
            let message = format!(
                "distribution `{}` is not supported; replaced by beckmann",
                text.value
            );
            self.sink.warn_once(
                format!("distribution {}", text.value),
                Problem::new("scene::unsupported", text.span, message),
            );
            return Distribution::Beckmann;
        }
        let choices = [
            ("beckmann", Distribution::Beckmann),
            ("ggx", Distribution::Ggx),
        ];
        props.choice("distribution", Distribution::Beckmann, &choices)
    }

    fn roughness(&mut self, props: &Props<'_>) -> Roughness {
        props.ignore(&["sample_visible"]);
        let distribution = self.distribution(props);
        let axes = (props.has("alpha_u"), props.has("alpha_v"));
        let (alpha_u, alpha_v) = match axes {
            (false, false) => {
                let alpha = self.float_input(props, "alpha", 0.1);
                props.ignore(&["alpha_u", "alpha_v"]);
                (alpha, alpha)
            }
            _ => (
                self.float_input(props, "alpha_u", 0.1),
                self.float_input(props, "alpha_v", 0.1),
            ),
        };
        if axes.0 != axes.1 {
            props.missing(if axes.0 { "alpha_v" } else { "alpha_u" });
        }
        if axes.0
            && let Some(alpha) = props.get("alpha")
        {
            props.refuse(alpha, "absent where `alpha_u` and `alpha_v` are given");
        }
        Roughness {
            distribution,
            alpha_u,
            alpha_v,
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
        let relative = |input| match input {
            ColorInput::Constant(color) => ColorInput::Constant(color / outside),
            texture => texture,
        };
        Material::Conductor {
            eta: relative(eta),
            k: relative(k),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            roughness,
        }
    }

    /// The metal that `material` names; `None` for "none" and where `eta` and `k` are given.
    fn named_metal(&self, props: &Props<'_>) -> Option<(Rgb, Rgb)> {
        // A conductor without parameters is copper in 0.x and a perfect mirror in version 3.
        let default = if props.is_v0() && !props.has("eta") && !props.has("k") {
            "Cu"
        } else {
            "none"
        };
        let given = props.string("material");
        let name = given.as_ref().map_or(default, |text| text.value.as_str());
        if name == "none" {
            return None;
        }
        if let (Some(text), true) = (&given, props.has("eta") || props.has("k")) {
            let message = format!("{} has both `material` and `eta`, `k`", props.describe());
            self.sink.error(
                Problem::new("scene::bad_value", text.span, message).help("give one of them"),
            );
        }
        let metal = spectra::metal(name);
        if let (None, Some(text)) = (&metal, &given) {
            let help = match similar(name, spectra::metal_names()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!(
                    "known are {}",
                    spectra::metal_names().collect::<Vec<_>>().join(", ")
                ),
            };
            self.sink.error(
                Problem::new(
                    "scene::bad_value",
                    text.span,
                    format!("unknown metal `{name}`"),
                )
                .help(help),
            );
        }
        metal
    }

    /// An index of refraction as a number or the name of a material.
    fn ior(&self, props: &Props<'_>, name: &'static str, default: Option<&str>) -> f32 {
        let default = default.and_then(spectra::dielectric_ior).unwrap_or(1.0);
        let Some(param) = props.get(name) else {
            return default;
        };
        let Value::String(material) = &param.value else {
            return props.float_where(name, default, |ior| ior > 0.0, "positive");
        };
        // Names of materials are compared without regard to case.
        spectra::dielectric_ior(&material.to_lowercase()).unwrap_or_else(|| {
            let help = match similar(material, spectra::dielectric_names()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!(
                    "known are {}",
                    spectra::dielectric_names().collect::<Vec<_>>().join(", ")
                ),
            };
            let message = format!("unknown material `{material}`");
            self.sink
                .error(Problem::new("scene::bad_value", param.span, message).help(help));
            default
        })
    }

    fn relative_ior(&self, props: &Props<'_>, inside: &str) -> f32 {
        self.ior(props, "int_ior", Some(inside)) / self.ior(props, "ext_ior", Some("air"))
    }

    fn dielectric(&mut self, props: &Props<'_>, roughness: Option<Roughness>) -> Material {
        Material::Dielectric {
            eta: self.relative_ior(props, "bk7"),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            specular_transmittance: self.reflectance(props, "specular_transmittance", 1.0),
            roughness,
        }
    }

    fn plastic(&mut self, props: &Props<'_>, roughness: Option<(Distribution, f32)>) -> Material {
        Material::Plastic {
            eta: self.relative_ior(props, "polypropylene"),
            diffuse_reflectance: self.reflectance(props, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(props, "specular_reflectance", 1.0),
            nonlinear: props.boolean("nonlinear", false),
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
            diffuse_reflectance_sampling_rate: props
                .float("diffuse_reflectance_sampling_rate", 1.0),
            main_specular_sampling_rate: props.float("main_specular_sampling_rate", 1.0),
            clearcoat_sampling_rate: props.float("clearcoat_sampling_rate", 1.0),
        }))
    }

    /// `eta` as given, or such that the reflectance at normal incidence is 0.08 `specular`.
    fn principled_eta(&self, props: &Props<'_>, transmits: bool) -> f32 {
        if let Some(param) = props.get("eta") {
            if props.has("specular") {
                let message = format!("{} has both `eta` and `specular`", props.describe());
                self.sink.error(
                    Problem::new("scene::bad_value", param.span, message).help("give one of them"),
                );
                props.ignore(&["specular"]);
            }
            let eta = props.float_where("eta", 1.5, |eta| eta > 0.0, "positive");
            // Without any refraction, transmission is degenerate; the value is Mitsuba's.
            return if transmits && eta == 1.0 { 1.001 } else { eta };
        }
        let specular = props.float_where("specular", 0.5, |specular| specular >= 0.0, "at least 0");
        let specular = if transmits && specular == 0.0 {
            1e-3
        } else {
            specular
        };
        2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
    }

    /// The one nested bsdf.
    fn inner(&mut self, props: &Props<'_>) -> MaterialId {
        match props.single(PluginFamily::Bsdf) {
            Some(inner) => self.material(inner),
            None => {
                self.report_count(props, "one bsdf");
                self.plain_material(PlainMaterial::Grey)
            }
        }
    }

    fn report_count(&self, props: &Props<'_>, expected: &str) {
        if props.is_broken() {
            return;
        }
        let message = format!("{} needs {expected} inside of it", props.describe());
        self.sink
            .error(Problem::new("scene::missing_object", props.span(), message));
    }

    fn blend(&mut self, props: &Props<'_>) -> Material {
        if !props.has("weight") {
            props.missing("weight");
        }
        let weight = self.float_input(props, "weight", 0.5);
        let inner = props.objects(PluginFamily::Bsdf);
        let &[(first, _), (second, _)] = inner.as_slice() else {
            self.report_count(props, "two bsdfs");
            return Material::default();
        };
        Material::Blend {
            weight,
            first: self.material(first),
            second: self.material(second),
        }
    }

    fn two_sided(&mut self, props: &Props<'_>) -> Material {
        props.ignore(&["allow_transmission"]);
        let inner = props.objects(PluginFamily::Bsdf);
        if inner.is_empty() || inner.len() > 2 {
            self.report_count(props, "one or two bsdfs");
            return Material::default();
        }
        let materials: Vec<MaterialId> = inner.iter().map(|(id, _)| self.material(*id)).collect();
        for ((id, param), material) in inner.iter().zip(&materials) {
            if self.transmits(*material) {
                let message = format!(
                    "{} lets light through, so it cannot stand in twosided",
                    self.props(*id).describe()
                );
                let report = Problem::new("scene::transmission_in_twosided", param.span, message);
                self.sink
                    .error(report.help(
                        "materials that transmit have two sides already: leave out twosided",
                    ));
            }
        }
        Material::TwoSided {
            front: materials[0],
            back: *materials.last().expect("there are one or two"),
        }
    }

    /// Whether light can pass through the material.
    fn transmits(&self, material: MaterialId) -> bool {
        match &self.desc.materials[material.index()] {
            Material::Dielectric { .. }
            | Material::ThinDielectric { .. }
            | Material::Mask { .. }
            | Material::Null => true,
            Material::Principled(principled) => principled.spec_trans != FloatInput::Constant(0.0),
            Material::Blend { first, second, .. } => {
                self.transmits(*first) || self.transmits(*second)
            }
            Material::BumpMap { inner, .. } | Material::NormalMap { inner, .. } => {
                self.transmits(*inner)
            }
            Material::TwoSided { .. }
            | Material::Diffuse { .. }
            | Material::RoughDiffuse { .. }
            | Material::Conductor { .. }
            | Material::Plastic { .. }
            | Material::Phong { .. }
            | Material::Ward { .. } => false,
        }
    }

    fn bump_map(&mut self, props: &Props<'_>) -> Material {
        props.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
        let inner = self.inner(props);
        let scale = props.float("scale", 1.0);
        let Some(texture) = props.single(PluginFamily::Texture) else {
            self.report_count(props, "one texture");
            return Material::default();
        };
        let (texture, texture_scale) = self.unscaled(texture);
        match self.texture(texture) {
            Some(texture) => Material::BumpMap {
                texture,
                scale: scale * texture_scale,
                inner,
            },
            None => self.desc.materials[inner.index()].clone(),
        }
    }

    /// In 0.x, the height of bumps is set by a `scale` texture around the map.
    fn unscaled(&self, texture: ObjectId) -> (ObjectId, f32) {
        let props = self.props(texture);
        match props.single(PluginFamily::Texture) {
            Some(inner) if props.plugin().value == "scale" => {
                let scale = props.float("scale", 1.0);
                props.finish();
                (inner, scale)
            }
            _ => (texture, 1.0),
        }
    }

    fn normal_map(&mut self, props: &Props<'_>) -> Material {
        props.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
        let inner = self.inner(props);
        // Version 3 insists on the name, 0.x takes any texture.
        let texture = match props.get("normalmap").map(|param| &param.value) {
            Some(Value::Object(id)) => Some(*id),
            _ if props.is_v0() => props.single(PluginFamily::Texture),
            _ => None,
        };
        let Some(texture) = texture else {
            props.missing("normalmap");
            return Material::default();
        };
        match self.texture(texture) {
            Some(texture) => Material::NormalMap { texture, inner },
            None => self.desc.materials[inner.index()].clone(),
        }
    }
}

/// `alpha`, or `alpha_u` and `alpha_v` if they are equal.
fn isotropic_alpha(props: &Props<'_>) -> f32 {
    let at_least_zero = |name| props.float_where(name, 0.1, |alpha| alpha >= 0.0, "at least 0");
    let alpha = at_least_zero("alpha");
    let (alpha_u, alpha_v) = (at_least_zero("alpha_u"), at_least_zero("alpha_v"));
    match props.get("alpha_u").or_else(|| props.get("alpha_v")) {
        None => alpha,
        Some(param) => {
            if alpha_u != alpha_v {
                props.refuse(param, "the same along u and v");
            }
            alpha_u
        }
    }
}
