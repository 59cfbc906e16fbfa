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
        let (alpha_u, alpha_v) = if has_axes(props) {
            (
                self.float_input(props, "alpha_u", 0.1),
                self.float_input(props, "alpha_v", 0.1),
            )
        } else {
            let alpha = self.float_input(props, "alpha", 0.1);
            (alpha, alpha)
        };
        Roughness {
            distribution,
            alpha_u,
            alpha_v,
        }
    }
}

/// Whether `alpha_u` or `alpha_v` is given. One of them without the other or with `alpha` is
/// reported.
fn has_axes(props: &Props<'_>) -> bool {
    let [alpha, alpha_u, alpha_v] = ["alpha", "alpha_u", "alpha_v"].map(|name| props.get(name));
    match (alpha_u, alpha_v) {
        (None, None) => return false,
        (Some(_), None) => props.missing("alpha_v"),
        (None, Some(_)) => props.missing("alpha_u"),
        (Some(_), Some(_)) => {}
    }
    if let Some(alpha) = alpha {
        props.refuse(alpha, "absent if `alpha_u` or `alpha_v` is given");
    }
    true
}

/// The roughness `alpha`, or `alpha_u` and `alpha_v`, which must be equal.
pub(super) fn isotropic_alpha(props: &Props<'_>) -> f32 {
    let at_least_zero = |name| props.float_where(name, 0.1, |alpha| alpha >= 0.0, "at least 0");
    if !has_axes(props) {
        return at_least_zero("alpha");
    }
    let [alpha_u, alpha_v] = ["alpha_u", "alpha_v"].map(at_least_zero);
    // An axis that is missing has been reported.
    let are_given = props.has("alpha_u") && props.has("alpha_v");
    if are_given && alpha_u != alpha_v {
        props.refuse_named("alpha_u", "equal along u and v");
    }
    alpha_u
}
