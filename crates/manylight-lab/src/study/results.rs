//! The results of a study, one file per run.

use super::record::{Record, SCHEMA};
use super::runs::Run;
use crate::error::LabError;
use manylight_io::write_file;
use manylight_io::{FileError, FileErrorKind};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The results of the runs of a plan, stored in a folder with one JSON file per run.
#[derive(Debug, Default)]
pub struct Results {
    folder: PathBuf,
    records: BTreeMap<String, Record>,
}

impl Results {
    /// Reads the results of `runs` in `folder`; missing files are skipped.
    ///
    /// # Errors
    /// A file cannot be read, or is not a result.
    pub fn read(folder: &Path, runs: &[Run]) -> Result<Self, LabError> {
        let mut results = Results {
            folder: folder.to_owned(),
            records: BTreeMap::new(),
        };
        for key in runs.iter().map(Run::key) {
            let path = results.path(&key);
            let text = match std::fs::read_to_string(&path) {
                Ok(text) => text,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => return Err(FileError::unreadable(&path, error).into()),
            };
            results.records.insert(key, parse(&path, &text)?);
        }
        Ok(results)
    }

    /// The result of the run with this key.
    pub fn get(&self, key: &str) -> Option<&Record> {
        self.records.get(key)
    }

    /// Stores a result in memory and in its file. The file is replaced atomically.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn put(&mut self, key: String, record: Record) -> Result<(), LabError> {
        let path = self.path(&key);
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| FileError::unwritable(&self.folder, error))?;
        let mut text = serde_json::to_string_pretty(&record)
            .map_err(|error| FileError::unwritable(&path, error.into()))?;
        text.push('\n');
        write_file(&path, text.as_bytes())?;
        self.records.insert(key, record);
        Ok(())
    }

    /// Path of the file of a result.
    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.json"))
    }

    /// Results in memory, for tests.
    #[cfg(test)]
    pub(super) fn of(records: impl IntoIterator<Item = (String, Record)>) -> Self {
        Results {
            folder: PathBuf::new(),
            records: records.into_iter().collect(),
        }
    }
}

/// Reads the text of a result file.
fn parse(path: &Path, text: &str) -> Result<Record, LabError> {
    let failure = |line, column, message| {
        LabError::from(FileError {
            path: path.to_owned(),
            line,
            column,
            message,
            kind: FileErrorKind::Malformed,
        })
    };
    let record: Record = serde_json::from_str(text).map_err(|error| {
        let place = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
        let message =
            format!("not a result of a study: {error}; delete the file to repeat the run");
        failure(place(error.line()), place(error.column()), message)
    })?;
    if record.schema != SCHEMA {
        let message = format!("found the schema {}, expected {SCHEMA}", record.schema);
        return Err(failure(None, None, message));
    }
    Ok(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_no_result_is_refused_with_its_place() {
        let message = parse(Path::new("r/a.json"), "{\n  \"schema\": 3\n}")
            .unwrap_err()
            .to_string();
        assert!(message.contains("r/a.json:2:13"), "{message}");
    }
}
