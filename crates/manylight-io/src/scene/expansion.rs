//! A bound for text that is made from other text: included files and parameters. Ten files that each include the next one ten times make
//! ten thousand million files.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Most text that is made, as a multiple of the text in the files.
const LARGEST_RATIO: usize = 100;
/// Bytes that small files may make in any case.
const ALWAYS_ALLOWED: usize = 4 << 20;
/// Most inclusions: ten times those of the largest public scenes.
const MOST_INCLUSIONS: usize = 20_000;

/// The text of a scene so far.
#[derive(Default)]
pub(super) struct Expansion {
    /// The files that have been read.
    files: HashSet<PathBuf>,
    /// Bytes of these files.
    given: usize,
    /// Bytes of all inclusions and of texts with parameters.
    made: usize,
    inclusions: usize,
    /// Whether the bound has been exceeded.
    exceeded: bool,
}

/// The bound is exceeded. The message is given the first time only.
pub(super) struct Exceeded {
    pub(super) message: Option<String>,
}

impl Expansion {
    /// Adds an inclusion of `path`, which has this many bytes.
    ///
    /// # Errors
    /// The bound is exceeded.
    pub(super) fn include(&mut self, path: &Path, bytes: usize) -> Result<(), Exceeded> {
        if self.files.insert(path.to_owned()) {
            self.given += bytes;
        }
        self.inclusions += 1;
        self.add(bytes)
    }

    /// Adds bytes that were made of parameters.
    ///
    /// # Errors
    /// The bound is exceeded.
    pub(super) fn substitute(&mut self, bytes: usize) -> Result<(), Exceeded> {
        self.add(bytes)
    }

    fn add(&mut self, bytes: usize) -> Result<(), Exceeded> {
        self.made = self.made.saturating_add(bytes);
        let most = (self.given.saturating_mul(LARGEST_RATIO)).max(ALWAYS_ALLOWED);
        if !self.exceeded && self.made <= most && self.inclusions <= MOST_INCLUSIONS {
            return Ok(());
        }
        let message = format!(
            "included files and parameters make more than {most} bytes from {} bytes of files, or more than {MOST_INCLUSIONS} inclusions",
            self.given
        );
        let message = (!self.exceeded).then_some(message);
        self.exceeded = true;
        Err(Exceeded { message })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_bounded_by_the_text_of_the_files() {
        let mut expansion = Expansion::default();
        for _ in 0..100 {
            assert!(expansion.include("a".as_ref(), 1 << 20).is_ok());
        }
        let exceeded = expansion.include("a".as_ref(), 1 << 20).unwrap_err();
        assert!(exceeded.message.unwrap().contains("from 1048576 bytes"));
        assert!(expansion.substitute(0).unwrap_err().message.is_none());
    }

    #[test]
    fn inclusions_of_empty_files_are_bounded() {
        let mut expansion = Expansion::default();
        let included = (0..).take_while(|_| expansion.include("a".as_ref(), 0).is_ok());
        assert_eq!(included.count(), MOST_INCLUSIONS);
    }
}
