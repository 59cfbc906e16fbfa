//! Presets: the methods by name, with their settings.

use crate::failure::Failure;
use crate::light_options::settings;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};

/// A named method.
#[derive(Debug)]
pub(crate) struct Preset {
    /// Name, as `--method` takes it.
    pub(crate) name: &'static str,
    /// Description in one line.
    pub(crate) summary: &'static str,
    /// Its settings.
    pub(crate) kind: fn() -> MethodKind,
}

/// Presets differ in their names.
impl PartialEq for Preset {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// Name of the method that is chosen when the scene is known.
const AUTO: &str = "auto";

impl Preset {
    /// Whether its settings are those of virtual lights that path tracing may replace or join, by a
    /// choice when the scene is known.
    pub(crate) fn is_chosen(&self) -> bool {
        self.name == AUTO
    }
}

/// All presets, the default first.
pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: AUTO,
        summary: "Path tracing, rich-vpl, or the mean of both: what has the least error in this scene, by a short pre-pass",
        kind: || MethodKind::ManyLight(ManyLight::rich_vpl_by_scene()),
    },
    Preset {
        name: "rich-vpl",
        summary: "Rich virtual point lights: placed by importance, each represents all photons in its Voronoi cell",
        kind: || MethodKind::ManyLight(ManyLight::rich_vpl_by_scene()),
    },
    Preset {
        name: "rich-vpl-paper",
        summary: "Rich-VPLs as presented in 2015, in our interpretation: density estimation, point lights, one clamping bound",
        kind: || MethodKind::ManyLight(ManyLight::rich_vpl_paper()),
    },
    Preset {
        name: "rich-vsl",
        summary: "Rich virtual spherical lights: Rich-VPLs evaluated as spheres",
        kind: || MethodKind::ManyLight(ManyLight::rich_vsl()),
    },
    Preset {
        name: "vpl",
        summary: "Classic virtual point lights: a random subset of the photons (instant radiosity)",
        kind: || MethodKind::ManyLight(ManyLight::vpl()),
    },
    Preset {
        name: "vpl-is",
        summary: "Virtual point lights placed by importance",
        kind: || MethodKind::ManyLight(ManyLight::vpl_importance()),
    },
    Preset {
        name: "vsl",
        summary: "Virtual spherical lights: classic virtual lights evaluated as spheres",
        kind: || MethodKind::ManyLight(ManyLight::vsl()),
    },
    Preset {
        name: "lightcuts",
        summary: "Lightcuts: many classic virtual point lights, summed in clusters of a light tree",
        kind: || MethodKind::ManyLight(ManyLight::lightcuts()),
    },
    Preset {
        name: "rich-lightcuts",
        summary: "Lightcuts with many Rich-VPLs",
        kind: || MethodKind::ManyLight(ManyLight::rich_lightcuts()),
    },
    Preset {
        name: "bidirectional-lightcuts",
        summary: "Bidirectional lightcuts: one cut through all pairs of gather points of a pixel and Rich-VPLs",
        kind: || MethodKind::ManyLight(ManyLight::bidirectional_lightcuts()),
    },
    Preset {
        name: "photon-map",
        summary: "Progressive photon mapping: density estimation on rough surfaces, with shrinking radii",
        kind: || MethodKind::PhotonMap(PhotonMap::progressive()),
    },
    Preset {
        name: "photon-map-direct",
        summary: "Direct visualization of the photon map: density estimation from the nearest photons",
        kind: || MethodKind::PhotonMap(PhotonMap::direct()),
    },
    Preset {
        name: "path",
        summary: "Path tracing with next-event estimation and MIS: the reference",
        kind: || MethodKind::Path,
    },
    Preset {
        name: "light-trace",
        summary: "Light tracing: photon paths connected to the camera; smooth glass and mirrors are black",
        kind: || MethodKind::LightTracer,
    },
    Preset {
        name: "direct",
        summary: "Direct illumination only",
        kind: || MethodKind::Direct,
    },
    Preset {
        name: "aov",
        summary: "Albedo, normal, depth, position and mattes of what the camera sees first",
        kind: || MethodKind::Aov,
    },
];

/// The method of walkthroughs where one would be chosen: its lights serve all frames.
pub(crate) fn of_kept_lights() -> &'static Preset {
    find("rich-vpl").expect("invariant: the preset exists")
}

/// Name of the default method.
pub(crate) const DEFAULT: &str = PRESETS[0].name;

/// The preset with this name.
pub(crate) fn find(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// Parser of the names of presets.
pub(crate) fn parser() -> impl TypedValueParser<Value = &'static Preset> {
    let names = PRESETS
        .iter()
        .map(|preset| PossibleValue::new(preset.name).help(preset.summary));
    PossibleValuesParser::new(names)
        .map(|name| find(&name).expect("invariant: the parser accepts presets alone"))
}

/// Names of the presets with the setting `--{option}`.
pub(crate) fn names_with(option: &str) -> Vec<&'static str> {
    let has_option = |preset: &&Preset| {
        settings(&(preset.kind)())
            .iter()
            .any(|(name, _)| *name == option)
    };
    PRESETS
        .iter()
        .filter(has_option)
        .map(|preset| preset.name)
        .collect()
}

/// The failure of a method without virtual lights.
pub(crate) fn no_lights(method: &Preset) -> Failure {
    Failure::usage(
        format!("the method `{}` has no virtual lights", method.name),
        format!("those with lights: {}", names_with("lights").join(", ")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        for (i, preset) in PRESETS.iter().enumerate() {
            assert!(PRESETS[..i].iter().all(|other| other.name != preset.name));
            assert_eq!(find(preset.name).unwrap().summary, preset.summary);
        }
        assert!(find("rich-vlp").is_none());
        assert_eq!(DEFAULT, "auto");
        assert_eq!(
            names_with("lights"),
            [
                "auto",
                "rich-vpl",
                "rich-vpl-paper",
                "rich-vsl",
                "vpl",
                "vpl-is",
                "vsl",
                "lightcuts",
                "rich-lightcuts",
                "bidirectional-lightcuts"
            ]
        );
        assert_eq!(
            names_with("table-size"),
            [
                "auto",
                "rich-vpl",
                "rich-vpl-paper",
                "rich-vsl",
                "rich-lightcuts",
                "bidirectional-lightcuts"
            ]
        );
    }

    #[test]
    fn the_default_has_the_flux_of_voronoi_cells() {
        let axes = settings(&(find(DEFAULT).unwrap().kind)());
        let value = |name| axes.iter().find(|(n, _)| *n == name).unwrap().1.clone();
        assert_eq!(value("placement"), "importance");
        assert_eq!(value("flux"), "partition");
        assert_eq!(value("emission"), "table");
        assert_eq!(value("table-size"), "48");
        assert_eq!(value("table-storage"), "shared");
        assert_eq!(value("kernel"), "disc");
    }
}
