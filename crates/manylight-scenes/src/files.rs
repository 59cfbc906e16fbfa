//! Scenes as folders of files.

use crate::scene::Scene;
use crate::{mitsuba, ply};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The files of a scene, with their paths in its folder.
pub fn of(scene: &Scene) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let mut files = vec![(
        PathBuf::from("scene.xml"),
        mitsuba::encode(scene).into_bytes(),
    )];
    for (name, mesh) in &scene.meshes {
        files.push((format!("meshes/{name}.ply").into(), ply::encode(mesh)));
    }
    for (name, picture) in &scene.pictures {
        files.push((format!("textures/{name}.png").into(), picture.encode()?));
    }
    Ok(files)
}

/// Writes the files of a scene into a folder, which is made where it is not there. Each file appears whole or not at all.
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
