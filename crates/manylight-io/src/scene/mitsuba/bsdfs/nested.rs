//! BSDF plugins that modify or combine nested bsdfs.

use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::sink::Problem;
use super::super::builder::{DescBuilder, PlainMaterial};
use super::super::family::PluginFamily;
use super::super::props::Props;
use super::super::values::{ObjectId, Value};
use manylight::bsdf::{Bitangent, Material};
use manylight::ids::MaterialId;
use manylight::texture::FloatInput;

impl DescBuilder<'_> {
    /// The only nested bsdf. Its absence is reported, and gray diffuse replaces it.
    pub(super) fn inner(&mut self, props: &Props<'_>) -> MaterialId {
        match props.single(PluginFamily::Bsdf) {
            Some(inner) => self.material(inner),
            None => {
                self.report_count(props, "one nested bsdf");
                self.plain_material(PlainMaterial::Gray)
            }
        }
    }

    /// Reports a wrong number of nested objects.
    fn report_count(&self, props: &Props<'_>, expected: &str) {
        if !props.is_broken() {
            let message = format!("{} needs {expected}", props.describe());
            self.sink
                .error_at("scene::missing_object", props.span(), message);
        }
    }

    pub(super) fn blend(&mut self, props: &Props<'_>) -> Material {
        props.require("weight");
        let weight = self.float_input(props, "weight", 0.5);
        let inner = props.objects(PluginFamily::Bsdf);
        let &[(first, _), (second, _)] = inner.as_slice() else {
            self.report_count(props, "two nested bsdfs");
            return Material::default();
        };
        Material::Blend {
            weight,
            first: self.material(first),
            second: self.material(second),
        }
    }

    pub(super) fn two_sided(&mut self, props: &Props<'_>) -> Material {
        props.ignore(&["allow_transmission"]);
        let inner = props.objects(PluginFamily::Bsdf);
        if inner.is_empty() || inner.len() > 2 {
            self.report_count(props, "one or two nested bsdfs");
            return Material::default();
        }
        let materials: Vec<MaterialId> = inner.iter().map(|(id, _)| self.material(*id)).collect();
        for ((id, param), material) in inner.iter().zip(&materials) {
            if self.transmits(*material) {
                let message = format!(
                    "{} transmits light and cannot be nested in `twosided`",
                    self.props(*id).describe()
                );
                let problem = Problem::new("scene::transmission_in_twosided", param.span, message);
                let help = "remove `twosided`: transmitting materials already have two sides";
                self.sink.error(problem.help(help));
            }
        }
        Material::TwoSided {
            front: materials[0],
            back: *materials.last().expect("invariant: there are one or two"),
        }
    }

    /// Whether the material transmits light.
    fn transmits(&self, material: MaterialId) -> bool {
        match &self.desc.materials[material.index()] {
            Material::Dielectric { .. }
            | Material::ThinDielectric { .. }
            | Material::DiffuseTransmitter { .. }
            | Material::PrincipledThin(_)
            | Material::Mask { .. }
            | Material::Null => true,
            Material::Principled(principled) => principled.spec_trans != FloatInput::Constant(0.0),
            Material::Blend { first, second, .. } | Material::Sum { first, second } => {
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
            | Material::Ward { .. }
            | Material::Substrate { .. } => false,
        }
    }

    pub(super) fn bump_map(&mut self, props: &Props<'_>) -> Material {
        self.check_invalid_normals(props);
        let inner = self.inner(props);
        let scale = props.float("scale", 1.0);
        let Some(texture) = props.single(PluginFamily::Texture) else {
            self.report_count(props, "one nested texture");
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

    /// Warns about other treatments of normals than the default.
    fn check_invalid_normals(&self, props: &Props<'_>) {
        let names = ["flip_invalid_normals", "use_shadowing_function"];
        let off: Vec<String> = names
            .iter()
            .filter(|name| !props.boolean(name, true))
            .map(|name| format!("`{name}`"))
            .collect();
        if !off.is_empty() {
            let (names, object) = (off.join(" and "), props.describe());
            let message = format!("{names} of {object} cannot be false here; true is used");
            props.unsupported(format!("normals of {object}"), message);
        }
    }

    /// The texture nested in a `scale` texture, and its scale. In 0.x, `scale` sets the height of
    /// bumps.
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

    pub(super) fn normal_map(&mut self, props: &Props<'_>) -> Material {
        self.check_invalid_normals(props);
        let inner = self.inner(props);
        // Version 3 requires the parameter name `normalmap`; 0.x accepts any nested texture.
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
            Some(texture) => Material::NormalMap {
                texture,
                scale: 1.0,
                bitangent: Bitangent::RightHanded,
                inner,
            },
            None => self.desc.materials[inner.index()].clone(),
        }
    }
}
