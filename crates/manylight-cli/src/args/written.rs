//! How the values of options are written: as text that the command line reads, or as JSON.

use crate::names::{Named, name_of};
use crate::values::{FrameRange, GroupRule};
use manylight::math::UVec2;
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// The word of a value.
pub(super) fn word<T: Named, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    name_of(value).serialize(to)
}

/// The word of a value that may be absent.
pub(super) fn optional_word<T: Named, S: Serializer>(
    value: &Option<T>,
    to: S,
) -> Result<S::Ok, S::Error> {
    value.as_ref().and_then(name_of).serialize(to)
}

/// A size as `WIDTHxHEIGHT`.
pub(super) fn size<S: Serializer>(size: &Option<UVec2>, to: S) -> Result<S::Ok, S::Error> {
    let text = size.map(|size| format!("{}x{}", size.x, size.y));
    text.serialize(to)
}

/// The name of a file.
pub(super) fn path<S: Serializer>(path: &Option<PathBuf>, to: S) -> Result<S::Ok, S::Error> {
    let text = path.as_ref().map(|path| path.display().to_string());
    text.serialize(to)
}

/// Frames as `A..B`.
pub(super) fn frames<S: Serializer>(frames: &Option<FrameRange>, to: S) -> Result<S::Ok, S::Error> {
    frames.map(|frames| frames.to_string()).serialize(to)
}

/// Words, separated by commas.
pub(super) fn list<T: clap::ValueEnum, S: Serializer>(
    values: &[T],
    to: S,
) -> Result<S::Ok, S::Error> {
    let words = values.iter().filter_map(T::to_possible_value);
    let words: Vec<_> = words.map(|word| word.get_name().to_owned()).collect();
    to.serialize_str(&words.join(","))
}

/// Rules of light groups, separated by commas.
pub(super) fn group_rules<S: Serializer>(rules: &[GroupRule], to: S) -> Result<S::Ok, S::Error> {
    let words = rules.iter().map(ToString::to_string);
    to.serialize_str(&words.collect::<Vec<_>>().join(","))
}

/// Parameters of a scene by name.
pub(super) fn defines<S: Serializer>(
    defines: &[(String, String)],
    to: S,
) -> Result<S::Ok, S::Error> {
    to.collect_map(defines.iter().map(|(name, value)| (name, value)))
}
