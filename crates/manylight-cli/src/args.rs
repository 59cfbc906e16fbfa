//! What can be typed. Meaning and cross-checks are in `request`.

use crate::preset::{self, PRESETS, Preset};
use crate::values::{
    self, COMPENSATIONS, Crop, EMISSIONS, EmissionName, FILTERS, FLUX_RULES, KERNELS, MaxDepth,
    PLACEMENTS, RESAMPLINGS, STRATEGIES, StrategyName, TABLE_STORAGES,
};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use clap_complete::Shell;
use manylight::film::Filter;
use manylight::integrators::many_light::{
    ClampRule, Compensation, FluxRule, GlossyForm, Kernel, Placement, Resampling, TableStorage,
};
use manylight::math::UVec2;
use manylight_lab::text::parse_duration;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

const EXIT_CODES: &str = "Exit codes: 0 done; 1 internal or render failure; 2 usage; 3 scene error; 4 file system; \
6 --strict found something; 130, 143 ended by a signal (image written).";

/// A photorealistic many-light renderer.
#[derive(Debug, Parser)]
#[command(name = "manylight", version, after_help = EXIT_CODES, propagate_version = false)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to image files.
    Render(Box<RenderArgs>),
    /// Show what the placement of virtual lights follows, and where they stand.
    Maps(Box<MapsArgs>),
    /// Measure how images differ from a reference.
    Compare(CompareArgs),
    /// Measure methods on scenes by a plan, and write a page of tables.
    Study(StudyArgs),
    /// Describe a scene: triangles, materials, emitters, cameras, memory.
    Info(InfoArgs),
    /// Report every error and warning of a scene file; nothing is rendered.
    Check(CheckArgs),
    /// List what can be named: methods, and the plugins that scene files may use.
    List(ListArgs),
    /// Print a completion script for a shell.
    Completions(CompletionsArgs),
}

/// Options of `render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Scene file (Mitsuba XML).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Image to write, by extension: exr (linear, all layers, settings), png, jpg (sRGB), hdr, pfm. May be repeated.
    /// Default: the scene's folder name with .exr and .png, in the current folder.
    #[arg(short, long = "output", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) outputs: Vec<PathBuf>,

    /// The method, and how its paths go.
    #[command(flatten)]
    pub(crate) paths: PathArgs,

    /// Refuse a render that would take more memory, such as 8G or 512M.
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub(crate) memory_limit: Option<u64>,

    /// Brightness of png and jpg files, in stops.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = values::finite)]
    pub(crate) exposure: f32,

    /// Options of the many-light methods.
    #[command(flatten)]
    pub(crate) lights: LightArgs,

    /// When to stop.
    #[command(flatten)]
    pub(crate) budget: BudgetArgs,

    /// Camera and film.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// What is shown meanwhile.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
}

/// What `render` and `maps` have in common about the method and its paths.
#[derive(Debug, Args)]
pub(crate) struct PathArgs {
    /// How to render; a name is a preset of the options under "Virtual lights".
    #[arg(short, long, value_name = "NAME", default_value = preset::DEFAULT, value_parser = preset_parser())]
    pub(crate) method: &'static Preset,

    /// Longest path as Mitsuba counts: 1 = emitters only, 2 = direct light, -1 = no limit. Default: the scene's.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::max_depth)]
    pub(crate) max_depth: Option<MaxDepth>,

    /// Do not show emitters to the camera.
    #[arg(long)]
    pub(crate) hide_emitters: bool,

    /// Value of a scene parameter `$name`. May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    pub(crate) defines: Vec<(String, String)>,

    /// Seed of all random numbers: the same seed gives the same bits for any number of threads.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Number of threads. Default: one per processor.
    #[arg(short, long, value_name = "N")]
    pub(crate) threads: Option<NonZeroU32>,

    /// Treat an unsupported or suspicious scene feature as an error.
    #[arg(long)]
    pub(crate) strict: bool,
}

