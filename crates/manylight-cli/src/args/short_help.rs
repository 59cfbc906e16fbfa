//! The short help of `render`: examples, and the options that most renders need. The long one has
//! all options.

use clap::Arg;

/// Examples at the top of both.
pub(super) const EXAMPLES: &str = "Examples:
  manylight render scene.xml --size 320x180 --preview browser   watch a small picture grow
  manylight render scene.xml --time 60s --denoise oidn          the best picture of one minute
  manylight render scene.pbrt -m path --passes 256 -o room.exr  a path-traced reference";

/// The last line of the short help.
pub(super) const MORE: &str = "`manylight render --help` lists all options.";

/// The arguments in the short help, by their names, and what it says of them; without a text, what
/// the long one says.
const SHOWN: &[(&str, Option<&str>)] = &[
    ("scene", None),
    (
        "outputs",
        Some("Image file: exr (linear, all layers), png, jpg, hdr, pfm. May be repeated"),
    ),
    (
        "method",
        Some("Rendering method; `manylight list methods` describes them"),
    ),
    ("threads", None),
    ("exposure", None),
    ("view", Some("Tone curve of png and jpg files")),
    ("denoise", Some("Denoise the image at the end")),
    (
        "passes",
        Some(
            "Passes, or path samples per pixel. Default: 16, or no limit with --time or --target-error",
        ),
    ),
    ("time", Some("Stop after this time, such as 60s, 10m, 1h")),
    ("target_error", None),
    ("size", Some("Image size in pixels")),
    (
        "preview",
        Some("Show the picture while it grows: tev, tev:HOST:PORT, browser, browser:PORT"),
    ),
];

/// Shortens the help of an argument, or hides it from the short help.
pub(super) fn shorten(argument: Arg) -> Arg {
    let is_same = |shown: &&(&str, _)| argument.get_id() == shown.0;
    match SHOWN.iter().find(is_same) {
        None => argument.hide_short_help(true),
        Some((_, None)) => argument,
        Some((_, Some(short))) => match argument.get_help().cloned() {
            Some(long) => argument.help(*short).long_help(long),
            None => argument.help(*short),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Cli;
    use clap::{Command, CommandFactory};

    /// Lines and columns of a small terminal window with a prompt below the help.
    const SCREEN: (usize, usize) = (45, 100);

    fn render() -> Command {
        let mut cli = Cli::command().term_width(SCREEN.1);
        cli.build();
        cli.find_subcommand("render").unwrap().clone()
    }

    #[test]
    fn the_short_help_fits_a_screen() {
        let text = render().render_help().to_string();
        assert!(text.lines().count() <= SCREEN.0, "{text}");
        assert!(text.starts_with("Examples:"), "{text}");
        assert!(text.trim_end().ends_with(MORE), "{text}");
    }

    #[test]
    fn the_long_help_has_all_options() {
        let command = render();
        let text = command.clone().render_long_help().to_string();
        for (name, _) in SHOWN {
            let is_known = command.get_arguments().any(|a| a.get_id() == *name);
            assert!(is_known, "there is no {name}");
        }
        for name in command.get_arguments().filter_map(Arg::get_long) {
            assert!(text.contains(&format!("--{name}")), "{name}");
        }
        assert!(!text.contains(MORE), "{text}");
    }
}
