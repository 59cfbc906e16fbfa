//! Files of the frames of a walkthrough.

use crate::frame_files::FrameFiles;
use std::path::{Path, PathBuf};

/// The file of frame `number`, counted from 1, for the name `path` of all frames, such as
/// `walk-####.exr`: the number is in the place of the last `#`s, or before the extension.
pub fn frame_file(path: &Path, number: u32) -> PathBuf {
    FrameFiles::of(path).file(number)
}
