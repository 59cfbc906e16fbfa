//! The definition of the command line. `request` gives the options of `render` their meaning.

mod gltf;
mod inspect;
mod lights;
mod measure;
mod parts;
mod picture;
mod render;

pub(crate) use gltf::{Units, environment_name};
pub(crate) use inspect::{
    CheckArgs, CompletionsArgs, InfoArgs, ListArgs, Listing, MapsArgs, SceneFormat,
};
pub(crate) use lights::LightArgs;
pub(crate) use measure::{CompareArgs, StudyArgs};
pub(crate) use parts::MergeArgs;
pub(crate) use picture::{FileArgs, PictureArgs};
pub(crate) use render::{CameraArgs, Denoiser, DisplayArgs, PathArgs, ProgressKind, RenderArgs};

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
    Render(Box<RenderArgs>),
    /// Write maps of importance and incident flux, and the positions of virtual lights, as images.
    Maps(Box<MapsArgs>),
    /// Merge the parts of a render to image files.
    Merge(MergeArgs),
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
        assert!(message(&["--denoise", "oidm"]).contains("oidn"));
        assert!(message(&["--oidn-lib", "x.so"]).contains("--denoise"));
        assert!(message(&["--shard", "3/2"]).contains("from 1 to N"));
        assert!(message(&["--block", "12"]).contains("a multiple of 8"));
        assert!(message(&["--passes", "0"]).contains("invalid value '0'"));
    }
}
