//! Renders for programs that keep scenes and pictures in memory, such as the Python package.
//!
//! Settings are words of the command line of `manylight render`, so that both doors have the same
//! names, defaults and messages.

mod frames;
mod held_scene;
mod options;
mod parts;
mod relight;
mod render;

pub use crate::interim::interim_maps;
pub use crate::values::relative_error;
pub use frames::frame_file;
pub use held_scene::HeldScene;
pub use options::{RenderOption, keeps_lights, pass_limit, render_options};
pub use parts::{PartBlocks, merge, part_header, render_part};
pub use relight::relit;
pub use render::{DEFAULT_VIEW, Picture, Rendered, display_transform};
