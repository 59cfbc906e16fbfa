//! Indices of refraction, as numbers or as names of materials.

use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::sink::Problem;
use super::super::builder::DescBuilder;
use super::super::props::Props;
use super::super::values::Value;
use crate::spectra;
use crate::suggest::one_of;
use manylight::color::Rgb;

impl DescBuilder<'_> {
    /// (eta, k) of the conductor that `material` names. `None` for `none`, and if `eta` or `k` is
    /// given instead.
    pub(super) fn named_metal(&self, props: &Props<'_>) -> Option<(Rgb, Rgb)> {
        // A conductor without parameters is copper in 0.x, and a perfect mirror since version 2.
        let default = if props.is_v0() && !props.has("eta") && !props.has("k") {
            "Cu"
        } else {
            "none"
        };
        let given = props.string("material");
        let name = given.map_or(default, |text| text.value.as_str());
        if name == "none" {
            return None;
        }
        if let (Some(text), true) = (given, props.has("eta") || props.has("k")) {
            let message = format!("{} has both `material` and `eta` or `k`", props.describe());
            let problem = Problem::new("scene::bad_value", text.span, message);
            let help = "expected either `material`, or `eta` and `k`";
            self.sink.error(problem.help(help));
        }
        let metal = spectra::metal(name);
        if let (None, Some(text)) = (&metal, given) {
            let message = format!("unknown conductor `{name}`");
            let problem = Problem::new("scene::bad_value", text.span, message);
            let help = one_of(name, spectra::metal_names());
            self.sink.error(problem.help(help));
        }
        metal
    }

    /// The parameter `name`, an index of refraction as a number or as the name of a dielectric.
    /// `default` is the name of the default dielectric; without it, the default is 1.
    pub(super) fn ior(&self, props: &Props<'_>, name: &'static str, default: Option<&str>) -> f32 {
        let default = default.and_then(spectra::dielectric_ior).unwrap_or(1.0);
        let Some(param) = props.get(name) else {
            return default;
        };
        let Value::String(material) = &param.value else {
            return props.float_where(name, default, |ior| ior > 0.0, "positive");
        };
        let name = &material.value;
        spectra::dielectric_ior(name).unwrap_or_else(|| {
            let message = format!("unknown dielectric `{name}`");
            let problem = Problem::new("scene::bad_value", param.span, message);
            let help = one_of(name, spectra::dielectric_names());
            self.sink.error(problem.help(help));
            default
        })
    }

    /// Index of refraction inside over that outside. `inside` is the default dielectric inside;
    /// outside it is air.
    pub(super) fn relative_ior(&self, props: &Props<'_>, inside: &str) -> f32 {
        self.ior(props, "int_ior", Some(inside)) / self.ior(props, "ext_ior", Some("air"))
    }
}
