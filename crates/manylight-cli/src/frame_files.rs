//! Names of the files of frames.

use crate::failure::Failure;
use manylight_io::{FileError, is_same_file, shown_path};
use std::fs;
use std::path::{Path, PathBuf};

/// Digits of the number in a name without `#`.
const DIGITS: usize = 4;

/// The files of frames, such as `walk-####.exr`: the number of a frame is in the place of the last
/// run of `#`, with as many digits, or before the extension.
pub(crate) struct FrameFiles<'p> {
    path: &'p Path,
    /// The name before the number.
    before: String,
    digits: usize,
    /// The name after the number.
    after: String,
}

impl<'p> FrameFiles<'p> {
    pub(crate) fn of(path: &'p Path) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if let Some(last) = name.rfind('#') {
            let before = name[..last].trim_end_matches('#');
            return FrameFiles {
                path,
                before: before.to_owned(),
                digits: last + 1 - before.len(),
                after: name[last + 1..].to_owned(),
            };
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        FrameFiles {
            path,
            before: format!("{stem}."),
            digits: DIGITS,
            after: format!(".{extension}"),
        }
    }

    /// The file of a frame.
    pub(crate) fn file(&self, frame: u32) -> PathBuf {
        let FrameFiles { before, after, .. } = self;
        let digits = self.digits;
        self.path
            .with_file_name(format!("{before}{frame:0digits$}{after}"))
    }

    /// The numbers of the frames that have files, which are successive.
    ///
    /// # Errors
    /// The folder cannot be read, there is no such file, or a number between two others is missing.
    pub(crate) fn existing(&self) -> Result<Vec<u32>, Failure> {
        let folder = match self.path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let unreadable = |error| Failure::from(FileError::unreadable(folder, error));
        let mut frames = Vec::new();
        for entry in fs::read_dir(folder).map_err(unreadable)? {
            let name = entry.map_err(unreadable)?.file_name();
            frames.extend(self.number_in(&name.to_string_lossy()));
        }
        frames.sort_unstable();
        let Some(&first) = frames.first() else {
            return Err(Failure::usage(
                format!("found no frames such as {}", shown_path(&self.file(1))),
                "give the name that `manylight render --frames` or --cameras had as its output",
            ));
        };
        match (first..)
            .zip(&frames)
            .find(|(expected, found)| expected != *found)
        {
            None => Ok(frames),
            Some((missing, _)) => Err(Failure::usage(
                format!("the file {} is missing", shown_path(&self.file(missing))),
                "render this frame, or move the others to another folder",
            )),
        }
    }

    /// The frame that `file` is of; `None` for other files.
    pub(crate) fn frame_of(&self, file: &Path) -> Option<u32> {
        let number = self.number_in(&file.file_name()?.to_string_lossy())?;
        is_same_file(&self.file(number), file).then_some(number)
    }

    /// The frame number in the name of a file; `None` for names of other files.
    fn number_in(&self, name: &str) -> Option<u32> {
        let number = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let number = number.parse().ok()?;
        (self.file(number).file_name()? == name).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_number_of_the_frame() {
        let named = |path: &str, frame| {
            let files = FrameFiles::of(Path::new(path));
            files.file(frame).display().to_string()
        };
        assert_eq!(named("a/walk.exr", 7), "a/walk.0007.exr");
        assert_eq!(named("walk-##.exr", 7), "walk-07.exr");
        assert_eq!(named("#.png", 123), "123.png");
        assert_eq!(named("a#/é##x.png", 5), "a#/é05x.png");
        assert_eq!(named("walk.a.exr", 12345), "walk.a.12345.exr");
    }

    #[test]
    fn numbers_are_found_in_names() {
        let found = |path: &str, name: &str| FrameFiles::of(Path::new(path)).number_in(name);
        assert_eq!(found("walk-##.exr", "walk-07.exr"), Some(7));
        assert_eq!(found("walk-##.exr", "walk-123.exr"), Some(123));
        for other in [
            "walk-7.exr",
            "walk-007.exr",
            "walk-+7.exr",
            "walk-07.png",
            "walk-.exr",
        ] {
            assert_eq!(found("walk-##.exr", other), None, "{other}");
        }
        assert_eq!(found("walk.exr", "walk.0012.exr"), Some(12));
        assert_eq!(found("walk.exr", "walk.exr"), None);
    }

    #[test]
    fn existing_frames_are_successive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a-#.exr");
        let files = FrameFiles::of(&path);
        assert!(matches!(files.existing(), Err(Failure::Usage { .. })));
        for frame in [4, 2, 3] {
            fs::write(files.file(frame), "").unwrap();
        }
        assert_eq!(files.existing().unwrap(), [2, 3, 4]);
        fs::write(files.file(7), "").unwrap();
        let missing = files.existing().unwrap_err().to_string();
        assert!(missing.contains("a-5.exr"), "{missing}");
        let nowhere = folder.path().join("nowhere/a-#.exr");
        assert!(matches!(
            FrameFiles::of(&nowhere).existing(),
            Err(Failure::File(_))
        ));
    }
}
