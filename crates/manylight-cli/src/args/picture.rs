//! Options of pictures: their layers, and how values become colors.

use super::written;
use crate::names::{AovNames, Named, one_of};
use crate::values::{self, GroupRule};
use clap::{Args, ValueEnum, ValueHint};
use manylight::integrators::{ExtraLayers, MethodKind};
use manylight_io::image::{DisplayTransform, View};
use serde::Serialize;
use std::path::PathBuf;

/// Options of pictures.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Pictures")]
pub(crate) struct PictureArgs {
    /// Colors, and names of layers.
    #[command(flatten)]
    #[serde(skip)]
    pub(crate) file: FileArgs,

    /// More layers in exr files, separated by commas; the method aov has all of them: position;
    /// object and material, as Cryptomatte.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    #[serde(serialize_with = "written::list")]
    pub(crate) aov: Vec<Aov>,

    /// Write a layer for each light group, and its variance, to exr files: the light of emitters
    /// with one name, as the scene or rules say. The layers sum to the image; `manylight relight`
    /// weighs them.
    #[arg(long)]
    pub(crate) light_groups: bool,

    /// A light group, which switches these layers on: emitters with names that PATTERN matches (*
    /// any text, ? any letter). May be repeated, or separated by commas; the first rule that
    /// matches decides. Emitters without a rule form the group rest.
    #[arg(long, value_name = "NAME=PATTERN", value_delimiter = ',', value_parser = values::group_rule)]
    #[serde(serialize_with = "written::group_rules")]
    pub(crate) light_group: Vec<GroupRule>,
}

/// Options of image files.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
#[command(next_help_heading = "Pictures")]
pub(crate) struct FileArgs {
    /// How values become colors.
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) tone: ToneArgs,

    /// Names of the layers in exr files.
    #[arg(long, value_name = "NAMES", value_parser = one_of::<AovNames>(), default_value = AovNames::NAMES[0].0)]
    #[serde(serialize_with = "written::word")]
    pub(crate) aov_names: AovNames,
}

/// How values become colors of 8 bits.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize)]
pub(crate) struct ToneArgs {
    /// Exposure of png and jpg files in stops.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = values::finite)]
    exposure: f32,

    /// Tone curve of png and jpg files: standard clips values at 1, neutral is Khronos PBR Neutral,
    /// agx is the AgX of Blender.
    #[arg(long, value_name = "NAME", value_parser = one_of::<View>(), default_value = View::NAMES[0].0)]
    #[serde(serialize_with = "written::word")]
    view: View,
}

/// Options of commands that make a picture of pictures.
#[derive(Clone, Debug, Args)]
pub(crate) struct DerivedArgs {
    /// Image file; the extension selects the format: exr, png, jpg, hdr, pfm. May be repeated.
    #[arg(short, long = "output", value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) outputs: Vec<PathBuf>,

    /// How values become colors.
    #[command(flatten)]
    pub(crate) tone: ToneArgs,

    /// Print a JSON object on standard output at the end.
    #[arg(long)]
    pub(crate) json: bool,

    /// Print errors only.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// A layer on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Aov {
    /// Positions in world space.
    Position,
    /// Mattes of objects.
    Object,
    /// Mattes of materials.
    Material,
    /// All of these.
    All,
}

impl PictureArgs {
    /// The layers to record beyond those of the method `kind`, but those of light groups.
    pub(crate) fn extra_layers(&self, kind: &MethodKind) -> ExtraLayers {
        let is_all = *kind == MethodKind::Aov || self.aov.contains(&Aov::All);
        let has = |aov| is_all || self.aov.contains(&aov);
        ExtraLayers {
            position: has(Aov::Position),
            objects: has(Aov::Object),
            materials: has(Aov::Material),
            light_groups: 0,
            picture_only: false,
        }
    }

    /// Whether pictures have a layer for each light group.
    pub(crate) fn has_light_groups(&self) -> bool {
        self.light_groups || !self.light_group.is_empty()
    }
}

impl ToneArgs {
    /// The transform of values.
    pub(crate) fn display(&self) -> DisplayTransform {
        DisplayTransform {
            exposure_ev: self.exposure,
            view: self.view,
        }
    }
}
