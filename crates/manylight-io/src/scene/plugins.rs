//! Names of plugins: those that are supported, and reports of others.

use super::sink::{Problem, Sink, Text};
use crate::suggest::with_list;

/// The supported plugins of one family in one format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportedFamily {
    /// Format of the scene files: `mitsuba` or `pbrt`.
    pub format: &'static str,
    /// Plural name of the family, such as `bsdfs`.
    pub name: &'static str,
    /// Sorted names of the plugins.
    pub plugins: &'static [&'static str],
}

/// The families of a format, from their names and plugins.
pub(super) const fn families<const N: usize>(
    format: &'static str,
    named: [(&'static str, &'static [&'static str]); N],
) -> [SupportedFamily; N] {
    let mut families = [SupportedFamily {
        format,
        name: "",
        plugins: &[],
    }; N];
    let mut i = 0;
    while i < N {
        families[i].name = named[i].0;
        families[i].plugins = named[i].1;
        i += 1;
    }
    families
}

/// Reports that no plugin of the `family` has this name. `label` completes the report, and `list`
/// gives all names.
pub(super) fn report_unknown<'n>(
    sink: &Sink,
    (family, plugin): (&str, &Text),
    known: impl IntoIterator<Item = &'n str>,
    (label, list): (String, String),
) {
    let message = format!("unknown {family} type `{}`", plugin.value);
    let problem = Problem::new("scene::unknown_plugin", plugin.span, message);
    sink.error(
        problem
            .label(label)
            .help(with_list(&plugin.value, known, list)),
    );
}
