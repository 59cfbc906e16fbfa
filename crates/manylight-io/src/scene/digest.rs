//! A digest of the files of a scene, by which a picture says what it shows.

use crate::file_error::{FileError, read_bytes};
use crate::hex::hex;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// SHA-256 of all files of a scene, in hexadecimal digits: of the lines `DIGEST  NAME`, one per
/// file, as the program `sha256sum` prints them. Names are relative to the folder of the scene,
/// files in other folders have their name alone, and lines are sorted by name, then by digest. The
/// digest does not change when the folder of the scene is moved.
///
/// # Errors
/// A file cannot be read.
pub fn scene_digest(scene: &Path, files: &[PathBuf]) -> Result<String, FileError> {
    let folder = scene.parent().unwrap_or(Path::new(""));
    let line = |file: &PathBuf| {
        let digest = hex(&Sha256::digest(read_bytes(file)?));
        let name = match file.strip_prefix(folder) {
            Ok(inside) if !leaves_folder(inside) => inside,
            _ => Path::new(file.file_name().unwrap_or_default()),
        };
        Ok((name.to_string_lossy().replace('\\', "/"), digest))
    };
    let mut lines = files
        .par_iter()
        .map(line)
        .collect::<Result<Vec<_>, FileError>>()?;
    lines.sort();
    let mut whole = Sha256::new();
    for (name, digest) in lines {
        whole.update(format!("{digest}  {name}\n"));
    }
    Ok(hex(&whole.finalize()))
}

/// Whether a relative path leads out of its folder.
fn leaves_folder(path: &Path) -> bool {
    use std::path::Component;
    path.components()
        .any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_those_of_sha256sum() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, content).unwrap();
            path
        };
        let files = [file("scene.xml", "abc"), file("meshes/a.ply", "")];
        // printf 'abc' > scene.xml; : > meshes/a.ply; sha256sum meshes/a.ply scene.xml | sha256sum
        assert_eq!(
            scene_digest(&files[0], &files).unwrap(),
            "54e141c4e7d5e20b7f87faeb6a0985a5178f29471ae52f9ab46b6927e4be27d2"
        );
        assert!(scene_digest(&files[0], &[folder.path().join("absent")]).is_err());
    }
}
