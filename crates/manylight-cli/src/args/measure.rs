//! Options of `compare` and `study`.

use clap::{Args, ValueHint};
use std::path::PathBuf;

/// Options of `compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub(crate) struct CompareArgs {
    /// Images to measure.
    #[arg(value_name = "IMAGE", required = true, num_args = 1.., value_hint = ValueHint::FilePath)]
    pub(crate) images: Vec<PathBuf>,

    /// Reference image.
    #[arg(value_name = "REFERENCE", value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,

    /// Compare a layer of both files, such as virtual_lights or caustics, instead of the image. The
    /// end of its name is enough if only one has it: Combined for Blender's ViewLayer.Combined.
    #[arg(long, value_name = "NAME")]
    pub(crate) layer: Option<String>,

    /// Print JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,

    /// Write an HTML page to inspect the images side by side or split, with zoom, exposure and
    /// error maps. It is one self-contained file.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) html: Option<PathBuf>,
}

const COMPARE_HELP: &str = "\
Definitions, with x the image, r the reference, m the mean of r; averages over pixels and channels of linear values:
  MSE      (x - r)^2
  relMSE   (x - r)^2 / (r^2 + 0.01 m^2); of 8x8 blocks, that of their means: noise that neighbors share, as a filter leaves it
  MAPE     |x - r| / max(|r|, 0.01 m)
  SMAPE    |x - r| / max(|x| + |r|, 0.01 m)
  PSNR     10 log10(p^2 / MSE), p the largest value of r
  SSIM     structural similarity (Wang et al. 2004) of the luma of sRGB values in [0, 1], window 11x11
  HDR-FLIP mean perceived difference when alternating between the images (Andersson et al. 2021), 67 pixels per degree
  pixels   quantiles over pixels of the square root of the pixel's relMSE
If both files contain the variance of the pixel means (variance.R/G/B):
  noise    expected MSE and relMSE if the images differed by noise alone, and the part of the reference
  z        (x - r) / sqrt(var x + var r) of the means of 8x8 blocks, per channel, with a rounding error of 1e-6 r
Pixels that share virtual lights have correlated errors. Images of this program therefore contain the variances of block means
(block_variance.R/G/B) and of the mean of the image (variance_of_mean), estimated from independent batches of passes. Standard errors and z
use them if they are present; z is converted from Student's distribution to a normal variable of the same tail probability.
If the image contains error bars (error.R/G/B, block_error.R/G/B), half-widths of intervals at 95 %:
  within error bars   pixels and 8x8 blocks with |x - r| <= sqrt(bar^2 + 1.96^2 var r); 95 % are expected";

/// Options of `study`.
#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// Plan of the measurements (JSON).
    #[arg(value_name = "PLAN", value_hint = ValueHint::FilePath)]
    pub(crate) plan: PathBuf,

    /// Scale of the plan, such as quick or full. Default: its first scale, if it has any.
    #[arg(long, value_name = "NAME")]
    pub(crate) scale: Option<String>,

    /// Folder of the scene files of the plan. Default: the environment variable MANYLIGHT_SCENES.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) scenes: Option<PathBuf>,

    /// Folder of the references of the plan. Default: the environment variable
    /// MANYLIGHT_REFERENCES.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) references: Option<PathBuf>,

    /// Folder of the results, with one file per run. Default: `results` beside the plan, and in it
    /// one folder per scale.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) results: Option<PathBuf>,

    /// Markdown page to write. Default: the page that the plan names.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) page: Option<PathBuf>,

    /// Folder in which the images of the runs are kept, as exr and png. Default: they are deleted
    /// after the comparison.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) images: Option<PathBuf>,

    /// Folder of an HTML page, index.html, to inspect the kept images together with the tables.
    #[arg(long, value_name = "DIR", requires = "images", value_hint = ValueHint::DirPath)]
    pub(crate) html: Option<PathBuf>,

    /// Make only runs of the scene, method or task with this name, or, if there is none, with a
    /// name that contains it. May be repeated: names of one kind are alternatives, and runs must
    /// match in each kind that is named.
    #[arg(long, value_name = "TEXT")]
    pub(crate) only: Vec<String>,

    /// Repeat runs that have a result already.
    #[arg(long)]
    pub(crate) again: bool,

    /// Write the page from the existing results without rendering.
    #[arg(long, conflicts_with_all = ["again", "only"])]
    pub(crate) page_only: bool,
}
