//! Integrator plugins. Only their path limits are used; the caller chooses the rendering method.

use super::super::parameters::Parameters;
use super::builder::DescBuilder;
use super::family::PluginFamily;
use super::props::Props;
use manylight::scene::PathLimits;

pub(super) const SUPPORTED: &[&str] = &[
    "aov",
    "bdpt",
    "direct",
    "moment",
    "path",
    "photonmapper",
    "ppm",
    "ptracer",
    "sppm",
    "volpath",
    "volpathmis",
    "vpl",
];

/// Integrators that wrap the integrator with the path limits.
const WRAPPERS: [&str; 4] = ["adaptive", "aov", "moment", "irrcache"];

/// Parameters without effect.
const IGNORED: &[&str] = &[
    "id",
    "samples_per_pass",
    "block_size",
    "timeout",
    "hide_environment",
    "strict_normals",
    "granularity",
    "brute_force",
];

/// The path limits of an integrator.
pub(super) fn limits(props: &Props<'_>, builder: &DescBuilder<'_>) -> PathLimits {
    let plugin = props.plugin().value.as_str();
    let nested = props.objects(PluginFamily::Integrator);
    if WRAPPERS.contains(&plugin)
        && let Some((inner, _)) = nested.first()
    {
        return limits(&builder.props(*inner), builder);
    }
    if !SUPPORTED.contains(&plugin) && !plugin.contains('$') {
        let message = format!(
            "unknown integrator type `{plugin}`; only its `max_depth`, `rr_depth` and `hide_emitters` are used"
        );
        props.unsupported(format!("integrator {plugin}"), message);
    }
    let direct_only = plugin == "direct";
    let max_depth = match props.maybe_integer("max_depth") {
        _ if direct_only => Some(2),
        None | Some(-1) => None,
        Some(depth) if (0..=i64::from(u32::MAX)).contains(&depth) => Some(depth as u32),
        Some(_) => {
            props.refuse_named("max_depth", "at least 0, or -1 for no limit");
            None
        }
    };
    let rr_depth = props.integer("rr_depth", 5, 1) as u32;
    // Paths without a segment: nothing is visible, emitters neither.
    let (max_depth, shows_nothing) = match max_depth {
        Some(0) => (Some(1), true),
        other => (other, false),
    };
    let hide_emitters = props.boolean("hide_emitters", false) || shows_nothing;
    if matches!(
        plugin,
        "path" | "volpath" | "volpathmis" | "direct" | "ptracer"
    ) {
        props.ignore(IGNORED);
        props.ignore(&["emitter_samples", "bsdf_samples", "shading_samples"]);
        props.finish();
    }
    PathLimits {
        max_depth,
        rr_depth,
        hide_emitters,
    }
}
