//! Part files.

use crate::folder::with_file;
use crate::messages::check_file_error;
use manylight_io::FileError;
use manylight_io::part::PartFile;

/// Reads a part file as `merge` does; the checksum is compared, and damage behind it is read
/// nevertheless.
pub(crate) fn check(input: &[u8]) {
    with_file(input, "a.part", |path| {
        if let Err(error) = read(path) {
            check_file_error(&error);
        }
    });
}

fn read(path: &std::path::Path) -> Result<(), FileError> {
    let part = PartFile::open(path)?;
    if let Err(error) = part.verify() {
        check_file_error(&error);
    }
    for group in part.groups() {
        let film = part.film(&group)?;
        part.sums(&group, &film)?;
    }
    Ok(())
}
