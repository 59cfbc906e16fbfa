//! `manylight list`.

use crate::args::{ListArgs, Listing, SceneFormat};
use crate::failure::{DONE, Failure};
use crate::light_options::settings;
use crate::output::print_data;
use crate::preset::{PRESETS, Preset};
use clap::ValueEnum;

/// Prints a list of names.
pub(crate) fn run(args: &ListArgs) -> Result<u8, Failure> {
    let lines: Vec<String> = match args.what {
        Listing::Methods => PRESETS.iter().map(describe).collect(),
        family => plugins(family, args.format)
            .iter()
            .map(ToString::to_string)
            .collect(),
    };
    print_data(lines.join("\n"))?;
    Ok(DONE)
}

/// The supported plugins of one family in one format.
fn plugins(family: Listing, format: SceneFormat) -> &'static [&'static str] {
    let typed = family
        .to_possible_value()
        .expect("invariant: every listing can be typed");
    let format = format
        .to_possible_value()
        .expect("invariant: every format can be typed");
    manylight_io::supported()
        .find(|f| f.name == typed.get_name() && f.format == format.get_name())
        .map_or(&[], |f| f.plugins)
}

/// A preset with its settings as options.
fn describe(preset: &Preset) -> String {
    let head = format!("{:<17} {}", preset.name, preset.summary);
    let settings = settings(&(preset.kind)());
    if settings.is_empty() {
        return head;
    }
    let options: Vec<String> = settings
        .into_iter()
        .map(|(name, value)| format!("--{name} {value}"))
        .collect();
    format!("{head}\n{:<18}{}", "", options.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_show_their_settings() {
        let text = describe(crate::preset::find("rich-vpl").unwrap());
        assert!(text.starts_with("rich-vpl"));
        assert!(
            text.contains(
                "--placement importance --flux partition --emission table --table-size 48"
            )
        );
        assert!(!describe(crate::preset::find("path").unwrap()).contains("--"));
    }

    #[test]
    fn every_family_has_plugins() {
        for listing in Listing::value_variants() {
            for format in SceneFormat::value_variants() {
                assert!(
                    *listing == Listing::Methods || !plugins(*listing, *format).is_empty(),
                    "{listing:?} {format:?}"
                );
            }
        }
    }
}
