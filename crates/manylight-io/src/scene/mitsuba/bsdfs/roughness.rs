//! Microfacet roughness.

use super::super::super::parameters::{Numbers, Parameters};
use super::super::builder::DescBuilder;
use super::super::props::Props;
use manylight::bsdf::material::{Distribution, Roughness};

impl DescBuilder<'_> {
    /// The microfacet distribution.
    pub(super) fn distribution(&self, props: &Props<'_>) -> Distribution {
        if props.is_v0()
            && let Some(text) = props.string("distribution")
            && matches!(text.value.as_str(), "phong" | "as")
        {
            let name = &text.value;
            let message =
                format!("distribution `{name}` is not supported; it is replaced by `beckmann`");
            self.sink
                .unsupported(format!("distribution {name}"), text.span, message);
            return Distribution::Beckmann;
        }
        let choices = [
            ("beckmann", Distribution::Beckmann),
            ("ggx", Distribution::Ggx),
        ];
        props.choice("distribution", Distribution::Beckmann, &choices)
    }

    /// Distribution and anisotropic roughness.
    pub(super) fn roughness(&mut self, props: &Props<'_>) -> Roughness {
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
            props.refuse(alpha, "absent if `alpha_u` and `alpha_v` are given");
        }
        Roughness {
            distribution,
            alpha_u,
            alpha_v,
        }
    }
}

/// The roughness `alpha`, or `alpha_u` and `alpha_v`, which must be equal.
pub(super) fn isotropic_alpha(props: &Props<'_>) -> f32 {
    let at_least_zero = |name| props.float_where(name, 0.1, |alpha| alpha >= 0.0, "at least 0");
    let alpha = at_least_zero("alpha");
    let (alpha_u, alpha_v) = (at_least_zero("alpha_u"), at_least_zero("alpha_v"));
    match props.get("alpha_u").or_else(|| props.get("alpha_v")) {
        None => alpha,
        Some(param) => {
            if alpha_u != alpha_v {
                props.refuse(param, "equal along u and v");
            }
            alpha_u
        }
    }
}
