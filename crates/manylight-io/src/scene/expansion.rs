//! A bound for text that is made from other text: included files and parameters. Ten files that each include the next one ten times make
//! ten thousand million files.

use super::growth::{Bound, Exceeded, Growth};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Bytes of text from the bytes of the files.
const BOUND: Bound = Bound {
    ratio: 100,
    always_allowed: 4 << 20,
};
/// Most inclusions: ten times those of the largest public scenes.
const MOST_INCLUSIONS: usize = 20_000;
/// Most inclusions in a scene of little text.
const FREE_INCLUSIONS: usize = 1000;
/// Bytes of text for each further inclusion: less than a statement that includes a file has.
const BYTES_PER_INCLUSION: usize = 10;

/// The text of a scene so far.
pub(super) struct Expansion {
    /// The files that have been read.
    files: HashSet<PathBuf>,
    /// From the bytes of these files to those of all inclusions and of texts with parameters.
    growth: Growth,
    inclusions: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Expansion {
            files: HashSet::new(),
            growth: Growth::new(0, BOUND),
            inclusions: 0,
        }
    }
}

impl Expansion {
    /// Adds an inclusion of `path`, which has this many bytes.
    ///
    /// # Errors
    /// The bound is exceeded.
    pub(super) fn include(&mut self, path: &Path, bytes: usize) -> Result<(), Exceeded> {
        if self.files.insert(path.to_owned()) {
            self.growth.give(bytes);
        }
        self.inclusions += 1;
        self.add(bytes)
    }

    /// Bytes of the files that have been read, each once.
    pub(super) fn text_bytes(&self) -> usize {
        self.growth.given()
    }

    /// Adds bytes that were made of parameters.
    ///
    /// # Errors
    /// The bound is exceeded.
    pub(super) fn substitute(&mut self, bytes: usize) -> Result<(), Exceeded> {
        self.add(bytes)
    }

    fn add(&mut self, bytes: usize) -> Result<(), Exceeded> {
        let most_inclusions =
            (FREE_INCLUSIONS + self.text_bytes() / BYTES_PER_INCLUSION).min(MOST_INCLUSIONS);
        let has_too_many = self.inclusions > most_inclusions;
        let bytes = if has_too_many { usize::MAX } else { bytes };
        self.growth.make(bytes, |most, given| {
            format!(
                "included files and parameters make more than {most} bytes from {given} bytes of files, or more than {most_inclusions} inclusions"
            )
        })
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
        assert_eq!(included.count(), FREE_INCLUSIONS);
    }

    #[test]
    fn longer_text_may_include_more_files() {
        let mut expansion = Expansion::default();
        assert!(expansion.include("list".as_ref(), 1 << 20).is_ok());
        let included = (1..).take_while(|_| expansion.include("a".as_ref(), 10).is_ok());
        assert_eq!(included.count(), MOST_INCLUSIONS - 1);
    }
}
