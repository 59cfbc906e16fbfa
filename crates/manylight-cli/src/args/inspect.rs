//! Options of the commands that inspect a scene or the program.

use super::gltf::GltfArgs;
use super::render::{CameraArgs, PathArgs, RunArgs};
use crate::light_options::LightArgs;
use crate::values;
use clap::{Args, ValueEnum, ValueHint};
use clap_complete::Shell;
use std::path::PathBuf;

/// Options of `maps`.
#[derive(Debug, Args)]
#[command(after_help = MAPS_HELP)]
pub(crate) struct MapsArgs {
    /// Scene file: Mitsuba XML, PBRT, or glTF 2.0 (gltf, glb).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Folder of the images; it is created if needed.
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) output: PathBuf,

    /// Method and paths; a method with virtual lights.
    #[command(flatten)]
    pub(crate) paths: PathArgs,

    /// Threads and warnings.
    #[command(flatten)]
    pub(crate) run: RunArgs,

    /// Print errors only.
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Options of the many-light methods; only those of photons and placement have an effect.
    #[command(flatten)]
    pub(crate) lights: LightArgs,

    /// Camera and film.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// glTF scenes.
    #[command(flatten)]
    pub(crate) gltf: GltfArgs,
}

const MAPS_HELP: &str = "\
Files, for the first pass, at the first surface with non-specular scattering behind each pixel:
  importance.png  importance from the camera, in 1/m²
  radiance.png    irradiance by the photons that may become lights, in W/m²
  product.png     importance times luminance of the irradiance, in W/m⁴: density of the placement by importance
  maps.exr        the values of these three maps, with the ranges of their color scales
  placement.png   a dot for each light that is directly visible to the camera
  relaxed.png     the same after relaxation
Color scales are logarithmic from the 1st to the 99.5th percentile of the positive values, violet to yellow; 0 is black.";

/// Options of `info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene file: Mitsuba XML, PBRT, or glTF 2.0 (gltf, glb).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Value of a scene parameter `$name` (Mitsuba XML). May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    pub(crate) defines: Vec<(String, String)>,

    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,

    /// glTF scenes.
    #[command(flatten)]
    pub(crate) gltf: GltfArgs,
}

/// Options of `check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scene file: Mitsuba XML, PBRT, or glTF 2.0 (gltf, glb).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Value of a scene parameter `$name` (Mitsuba XML). May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    pub(crate) defines: Vec<(String, String)>,

    /// Treat warnings as errors.
    #[arg(long)]
    pub(crate) strict: bool,

    /// glTF scenes.
    #[command(flatten)]
    pub(crate) gltf: GltfArgs,
}

/// Options of `list`.
#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Kind of names.
    #[arg(value_enum, value_name = "WHAT")]
    pub(crate) what: Listing,

    /// Scene format; names of this format are listed.
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = SceneFormat::Mitsuba)]
    pub(crate) format: SceneFormat,
}

/// Formats of scene files with named plugins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SceneFormat {
    /// Mitsuba XML.
    Mitsuba,
    /// PBRT, versions 3 and 4.
    Pbrt,
}

/// Kinds of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// Rendering methods with their settings.
    Methods,
    /// Scattering functions of scene files.
    Bsdfs,
    /// Light sources of scene files.
    Emitters,
    /// Shapes of scene files.
    Shapes,
    /// Textures of scene files.
    Textures,
    /// Cameras of scene files.
    Sensors,
    /// Reconstruction filters.
    Filters,
    /// Integrators of scene files; only their limits of paths are used, and whether they hide
    /// emitters.
    Integrators,
}

/// Options of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}
