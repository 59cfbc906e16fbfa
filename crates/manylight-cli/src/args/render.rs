//! Options of `render`.

use super::denoise::DenoiseArgs;
use super::frames::FrameArgs;
use super::gltf::GltfArgs;
use super::kept_lights::KeptLightArgs;
use super::parts::PartArgs;
use super::picture::PictureArgs;
use super::written;
use crate::light_options::LightArgs;
use crate::names::one_of;
use crate::preset::{self, Preset};
use crate::values::{self, Crop, MaxDepth};
use clap::{Args, ValueEnum, ValueHint};
use manylight::film::Filter;
use manylight::math::UVec2;
use manylight::render::Budget;
use manylight_lab::text::parse_duration;
use manylight_preview::PreviewTarget;
use serde::Serialize;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

/// Options of `render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Scene file: Mitsuba XML, PBRT, or glTF 2.0 (gltf, glb).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Image file; the extension selects the format: exr (linear values, all layers, settings), png
    /// or jpg (sRGB), hdr, pfm. May be repeated. Default: the name of the folder of the scene with
    /// .exr and .png, in the current folder.
    #[arg(short, long = "output", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Method and paths.
    #[command(flatten)]
    pub(crate) paths: PathArgs,

    /// Threads and warnings.
    #[command(flatten)]
    pub(crate) run: RunArgs,

    /// Refuse to start if the estimated memory exceeds this size, such as 8G or 512M. Default: what
    /// the machine or its control group has left.
    #[arg(
        long,
        value_name = "SIZE",
        value_parser = values::bytes,
        env = "MANYLIGHT_MEMORY_LIMIT",
        hide_env_values = true
    )]
    pub(crate) memory_limit: Option<u64>,

    /// Layers and colors of pictures.
    #[command(flatten)]
    pub(crate) picture: PictureArgs,

    /// Denoising.
    #[command(flatten)]
    pub(crate) denoise: DenoiseArgs,

    /// Options of the many-light methods.
    #[command(flatten)]
    pub(crate) lights: LightArgs,

    /// Limits.
    #[command(flatten)]
    pub(crate) budget: BudgetArgs,

    /// Blocks, shares and checkpoints.
    #[command(flatten)]
    pub(crate) parts: PartArgs,

    /// Camera and film.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// Walkthroughs.
    #[command(flatten)]
    pub(crate) frames: FrameArgs,

    /// Kept lights.
    #[command(flatten)]
    pub(crate) kept: KeptLightArgs,

    /// glTF scenes.
    #[command(flatten)]
    pub(crate) gltf: GltfArgs,

    /// Show the picture while it grows: in the viewer tev (tev, tev:HOST:PORT; default
    /// 127.0.0.1:14158), or in a browser on this machine, at an address that is printed (browser,
    /// browser:PORT; default: any free port).
    #[arg(long, value_name = "VIEWER", help_heading = "Display")]
    pub(crate) preview: Option<PreviewTarget>,

    /// Messages and progress.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
}

/// Options of `render` and `maps` for the method and its paths.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub(crate) struct PathArgs {
    /// Rendering method. A name stands for a preset of the options under "Virtual lights".
    #[arg(short, long, value_name = "NAME", default_value = preset::DEFAULT, value_parser = preset::parser())]
    #[serde(skip)]
    pub(crate) method: &'static Preset,

    /// Longest path, counted as in Mitsuba: 1 = emission only, 2 = direct light, -1 = no limit.
    /// Default: the limit of the scene.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::max_depth)]
    pub(crate) max_depth: Option<MaxDepth>,

    /// Hide emitters from the camera.
    #[arg(long)]
    pub(crate) hide_emitters: bool,

    /// Value of a scene parameter `$name` (Mitsuba XML). May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    #[serde(serialize_with = "written::defines")]
    pub(crate) defines: Vec<(String, String)>,

    /// Seed of the random numbers. Images with the same seed are identical to the bit, for any
    /// number of threads.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = values::seed)]
    pub(crate) seed: u64,
}

