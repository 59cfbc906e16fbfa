//! One file per subcommand.

pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod info;
pub(crate) mod list;
pub(crate) mod maps;
pub(crate) mod merge;
pub(crate) mod relight;
pub(crate) mod render;
pub(crate) mod steady;
pub(crate) mod study;
