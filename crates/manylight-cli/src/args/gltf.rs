//! Options of glTF scenes.

use crate::values;
use clap::{Args, ValueEnum, ValueHint};
use manylight_io::{EnvironmentSource, GltfOptions, LightUnits};
use std::path::PathBuf;

/// What a glTF file does not say. An error for scenes of other formats.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "glTF scenes")]
pub(crate) struct GltfArgs {
    /// Units of point, spot and directional lights. Default: lm for files of Blender's exporter, W for others.
    #[arg(long, value_name = "UNITS", value_enum)]
    pub(crate) light_units: Option<Units>,

    /// Environment: an equirectangular image (exr or hdr), or the word `white` for a radiance of 1. Default: none, or white if nothing
    /// in the file emits light.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) environment: Option<PathBuf>,

    /// Factor of the radiance of the environment.
    #[arg(long, value_name = "X", requires = "environment", value_parser = values::positive)]
    pub(crate) environment_scale: Option<f32>,

    /// Name of a material variant.
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
}

/// Units of lights as `--light-units` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Units {
    /// W/sr and W/m²: the numbers of the file as they are.
    #[value(name = "W", alias = "w")]
    Watt,
    /// lm/sr and lm/m², with 683 lm/W: glTF's units.
    #[value(name = "lm")]
    Lumen,
    /// Blender's own numbers: points and spots in W, directional lights in W/m².
    #[value(name = "raw")]
    Raw,
}

impl Units {
    /// The word of `--light-units`.
    pub(crate) fn name(units: LightUnits) -> &'static str {
        match units {
            LightUnits::Watt => "W",
            LightUnits::Lumen => "lm",
            LightUnits::Raw => "raw",
        }
    }
}

/// The value of `--environment` for a constant environment.
const WHITE: &str = "white";

/// An environment as `--environment` names it.
pub(crate) fn environment_name(source: &EnvironmentSource) -> String {
    match source {
        EnvironmentSource::White => WHITE.into(),
        EnvironmentSource::File(path) => path.display().to_string(),
    }
}

impl GltfArgs {
    /// The options for the loader.
    pub(crate) fn options(&self) -> GltfOptions {
        GltfOptions {
            light_units: self.light_units.map(|units| match units {
                Units::Watt => LightUnits::Watt,
                Units::Lumen => LightUnits::Lumen,
                Units::Raw => LightUnits::Raw,
            }),
            environment: self.environment.as_ref().map(|name| {
                if name.as_os_str() == WHITE {
                    EnvironmentSource::White
                } else {
                    EnvironmentSource::File(name.clone())
                }
            }),
            environment_scale: self.environment_scale.unwrap_or(1.0),
            variant: self.variant.clone(),
        }
    }
}