/// Options of `render` and `maps` that do not change the picture.
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub(crate) struct RunArgs {
    /// Number of threads, from 1 to 1024. Default: one per processor.
    #[arg(short, long, value_name = "N", value_parser = values::threads)]
    pub(crate) threads: Option<NonZeroU32>,

    /// Treat warnings about the scene as errors: unsupported or suspicious features.
    #[arg(long)]
    pub(crate) strict: bool,
}

impl RunArgs {
    /// Number of threads; `None` for one per processor.
    pub(crate) fn threads(&self) -> Option<usize> {
        self.threads.map(|n| n.get() as usize)
    }
}

/// Limits of a render. It stops at the first one.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "When to stop")]
pub(crate) struct BudgetArgs {
    /// Samples per pixel of path tracing, or passes, which with virtual lights have several camera
    /// paths per pixel. Where auto chooses path tracing, as many samples as cost the same.
    /// Default: 16, or no limit with --time or --target-error.
    #[arg(long, visible_alias = "spp", value_name = "N", allow_negative_numbers = true, value_parser = values::count)]
    pub(crate) passes: Option<NonZeroU32>,

    /// Stop after the pass that ends closest to this time, such as 60s, 10m, 1h, without the time
    /// for loading the scene.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub(crate) time: Option<Duration>,

    /// Stop when the relative error of the picture that is written, denoised with --denoise, is at
    /// most this value with 95 % confidence: 0.02 or 2%.
    #[arg(long, value_name = "X", value_parser = values::relative_error)]
    pub(crate) target_error: Option<f32>,
}

impl BudgetArgs {
    /// Default number of passes of a render without time or error limit.
    pub(super) const DEFAULT_PASSES: u32 = 16;

    /// The limits, with the default number of passes if there is none.
    pub(crate) fn budget(&self) -> Budget {
        let is_open_ended = self.time.is_some() || self.target_error.is_some();
        let passes = self.passes.map(NonZeroU32::get);
        Budget {
            passes: passes.or((!is_open_ended).then_some(Self::DEFAULT_PASSES)),
            time: self.time,
            relative_error: self.target_error,
        }
    }
}

/// Options of camera and film. Each overrides a setting of the scene.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Camera and film")]
pub(crate) struct CameraArgs {
    /// Image size in pixels. The field of view refers to the same axis as in the scene.
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    #[serde(serialize_with = "written::size")]
    pub(crate) size: Option<UVec2>,

    /// Part of the image to render, in fractions of its width and height from the upper left
    /// corner.
    #[arg(long, value_name = "x0,x1,y0,y1", value_parser = values::crop)]
    pub(crate) crop: Option<Crop>,

    /// Index of the camera, counted from 0.
    #[arg(long, value_name = "I", default_value_t = 0)]
    pub(crate) sensor: usize,

    /// Reconstruction filter.
    #[arg(long, value_name = "NAME", value_parser = one_of::<Filter>())]
    #[serde(serialize_with = "written::optional_word")]
    pub(crate) filter: Option<Filter>,
}

/// Options of messages and progress.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Display")]
pub(crate) struct DisplayArgs {
    /// Print a JSON object with settings, times and counts on standard output at the end.
    #[arg(long)]
    pub(crate) json: bool,

    /// Display of the progress on standard error.
    #[arg(long, value_name = "KIND", value_enum, default_value_t)]
    pub(crate) progress: ProgressKind,

    /// Print errors only.
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,

    /// Print the settings and the time of each stage.
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

/// Display of the progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressKind {
    /// A bar on a terminal, lines otherwise.
    #[default]
    Auto,
    /// A bar.
    Bar,
    /// A line every few seconds.
    Plain,
    /// A line of JSON every few seconds.
    Json,
    /// Nothing.
    None,
}