/// Options of the many-light methods; each overrides one setting of the preset.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Virtual lights")]
pub(crate) struct LightArgs {
    /// Virtual lights per pass; photons that none of them may take get a few more. Default: the preset's.
    #[arg(short = 'n', long, value_name = "N")]
    pub(crate) lights: Option<NonZeroU32>,

    /// Emitted photon paths per pass. Default: the preset's, and at least 64 for each virtual light.
    #[arg(long, value_name = "N")]
    pub(crate) photons: Option<NonZeroU32>,

    /// Where lights stand.
    #[arg(long, value_name = "RULE", value_parser = values::one_of(PLACEMENTS))]
    pub(crate) placement: Option<Placement>,

    /// How much flux each light carries.
    #[arg(long, value_name = "RULE", value_parser = values::one_of(FLUX_RULES))]
    pub(crate) flux: Option<FluxRule>,

    /// What each light shines.
    #[arg(long, value_name = "KIND", value_parser = values::one_of(EMISSIONS))]
    pub(crate) emission: Option<EmissionName>,

    /// Texels along an edge of an emission table, even, from 8 to 128.
    #[arg(long, value_name = "N", value_parser = values::table_size)]
    pub(crate) table_size: Option<u32>,

    /// How a texel is stored: in 12 or 4 bytes.
    #[arg(long, value_name = "KIND", value_parser = values::one_of(TABLE_STORAGES))]
    pub(crate) table_storage: Option<TableStorage>,

    /// Von Mises-Fisher lobes per light, from 1 to 8.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(GlossyForm::MAX_LOBES)))]
    pub(crate) lobes: Option<u32>,

    /// How one light is evaluated.
    #[arg(long, value_name = "KIND", value_parser = values::one_of(KERNELS))]
    pub(crate) kernel: Option<Kernel>,

    /// Which lights are evaluated.
    #[arg(long, value_name = "KIND", value_parser = values::one_of(STRATEGIES))]
    pub(crate) strategy: Option<StrategyName>,

    /// Lightcuts: no cluster of lights may be off by more than this share of what a point reflects.
    #[arg(long, value_name = "SHARE", value_parser = values::share)]
    pub(crate) max_error: Option<f32>,

    /// Lightcuts: most lights and clusters that a sum is made of, whatever the error.
    #[arg(long, value_name = "N")]
    pub(crate) max_cut: Option<NonZeroU32>,

    /// Bound of the singularity: none, auto (by what each light stands for), fixed (by the median of that) or a value in 1/m².
    #[arg(long, value_name = "none|auto|fixed|VALUE", value_parser = values::clamp)]
    pub(crate) clamp: Option<ClampRule>,

    /// How the light that the clamp takes away is given back.
    #[arg(long, value_name = "RULE", value_parser = values::one_of(COMPENSATIONS))]
    pub(crate) compensation: Option<Compensation>,

    /// Photons that say what a light shines where --flux is density.
    #[arg(long, value_name = "N")]
    pub(crate) neighbors: Option<NonZeroU32>,

    /// Which lights the passes have: all the same, each new ones, or new ones that become finer, so that the image goes to the
    /// right one.
    #[arg(long, value_name = "KIND", value_parser = values::one_of(RESAMPLINGS))]
    pub(crate) resampling: Option<Resampling>,
}

/// When to stop: at the first limit that is reached.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "When to stop")]
pub(crate) struct BudgetArgs {
    /// Samples per pixel in all; a pass is one sample per pixel with its own lights.
    /// Default: 16, or no limit where --time or --target-error is given.
    #[arg(long, visible_alias = "spp", value_name = "N")]
    pub(crate) passes: Option<NonZeroU32>,

    /// Stop after the pass that ends nearest to this, such as 60s, 10m, 1h. Loading does not count.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub(crate) time: Option<Duration>,

    /// Stop when the estimated relative error of the image is below this.
    #[arg(long, value_name = "X", value_parser = values::positive)]
    pub(crate) target_error: Option<f32>,
}

