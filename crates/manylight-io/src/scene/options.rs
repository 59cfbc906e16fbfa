//! Options of loading scenes.

use std::path::PathBuf;

/// Options of loading.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Values of `$name` parameters, as pairs of name and value. They override the `<default>`s of
    /// the file.
    pub defines: Vec<(String, String)>,
    /// Whether the first warning is an error.
    pub strict: bool,
    /// Frames per second of moving cameras.
    pub fps: f32,
    /// Options for glTF scenes. Options that differ from the default are errors for scenes of other
    /// formats.
    pub gltf: GltfOptions,
}

/// Options of loading glTF scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfOptions {
    /// The units of punctual lights. `None`: lumen for files of Blender's exporter, watt for
    /// others.
    pub light_units: Option<LightUnits>,
    /// The environment.
    pub environment: Option<EnvironmentSource>,
    /// Factor of the radiance of the environment.
    pub environment_scale: f32,
    /// Name of the material variant to show; `None`: the materials of the meshes.
    pub variant: Option<String>,
}

/// Frames per second of moving cameras by default: those of Blender.
pub const DEFAULT_FPS: f32 = 24.0;

impl Default for LoadOptions {
    fn default() -> Self {
        LoadOptions {
            defines: Vec::new(),
            strict: false,
            fps: DEFAULT_FPS,
            gltf: GltfOptions::default(),
        }
    }
}

impl Default for GltfOptions {
    fn default() -> Self {
        GltfOptions {
            light_units: None,
            environment: None,
            environment_scale: 1.0,
            variant: None,
        }
    }
}

/// An environment for a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnvironmentSource {
    /// The same radiance, 1 W/(m² sr), from all directions.
    White,
    /// An equirectangular image, OpenEXR or Radiance HDR.
    File(PathBuf),
}

/// Units of the intensities of punctual lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightUnits {
    /// W/sr and W/m²: numbers are used as they are.
    Watt,
    /// lm/sr and lm/m², with 683 lm/W: the units of the extension.
    Lumen,
    /// Points and spots in W, directional lights in W/m²: Blender's own numbers.
    Raw,
}
