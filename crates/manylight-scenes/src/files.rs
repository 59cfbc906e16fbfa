//! The files of a scene: `scene.xml`, `meshes/NAME.ply` and `textures/NAME.png`.

use crate::scene::Scene;
use crate::{mitsuba, ply};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// All files of a scene, as (path relative to the scene's folder, bytes). The scene file is first.
///
/// # Errors
/// Returns an error if a texture cannot be compressed.
pub fn of(scene: &Scene) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let mut files = vec![(
        PathBuf::from("scene.xml"),
        mitsuba::encode(scene).into_bytes(),
    )];
    for (name, mesh) in &scene.meshes {
        files.push((format!("meshes/{name}.ply").into(), ply::encode(mesh)));
    }
    for (name, image) in &scene.textures {
        files.push((format!("textures/{name}.png").into(), image.encode()?));
    }
    Ok(files)
}

/// Writes the files of a scene into `folder`, which is created if it does not exist.
///
/// Each file is written under a temporary name and then renamed, so no incomplete file has its final name.
///
/// # Errors
/// Returns the first error of the file system. Files written before it stay.
pub fn write(scene: &Scene, folder: &Path) -> io::Result<()> {
    for (name, bytes) in of(scene)? {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut unfinished = path.clone().into_os_string();
        unfinished.push(".part");
        fs::write(&unfinished, bytes)?;
        fs::rename(&unfinished, &path)?;
    }
    Ok(())
}