/// Camera and film; each overrides what the scene says.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Camera and film")]
pub(crate) struct CameraArgs {
    /// Film size in pixels; the scene's field of view rule is kept.
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub(crate) size: Option<UVec2>,

    /// Render a part of the film, in fractions of its size; y grows downwards.
    #[arg(long, value_name = "x0,x1,y0,y1", value_parser = values::crop)]
    pub(crate) crop: Option<Crop>,

    /// Which of the scene's cameras, counted from 0.
    #[arg(long, value_name = "I", default_value_t = 0)]
    pub(crate) sensor: usize,

    /// Reconstruction filter.
    #[arg(long, value_name = "NAME", value_parser = values::one_of(FILTERS))]
    pub(crate) filter: Option<Filter>,
}

/// What is shown.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Display")]
pub(crate) struct DisplayArgs {
    /// Print one JSON object with settings, times and counts on standard output at the end.
    #[arg(long)]
    pub(crate) json: bool,

    /// How progress is shown on standard error.
    #[arg(long, value_name = "KIND", value_enum, default_value_t)]
    pub(crate) progress: ProgressKind,

    /// Print errors only.
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,

    /// Print settings, and the time of every stage.
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressKind {
    /// A bar on a terminal, lines elsewhere.
    #[default]
    Auto,
    /// A bar.
    Bar,
    /// A line every few seconds.
    Plain,
    /// JSON lines.
    Json,
    /// Nothing.
    None,
}

/// Options of `maps`.
#[derive(Debug, Args)]
#[command(after_help = MAPS_HELP)]
pub(crate) struct MapsArgs {
    /// Scene file (Mitsuba XML).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Folder to write to; made where there is none.
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) output: PathBuf,

    /// The method, and how its paths go; a method with virtual lights.
    #[command(flatten)]
    pub(crate) paths: PathArgs,

    /// Print errors only.
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Options of the many-light methods; what is not about photons and placement changes nothing here.
    #[command(flatten)]
    pub(crate) lights: LightArgs,

    /// Camera and film.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
}

const MAPS_HELP: &str = "\
Of the first pass, at the first surface with smooth lobes that each pixel sees by specular events:
  importance.png  importance that arrives from the points that sum lights, in 1/m²
  radiance.png    flux of the photons that may become lights, as irradiance in W/m²
  product.png     importance times luminance of irradiance: what placement by importance follows
  maps.exr        these three as numbers, with the scales of the colors
  placement.png   a dot for each light that the camera sees straight
  relaxed.png     the same lights, pushed apart
Colors are logarithmic from the 1st to the 99.5th percentile of what is not 0, violet to yellow; black is 0.";

/// Options of `compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub(crate) struct CompareArgs {
    /// Images to measure.
    #[arg(value_name = "IMAGE", required = true, num_args = 1.., value_hint = ValueHint::FilePath)]
    pub(crate) images: Vec<PathBuf>,

    /// What they should look like.
    #[arg(value_name = "REFERENCE", value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,

    /// Compare a layer that both files have, such as virtual_lights or caustics, instead of the image.
    #[arg(long, value_name = "NAME")]
    pub(crate) layer: Option<String>,

    /// Print JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,

    /// Write a page to look at the images: side by side or split, with zoom, exposure and maps of errors. One file, for any browser.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) html: Option<PathBuf>,
}

const COMPARE_HELP: &str = "\
Definitions, x the image, r the reference, m the mean of r, averages over pixels and channels, linear values:
  MSE      (x - r)^2
  relMSE   (x - r)^2 / (r^2 + 0.01 m^2)
  MAPE     |x - r| / max(|r|, 0.01 m)
  SMAPE    |x - r| / max(|x| + |r|, 0.01 m)
  PSNR     10 log10(p^2 / MSE), p the largest value of r
  SSIM     structural similarity (Wang et al. 2004) of the luma of sRGB values in [0, 1], window 11x11
  HDR-FLIP mean over pixels of how much is seen in turning from one to the other (Andersson et al. 2021), 67 pixels per degree
  pixels   quantiles over pixels of sqrt(relMSE of the pixel)
