//! Bounds for what is made from the data of a file, any number of the parts of which may use the
//! same data, and for text that is made from other text: included files and parameters. Ten files
//! that each include the next one ten times make ten thousand million files.

use super::sink::{FileSpan, Sink};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Most bytes that may be made: the larger of both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// As a multiple of the given ones.
    pub(super) ratio: usize,
    /// For small files.
    pub(super) always_allowed: usize,
}

impl Exceeded {
    /// Adds an error at `span`, the first time.
    pub(super) fn report(self, sink: &Sink, code: &'static str, span: FileSpan) {
        if let Some(message) = self.message {
            sink.error_at(code, span, message);
        }
    }
}

/// What is made so far, and the bound.
#[derive(Debug)]
pub(super) struct Growth {
    /// Bytes of data in the files.
    given: usize,
    /// Bytes made from them.
    made: usize,
    bound: Bound,
    exceeded: bool,
}

/// The bound is exceeded. The message is given the first time only.
pub(super) struct Exceeded {
    pub(super) message: Option<String>,
}

impl Growth {
    /// For `given` bytes of data.
    pub(super) fn new(given: usize, bound: Bound) -> Self {
        Growth {
            given,
            made: 0,
            bound,
            exceeded: false,
        }
    }

    /// Bytes of data so far.
    pub(super) fn given(&self) -> usize {
        self.given
    }

    /// Adds data of one more file.
    pub(super) fn give(&mut self, bytes: usize) {
        self.given += bytes;
    }

    /// Adds bytes that are made. `message` gets the most bytes that may be made, and the bytes of
    /// data.
    ///
    /// # Errors
    /// The bound is exceeded, now or before.
    pub(super) fn make(
        &mut self,
        bytes: usize,
        message: impl FnOnce(usize, usize) -> String,
    ) -> Result<(), Exceeded> {
        self.made = self.made.saturating_add(bytes);
        let most = self.given.saturating_mul(self.bound.ratio);
        let most = most.max(self.bound.always_allowed);
        if !self.exceeded && self.made <= most {
            return Ok(());
        }
        let message = (!self.exceeded).then(|| message(most, self.given));
        self.exceeded = true;
        Err(Exceeded { message })
    }
}

/// Bytes of text from the bytes of the files.
const EXPANSION: Bound = Bound {
    ratio: 100,
    always_allowed: 4 << 20,
};
/// Most inclusions: ten times those of the largest public scenes.
const MAX_INCLUSIONS: usize = 20_000;
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
            growth: Growth::new(0, EXPANSION),
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
            (FREE_INCLUSIONS + self.text_bytes() / BYTES_PER_INCLUSION).min(MAX_INCLUSIONS);
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
    fn what_is_made_is_bounded_by_the_data() {
        let mut growth = Growth::new(
            1 << 20,
            Bound {
                ratio: 100,
                always_allowed: 64 << 20,
            },
        );
        let mut make = |bytes| growth.make(bytes, |most, given| format!("{most} from {given}"));
        for _ in 0..8 {
            assert!(make(12 << 20).is_ok());
        }
        let exceeded = make(12 << 20).unwrap_err();
        assert_eq!(exceeded.message.unwrap(), "104857600 from 1048576");
        assert!(make(0).unwrap_err().message.is_none());
    }

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
        assert_eq!(included.count(), MAX_INCLUSIONS - 1);
    }
}
