//! Indices of refraction, as numbers or as names of materials.

use super::super::super::sink::Problem;
use super::super::DescBuilder;
use super::super::props::Props;
use super::super::values::Value;
use crate::resolve::similar;
use crate::spectra;
use manylight::color::Rgb;

impl DescBuilder<'_> {
    /// (eta, k) of the conductor that `material` names. `None` for `none`, and if `eta` or `k` is given instead.
    pub(super) fn named_metal(&self, props: &Props<'_>) -> Option<(Rgb, Rgb)> {
        // A conductor without parameters is copper in 0.x, and a perfect mirror since version 2.
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
            let message = format!("{} has both `material` and `eta` or `k`", props.describe());
            self.sink.error(
                Problem::new("scene::bad_value", text.span, message)
                    .help("expected either `material`, or `eta` and `k`"),
            );
        }
        let metal = spectra::metal(name);
        if let (None, Some(text)) = (&metal, &given) {
            let help = match similar(name, spectra::metal_names()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!(
                    "expected one of {}",
                    spectra::metal_names().collect::<Vec<_>>().join(", ")
                ),
            };
            self.sink.error(
                Problem::new(
                    "scene::bad_value",
                    text.span,
                    format!("unknown conductor `{name}`"),
                )
                .help(help),
            );
        }
        metal
    }

    /// The parameter `name`, an index of refraction as a number or as the name of a dielectric. `default` is the name of the
    /// default dielectric; without it, the default is 1.
    pub(super) fn ior(&self, props: &Props<'_>, name: &'static str, default: Option<&str>) -> f32 {
        let default = default.and_then(spectra::dielectric_ior).unwrap_or(1.0);
        let Some(param) = props.get(name) else {
            return default;
        };
        let Value::String(material) = &param.value else {
            return props.float_where(name, default, |ior| ior > 0.0, "positive");
        };
        spectra::dielectric_ior(material).unwrap_or_else(|| {
            let help = match similar(material, spectra::dielectric_names()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!(
                    "expected one of {}",
                    spectra::dielectric_names().collect::<Vec<_>>().join(", ")
                ),
            };
            let message = format!("unknown dielectric `{material}`");
            self.sink
                .error(Problem::new("scene::bad_value", param.span, message).help(help));
            default
        })
    }

    /// Index of refraction inside over that outside. `inside` is the default dielectric inside; outside it is air.
    pub(super) fn relative_ior(&self, props: &Props<'_>, inside: &str) -> f32 {
        self.ior(props, "int_ior", Some(inside)) / self.ior(props, "ext_ior", Some("air"))
    }
}
