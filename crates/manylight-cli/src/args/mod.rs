//! The definition of the command line. `request` gives the options of `render` their meaning.
//!
//! An option is a field of a group: its doc comment is the help, `arg` says how it is read, `serde`
//! how it is written. Reports, image files and the command that repeats a render write the groups
//! of a request as they are (`repeat`), and Python's keywords are the names of the options. The
//! options of virtual lights are rows of a table, `light_options`.

mod denoise;
mod frames;
mod gltf;
mod inspect;
mod kept_lights;
mod measure;
mod parts;
mod picture;
mod render;
mod short_help;
mod written;

#[cfg(test)]
pub(crate) use denoise::Denoiser;

pub(crate) use denoise::DenoiseArgs;
pub(crate) use frames::{FrameArgs, SteadyArgs};
pub(crate) use gltf::GltfArgs;
pub(crate) use inspect::{
    CheckArgs, CompletionsArgs, InfoArgs, ListArgs, Listing, MapsArgs, SceneFormat,
};
pub(crate) use kept_lights::KeptLightArgs;
pub(crate) use measure::{CompareArgs, StudyArgs};
pub(crate) use parts::{MergeArgs, PartArgs, RelightArgs};
pub(crate) use picture::{FileArgs, PictureArgs};
pub(crate) use render::{CameraArgs, DisplayArgs, PathArgs, ProgressKind, RenderArgs, RunArgs};

use clap::{Parser, Subcommand};

const EXIT_CODES: &str = "Exit codes: 0 done; 1 internal or render failure; 2 usage; 3 scene error; 4 file system; \
5 a missing optional component; 6 --strict found a warning; 129, 130, 143 ended by a signal (image written).
Environment: MANYLIGHT_SIMD=avx512|avx2|portable selects the instructions; MANYLIGHT_MEMORY_LIMIT=SIZE is the default of \
--memory-limit; OIDN_DIR is the folder of Open Image Denoise.";

/// A photorealistic many-light renderer.
#[derive(Debug, Parser)]
#[command(name = "manylight", version, after_help = EXIT_CODES, propagate_version = false)]
pub(crate) struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to image files.
    #[command(mut_args = short_help::shorten, before_help = short_help::EXAMPLES, after_help = short_help::MORE, after_long_help = EXIT_CODES)]
    Render(Box<RenderArgs>),
    /// Write maps of importance and incident flux, and the positions of virtual lights, as images.
    Maps(Box<MapsArgs>),
    /// Merge the parts of a render to image files.
    Merge(MergeArgs),
    /// Weigh the light groups of an image anew, without a render.
    Relight(RelightArgs),
    /// Average the frames of a walkthrough in time, so that their noise does not flicker.
    Steady(SteadyArgs),
    /// Measure how images differ from a reference.
    Compare(CompareArgs),
    /// Measure methods on scenes according to a plan, and write a page of tables.
    Study(StudyArgs),
    /// Describe a scene: triangles, materials, emitters, cameras, memory.
    Info(InfoArgs),
    /// Report all errors and warnings of a scene file without rendering.
    Check(CheckArgs),
    /// List methods, or the plugins that scene files may use.
    List(ListArgs),
    /// Print a completion script for a shell.
    Completions(CompletionsArgs),
}

#[cfg(test)]
mod tests {
    use super::render::BudgetArgs;
    use super::*;
    use crate::values::{MAX_THREADS, TABLE_SIZES};
    use clap::CommandFactory;
    use manylight::film::blocks::BLOCK_STEP;
    use manylight::integrators::many_light::{GlossyForm, PHOTON_PATHS_PER_LIGHT};
    use manylight_preview::PreviewTarget;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn figures_of_the_help_are_those_of_the_code() {
        let command = Cli::command();
        let render = command.find_subcommand("render").unwrap();
        let help = |name: &str| {
            let named = |argument: &&clap::Arg| argument.get_long() == Some(name);
            let found = render.get_arguments().find(named).unwrap();
            let text = found.get_long_help().or(found.get_help());
            text.unwrap().to_string()
        };
        for (option, figures) in [
            (
                "photons",
                format!("at least {PHOTON_PATHS_PER_LIGHT} per virtual light"),
            ),
            ("lobes", format!("from 1 to {}", GlossyForm::MAX_LOBES)),
            (
                "table-size",
                format!("from {} to {}", TABLE_SIZES.start(), TABLE_SIZES.end()),
            ),
            ("threads", format!("from 1 to {MAX_THREADS}")),
            ("block", format!("a multiple of {BLOCK_STEP}")),
            ("passes", format!("Default: {}", BudgetArgs::DEFAULT_PASSES)),
            (
                "preview",
                match "tev".parse() {
                    Ok(PreviewTarget::Tev(address)) => format!("default {address}"),
                    other => panic!("{other:?}"),
                },
            ),
        ] {
            let text = help(option);
            assert!(text.contains(&figures), "{text}: {figures}");
        }
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
        assert!(message(&["--denoise", "oidm"]).contains("oidn"));
        assert!(message(&["--oidn-lib", "x.so"]).contains("--denoise"));
        assert!(message(&["--shard", "3/2"]).contains("from 1 to N"));
        assert!(message(&["--block", "12"]).contains("a multiple of 8"));
        assert!(message(&["--passes", "0"]).contains("invalid value '0'"));
    }
}
