//! Files of kept virtual lights.

use super::array_file::{ArrayFile, Kind};
use super::write::write_arrays;
use crate::file_error::FileError;
use manylight::integrators::{KeptLights, LightsContext};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// Files of virtual lights.
const LIGHTS: Kind = Kind {
    key: "manylight.lights",
    format: 1,
    name: "a file of virtual lights",
};

/// What a file of virtual lights says about them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightsHeader {
    /// Version of the layout.
    pub format: u32,
    /// What the render must agree with that uses the lights (name: value).
    pub scene: Map<String, Value>,
    /// Options of the method, as words of a command.
    pub options: Vec<String>,
    /// Number of passes that have lights.
    pub passes: u32,
    /// Names of the light groups; empty if they are not told apart.
    pub light_groups: Vec<String>,
}

impl LightsHeader {
    /// The header of lights of `passes` passes.
    pub fn new(
        scene: Map<String, Value>,
        options: Vec<String>,
        passes: u32,
        light_groups: Vec<String>,
    ) -> Self {
        LightsHeader {
            format: LIGHTS.format,
            scene,
            options,
            passes,
            light_groups,
        }
    }
}

/// A file of virtual lights with its header in memory.
#[derive(Debug)]
pub struct LightsFile {
    file: ArrayFile,
    header: LightsHeader,
}

impl LightsFile {
    /// Reads the header of a file, and compares the checksum.
    ///
    /// # Errors
    /// The file cannot be read, is damaged, or holds no lights of this version.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let (file, header) = ArrayFile::open(path, LIGHTS)?;
        file.verify()?;
        Ok(LightsFile { file, header })
    }

    /// The header.
    pub fn header(&self) -> &LightsHeader {
        &self.header
    }

    /// SHA-256 of the file.
    pub fn digest(&self) -> &str {
        self.file.digest()
    }

    /// The lights.
    ///
    /// # Errors
    /// The file cannot be read, or the arrays do not belong to the method or the scene of `cx`.
    pub fn lights<'s>(&self, cx: &LightsContext<'s>) -> Result<KeptLights<'s>, FileError> {
        self.file.read(|| {
            let file = self.file.reopen()?;
            KeptLights::of_arrays(cx, |group, name| {
                self.file.array(&file, &format!("{}{name}", prefix(group)))
            })
        })
    }
}

/// Begin of the names of the arrays of a group of passes.
fn prefix(group: usize) -> String {
    format!("group.{group}.")
}

/// Writes virtual lights. The file is replaced as a whole or not at all. One array is in memory at a
/// time, beside the lights.
///
/// # Errors
/// The file cannot be written.
pub fn write_lights(
    path: &Path,
    header: &LightsHeader,
    lights: &KeptLights,
) -> Result<(), FileError> {
    let groups = lights.arrays().into_iter().enumerate();
    let groups: Vec<_> = groups.map(|(k, arrays)| (prefix(k), arrays)).collect();
    write_arrays(path, LIGHTS, header, &groups)
}