Where both files carry variance.R/G/B (of the mean):
  noise    what MSE and relMSE would be on average if only noise differed, and the reference's part of it
  z        of 8x8 blocks and channels, (x - r) / sqrt(var x + var r); differences of 1e-6 r are rounding
Pixels that share virtual lights are off together: images of this program carry block_variance.R/G/B, and for the whole picture
variance_of_mean, from the spread over batches of passes with nothing in common. Standard errors and z go by these where they are,
z by Student's distribution: as large as a normal variable that is as rare.";

/// Options of `study`.
#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// What to measure (JSON).
    #[arg(value_name = "PLAN", value_hint = ValueHint::FilePath)]
    pub(crate) plan: PathBuf,

    /// Which of the plan's scales, such as quick or full. Default: its first, if it has any.
    #[arg(long, value_name = "NAME")]
    pub(crate) scale: Option<String>,

    /// Folder that the plan's scene files are relative to. Default: the variable MANYLIGHT_SCENES.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) scenes: Option<PathBuf>,

    /// Folder that the plan's references are relative to. Default: the variable MANYLIGHT_REFERENCES.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) references: Option<PathBuf>,

    /// Folder of the results, one file per run. Default: `results` beside the plan, and in it a folder for the scale.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) results: Option<PathBuf>,

    /// Page to write. Default: the plan's.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) page: Option<PathBuf>,

    /// Keep the pictures of the runs, as exr and png. Default: they are removed once measured.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) images: Option<PathBuf>,

    /// Also write a page to look at the pictures that are kept, with the tables: index.html in this folder.
    #[arg(long, value_name = "DIR", requires = "images", value_hint = ValueHint::DirPath)]
    pub(crate) html: Option<PathBuf>,

    /// Only runs whose scene, method or task is called so or, if none is, contains it. May be repeated: several of
    /// one kind add up, and every kind that is named must fit.
    #[arg(long, value_name = "TEXT")]
    pub(crate) only: Vec<String>,

    /// Repeat runs that have a result.
    #[arg(long)]
    pub(crate) again: bool,

    /// Render nothing; write the page from the results that are there.
    #[arg(long, conflicts_with_all = ["again", "only"])]
    pub(crate) page_only: bool,
}

/// Options of `info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene file (Mitsuba XML).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Value of a scene parameter `$name`. May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    pub(crate) defines: Vec<(String, String)>,

    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scene file (Mitsuba XML).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Value of a scene parameter `$name`. May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = values::define)]
    pub(crate) defines: Vec<(String, String)>,

    /// Treat warnings as errors.
    #[arg(long)]
    pub(crate) strict: bool,
}

/// Options of `list`.
#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// What to list.
    #[arg(value_enum, value_name = "WHAT")]
    pub(crate) what: Listing,
}

/// What can be listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// Methods with their settings.
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
    /// Integrators of scene files, whose path lengths are taken over.
    Integrators,
}

/// Options of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Which shell.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

fn preset_parser() -> impl TypedValueParser<Value = &'static Preset> {
    let names = PRESETS
        .iter()
        .map(|preset| PossibleValue::new(preset.name).help(preset.summary));
    PossibleValuesParser::new(names)
        .map(|name| preset::find(&name).expect("invariant: the parser accepts presets alone"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_near_miss_is_answered_with_the_nearest_name() {
        let message = |words: &[&str]| {
            let all = ["manylight", "render", "scene.xml"].iter().chain(words);
            Cli::try_parse_from(all).unwrap_err().to_string()
        };
        assert!(message(&["-m", "rich-vlp"]).contains("'rich-vpl'"));
        assert!(message(&["--pases", "3"]).contains("'--passes'"));
        assert!(message(&["--strategy", "lightcut"]).contains("lightcuts"));
        assert!(message(&["--max-error", "2"]).contains("from 0 to 1"));
        assert!(message(&["--size", "640"]).contains("WIDTHxHEIGHT"));
        assert!(message(&["--passes", "0"]).contains("invalid value '0'"));
    }
}
