//! Reading of part files: the header first, then the sums of each group of arrays.

use super::array_file::{ArrayError, ArrayFile};
use super::header::{PART, PartHeader};
use crate::file_error::FileError;
use manylight::film::arrays::sums_of_arrays;
use manylight::film::{Film, PassSums};
use std::path::Path;

/// A part file with its header in memory.
#[derive(Debug)]
pub struct PartFile {
    file: ArrayFile,
    header: PartHeader,
}

impl PartFile {
    /// Reads the header of a file. The arrays are not read: see [`PartFile::verify`].
    ///
    /// # Errors
    /// The file cannot be read, or is no part file of this version.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let (file, header) = ArrayFile::open(path, PART)?;
        Ok(PartFile { file, header })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The header.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Prefixes of the names of arrays, one per sums of passes.
    pub fn groups(&self) -> Vec<String> {
        self.file.groups()
    }

    /// Compares the checksum: reads the whole file.
    ///
    /// # Errors
    /// The file cannot be read, or is damaged.
    pub fn verify(&self) -> Result<(), FileError> {
        self.file.verify()
    }

    /// An empty film of the size and layers of the header; `group` is one of its groups.
    ///
    /// # Errors
    /// The header contradicts itself, or names a layer that this version does not know.
    pub fn film(&self, group: &str) -> Result<Film, FileError> {
        let film = &self.header.film;
        let [width, height] = film.crop_size.map(|n| n as usize);
        // The file has this many pixels: memory for a film is taken after this check.
        let name = format!("{group}sum.beauty");
        if self.file.shape(&name) != Some(&[height, width, 3]) {
            let message = format!(
                "array {name} does not have {width} x {height} pixels: the file is damaged"
            );
            return Err(FileError::malformed(self.path(), message));
        }
        film.film()
            .map_err(|message| FileError::malformed(self.path(), message))
    }

    /// The sums of a group of arrays, for `film`.
    ///
    /// # Errors
    /// The file cannot be read, or the arrays are missing or do not fit.
    pub fn sums(&self, group: &str, film: &Film) -> Result<PassSums, FileError> {
        self.file.read(|| {
            let file = self.file.reopen()?;
            sums_of_arrays(film, |name, shape| {
                let name = format!("{group}{name}");
                let (found, values) = self.file.array(&file, &name)?;
                match found == shape {
                    true => Ok(values),
                    false => Err(ArrayError::Content(format!(
                        "array {name}: found the shape {found:?}, expected {shape:?}"
                    ))),
                }
            })
        })
    }
}
