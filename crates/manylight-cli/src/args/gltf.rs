//! Options of glTF scenes.

use super::written;
use crate::values;
use clap::{Args, ValueEnum, ValueHint};
use manylight_io::{DEFAULT_FPS, EnvironmentSource, GltfOptions, LightUnits, LoadOptions};
use serde::Serialize;
use std::path::PathBuf;

/// What a glTF file does not say. An error for scenes of other formats.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "glTF scenes")]
pub(crate) struct GltfArgs {
    /// Units of point, spot and directional lights. Default: lm for files of Blender's exporter, W
    /// for others.
    #[arg(long, value_name = "UNITS", value_enum)]
    pub(crate) light_units: Option<Units>,

    /// Environment: an equirectangular image (exr or hdr), or the word `white` for a radiance of 1.
    /// Default: none, or white if nothing in the file emits light of one color.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "written::path")]
    pub(crate) environment: Option<PathBuf>,

    /// Factor of the radiance of the environment.
    #[arg(long, value_name = "X", requires = "environment", value_parser = values::positive)]
    pub(crate) environment_scale: Option<f32>,

    /// Frames per second of a camera that moves in the scene, for --frames. Default: 24.
    #[arg(long, value_name = "X", value_parser = values::positive, help_heading = "Walkthroughs")]
    pub(crate) fps: Option<f32>,

    /// Name of a material variant.
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
}

/// Units of lights as `--light-units` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
pub(crate) enum Units {
    /// W/sr and W/m²: the numbers of the file as they are.
    #[value(name = "W", alias = "w")]
    #[serde(rename = "W")]
    Watt,
    /// lm/sr and lm/m², with 683 lm/W: glTF's units.
    #[value(name = "lm")]
    #[serde(rename = "lm")]
    Lumen,
    /// Blender's own numbers: points and spots in W, directional lights in W/m².
    #[value(name = "raw")]
    #[serde(rename = "raw")]
    Raw,
}

/// The value of `--environment` for a constant environment.
const WHITE: &str = "white";

impl GltfArgs {
    /// How a scene with the parameters `defines` is loaded.
    pub(crate) fn load_options(&self, defines: &[(String, String)]) -> LoadOptions {
        LoadOptions {
            defines: defines.to_vec(),
            fps: self.fps.unwrap_or(DEFAULT_FPS),
            gltf: self.options(),
            ..LoadOptions::default()
        }
    }

    /// The options without folders: the digest of a scene has the content of its files, wherever
    /// they are.
    pub(crate) fn without_folders(&self) -> Self {
        let name = |path: &PathBuf| path.file_name().map_or_else(|| path.clone(), PathBuf::from);
        GltfArgs {
            environment: self.environment.as_ref().map(name),
            ..self.clone()
        }
    }

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
